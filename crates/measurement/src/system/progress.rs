//! The bar on standard error: what is being measured and how long it will take.

use std::fmt::Write;
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use presentation::outside::line;

/// The share of the file that is read, while one is.
fn write_loaded(_: &ProgressState, to: &mut dyn Write) {
    if let Some(share) = scene_loading::progress::share() {
        let _ = write!(to, "{:3.0}% of ", 100.0 * share);
    }
}

/// How long it may go on: nothing is known of that before the first step.
fn write_left(state: &ProgressState, to: &mut dyn Write) {
    let _ = match state.pos() {
        0 => write!(to, "time left not known yet"),
        _ => write!(to, "about {} left", HumanDuration(state.eta())),
    };
}

/// A bar with the time left, or nothing at all.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    /// Where the bar follows a time budget: that budget.
    budget: Option<Duration>,
}

impl Default for Progress {
    fn default() -> Self {
        Self::hidden()
    }
}

impl Progress {
    /// A bar over `steps` steps of about equal cost, or over a time budget.
    pub fn new(visible: bool, steps: u64, budget: Option<Duration>) -> Self {
        let length = budget.map_or(steps, |b| b.as_millis() as u64).max(1);
        let target =
            if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(length), target);
        if let Ok(style) = ProgressStyle::with_template(
            "{bar:24} {percent:>3}%  {elapsed} elapsed, {left}  {loaded}{wide_msg}",
        ) {
            let style = style.with_key("loaded", write_loaded);
            bar.set_style(match budget {
                None => style.with_key("left", write_left),
                // what is asked for is known from the start
                Some(budget) => {
                    style.with_key("left", move |state: &ProgressState, to: &mut dyn Write| {
                        let left = budget.saturating_sub(state.elapsed());
                        let _ = write!(to, "about {} left", HumanDuration(left));
                    })
                }
            });
        }
        if visible {
            bar.enable_steady_tick(Duration::from_millis(500));
        }
        Self { bar, budget }
    }

    /// Progress of loading a scene, for commands that do little else.
    pub fn of_loading(visible: bool, scene: &str) -> Self {
        let progress = Self::new(visible, 1, None);
        if let Ok(style) = ProgressStyle::with_template("{elapsed}  {loaded}{wide_msg}") {
            progress.bar.set_style(style.with_key("loaded", write_loaded));
        }
        progress.message(format!("{scene}: loading"));
        progress
    }

    pub fn hidden() -> Self {
        Self::new(false, 1, None)
    }

    pub fn message(&self, message: impl Into<String>) {
        if !self.bar.is_hidden() {
            self.bar.set_message(line(&message.into()).into_owned());
        }
    }

    /// A step is done; `now` is the time since the run began.
    pub fn step(&self, now: Duration) {
        match self.budget {
            Some(budget) => self.bar.set_position(now.min(budget).as_millis() as u64),
            None => self.bar.inc(1),
        }
    }

    /// So many steps are behind us, made or not: rows that are not timed, or a scene that failed,
    /// leave some out.
    pub fn reach(&self, steps: u64) {
        if self.budget.is_none() {
            self.bar.set_position(steps);
        }
    }

    /// Prints without the bar in the way.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_are_left_out_count_when_their_scene_is_over() {
        let steps = Progress::new(false, 20, None);
        (0..3).for_each(|_| steps.step(Duration::ZERO));
        steps.reach(10);
        assert_eq!(steps.bar.position(), 10);
        steps.step(Duration::ZERO);
        assert_eq!(steps.bar.position(), 11);
    }

    #[test]
    fn progress_of_a_time_budget_follows_time() {
        let time = Progress::new(false, 20, Some(Duration::from_secs(2)));
        time.step(Duration::from_millis(700));
        time.reach(10);
        assert_eq!(time.bar.position(), 700);
        time.step(Duration::from_secs(9));
        assert_eq!(time.bar.position(), 2000);
    }
}
