//! The time budget of a run, how much of it each scene has, and the bar that shows how far it is.

use std::time::Duration;

use crate::context::Context;
use measurement::plan::{Plan, Rounds};
use measurement::system::progress::Progress;

/// The time budget of a run, if it has one.
pub struct Budget {
    total: Option<Duration>,
    /// When this part of the run began.
    start: Duration,
    /// Shares of the scenes in earlier parts of the run.
    before: Duration,
}

impl Budget {
    /// Budget of a run whose part begins `now`, with this many scenes finished before.
    pub fn new(plan: &Plan<'_>, now: Duration, finished: usize) -> Self {
        let (total, before) = match plan.rounds {
            Rounds::Budget { total, .. } => {
                let share = finished as f64 / plan.scenes.len().max(1) as f64;
                (Some(total), total.mul_f64(share))
            }
            Rounds::Fixed(_) => (None, Duration::ZERO),
        };
        Self { total, start: now, before }
    }

    /// When the rounds of the next scene end: what is left of the budget, shared by the scenes
    /// left.
    pub fn deadline(&self, now: Duration, left: usize) -> Option<Duration> {
        Some(now + self.share(now, left)?)
    }

    /// Share of the budget for the next scene.
    pub fn share(&self, now: Duration, left: usize) -> Option<Duration> {
        let spent = now.saturating_sub(self.start) + self.before;
        let left = u32::try_from(left.max(1)).unwrap_or(u32::MAX);
        Some(self.total?.saturating_sub(spent) / left)
    }
}

/// Steps of the bar for the scene at that place: each row is checked, timed in each round,
/// rendered.
pub fn steps_of(plan: &Plan<'_>, scene: usize) -> u64 {
    let rounds = match plan.rounds {
        Rounds::Fixed(n) => n,
        Rounds::Budget { at_least, .. } => at_least,
    };
    (plan.rows_in(scene) * (rounds * plan.processes as usize + 2)) as u64
}

/// The bar of a run.
pub fn progress(context: &Context<'_>, plan: &Plan<'_>, steps: u64) -> Progress {
    let budget = match plan.rounds {
        Rounds::Budget { total, .. } => Some(total),
        Rounds::Fixed(_) => None,
    };
    Progress::new(context.shows_progress(), steps, budget)
}
