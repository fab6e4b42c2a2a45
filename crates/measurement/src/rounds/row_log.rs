//! Progress messages while the rows of a scene are measured.

/// Who is told how far the rows of a scene are, for the case that one of them ends the program.
pub trait RowLog {
    /// The row with that label is begun: built and checked, timed for the first time, or rendered.
    fn row_begins(&self, label: &str);
    /// The rows begun so far ended well.
    fn rows_passed(&self);
}
