//! A wrong answer.

/// A wrong answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// Index of the ray in the round.
    pub ray: usize,
    /// What was said and what is right.
    pub what: String,
}
