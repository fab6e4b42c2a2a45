//! Rows that end the program, out of memory say: the journal notes which row is begun, and one that
//! was begun too often without an end is left out, so that a resumed run gets past it.

use std::cell::{Cell, RefCell};

use crate::error::Error;
use measurement::journal::Journal;
use measurement::journal::lines::{DeathCounts, Line};
use measurement::plan::Plan;
use measurement::rounds::error::MeasureError;
use measurement::rounds::scope::RowLog;
use measurement::rounds::trial::TrialOutcome;

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
