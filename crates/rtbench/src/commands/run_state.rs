//! What a run keeps while it goes on: its journal, what is finished, and how much of its time budget
//! each scene has.
//!
//! The journal notes which row is begun. One that was begun too often without an end (it ended the
//! program, out of memory say) is left out, so that a resumed run gets past it.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;

use crate::error::Error;
use measurement::journal::Journal;
use measurement::journal::lines::{DeathCounts, Line};
use measurement::plan::Plan;
use measurement::record::summary::summarize;
use measurement::record::{RunRecord, SceneRecord};
use measurement::rounds::MeasureError;
use measurement::rounds::scope::RowLog;
use measurement::rounds::trial::TrialOutcome;
use studies::run::conclusions::conclude_run;
use studies::sweep::sizes::quantities;

/// State of a run beside its outputs, including results of an earlier part.
#[derive(Debug, Default)]
pub struct RunState {
    /// Journal that finished scenes are appended to.
    pub journal: Option<Journal>,
    /// Scenes that are finished already, by their places in the plan.
    pub finished: BTreeMap<usize, SceneRecord>,
    /// How often each row ended the program.
    pub deaths: DeathCounts,
    /// Number of finished scenes, for progress display.
    pub count: Arc<AtomicUsize>,
}

impl RunState {
    pub fn append(&mut self, line: impl FnOnce() -> Line) -> Result<(), Error> {
        self.journal.as_mut().map_or(Ok(()), |journal| Ok(journal.append(&line())?))
    }
}

/// Returns whether results are written with so many scenes. What the journal has is not lost: they
/// are written with each of the first scenes, then ever less often, so that a run of many does not
/// write all of them each time.
pub fn is_due(scenes: usize) -> bool {
    scenes < 64 || scenes.is_multiple_of(scenes / 32)
}

/// Updates the summary over all scenes so far.
pub fn sum_up(record: &mut RunRecord) {
    record.summary = summarize(&record.scenes, &record.settings);
    // the sizes of one scene are no scenes to take means over
    if record.scale.is_none() {
        conclude_run(record);
    }
    if let Some(scale) = &mut record.scale {
        scale.slopes = quantities::slopes(&record.scenes);
    }
}

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
        let total = plan.rounds.budget();
        let share = finished as f64 / plan.scenes.len().max(1) as f64;
        Self { total, start: now, before: total.unwrap_or_default().mul_f64(share) }
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
    (plan.rows_in(scene) * (plan.rounds.at_least() * plan.processes as usize + 2)) as u64
}

/// The journal, as the rows of a scene see it.
pub struct RowJournal<'a> {
    journal: RefCell<Option<&'a mut Journal>>,
    /// A row is noted of which it is not noted that it passed.
    is_begun: Cell<bool>,
}

impl<'a> RowJournal<'a> {
    /// Over the journal of a run, if it has one.
    pub fn new(journal: Option<&'a mut Journal>) -> Self {
        Self { journal: RefCell::new(journal), is_begun: Cell::new(false) }
    }

    fn note(&self, line: &Line) {
        if let Some(journal) = self.journal.borrow_mut().as_deref_mut() {
            // a row that is not noted is tried once more after a death; what is finished is noted
            // with its errors
            let _ = journal.note(line);
        }
    }
}

impl RowLog for RowJournal<'_> {
    fn row_begins(&self, label: &str) {
        self.is_begun.set(true);
        self.note(&Line::Row(label.to_owned()));
    }

    fn rows_passed(&self) {
        if self.is_begun.replace(false) {
            self.note(&Line::Passed);
        }
    }
}

/// So often a row may end the program before it is left out, and a scene before its first row.
const DEATHS: usize = 2;

/// Refuses a scene that ended the program too often before its first row.
pub fn refuse_deadly(name: &str, scene: usize, deaths: &DeathCounts) -> Result<(), Error> {
    match deaths.get(&(scene, None)) {
        Some(&times) if times >= DEATHS => {
            Err(MeasureError::Deadly { scene: name.to_owned(), times }.into())
        }
        _ => Ok(()),
    }
}

/// Leaves out the rows of a scene that ended the program too often, as if their trials had.
pub fn skip_deadly(
    trials: &mut Vec<TrialOutcome>,
    plan: &Plan<'_>,
    scene: usize,
    deaths: &DeathCounts,
) {
    for (row, i) in plan.rows.iter().zip(0..) {
        let count = deaths.get(&(scene, Some(row.label()))).copied().unwrap_or(0);
        if count < DEATHS {
            continue;
        }
        trials.resize(plan.rows.len(), TrialOutcome::Ended { peak_bytes: None });
        if let Some(trial) = trials.get_mut(i) {
            *trial = TrialOutcome::Died(format!(
                "skipped: {count} times the program died while this row was built, checked or first timed \
                 (killed, or out of memory?)"
            ));
        }
    }
}
