//! Rows that are built and asked when somebody says so, and not in rounds: another process has its turn
//! between.

use crate::record::Sample;

/// Who says which row is next.
pub trait Laps: Sync {
    /// Waits for the label of the next row; none where no more is wanted.
    fn next(&self) -> Option<String>;

    /// Takes what the row took; none of a row that is not timed.
    fn made(&self, sample: Option<&Sample>);
}
