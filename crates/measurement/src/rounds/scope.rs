//! Context of the measurement of one scene, and who is told how it goes on.

use crate::answers::reference::Stage;
use crate::plan::Plan;
use crate::rays::batches::BatchSet;
use crate::record::Sample;
use crate::system::clock::Clock;
use crate::system::pools::Pools;
use crate::system::progress::Progress;
use accel_core::registry::Buildable;
use glam::DVec3;

/// Everything that the measurement of one scene works with.
#[derive(Clone, Copy)]
pub struct Scope<'a, 'r, S: Buildable> {
    pub plan: &'a Plan<'r>,
    pub stage: &'a Stage<'a, S>,
    pub lights: &'a [DVec3],
    /// All rays with the answers expected.
    pub all: &'a BatchSet<'a, S>,
    pub pools: &'a Pools,
    pub clock: &'a dyn Clock,
    pub progress: &'a Progress,
}

/// Chooses the next row.
pub trait Laps: Sync {
    /// Waits for the label of the next row; none where no more is wanted.
    fn next(&self) -> Option<String>;

    /// Takes what the row took; none of a row that is not timed.
    fn made(&self, sample: Option<&Sample>);
}

/// Receives the progress of the rows of a scene, in case one of them ends the program.
pub trait RowLog {
    /// The row with that label is begun: built and checked, timed for the first time, or rendered.
    fn row_begins(&self, label: &str);
    /// The rows begun so far ended well.
    fn rows_passed(&self);
}
