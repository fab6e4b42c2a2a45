//! The parts of the page; their order is that of [`crate::report::SECTIONS`].

pub mod break_even;
pub mod machine;
pub mod run;
pub mod studies;
