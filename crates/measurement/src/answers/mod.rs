//! Correctness of answers: brute force, the row asked first, the check of each row.

pub mod arbiter;
pub mod check;
pub mod judge;
pub mod oracle;
mod own_test;
pub mod reference;
