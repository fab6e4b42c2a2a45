//! Work that is timed.

/// What is timed of a variant.
pub trait Work {
    /// Undoes what the last run left, so that it cannot pass for this one's.
    fn prepare(&mut self) {}
    fn run(&mut self);
    /// Names of the parts that are timed one by one, in order; none where it is timed as a whole.
    fn parts(&self) -> Vec<String> {
        Vec::new()
    }
    /// The part of that number; all parts together are the work itself.
    fn run_part(&mut self, _part: usize) {
        self.run();
    }
    /// A number that changes with any answer of the last run.
    fn fingerprint(&self) -> u64;
}
