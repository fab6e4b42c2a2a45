//! Which answers are right: the oracle, the reference that it confirms, the check of each row.

pub mod check;
pub mod oracle;
pub mod reference;
