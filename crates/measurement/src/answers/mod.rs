//! Correctness of answers: the oracle, the reference that it confirms, the check of each row.

pub mod by_files;
pub mod check;
pub mod edges;
pub mod fault;
pub mod judge;
pub mod oracle;
mod own_test;
pub mod reference;
