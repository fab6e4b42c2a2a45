//! Work that is timed.

/// What is timed of a variant.
pub trait Work {
    /// Undoes what the last run left, so that it cannot pass for this one's.
    fn prepare(&mut self) {}
    /// The work itself.
    fn run(&mut self);
    /// A number that changes with any answer of the last run.
    fn fingerprint(&self) -> u64;
}
