//! The parts of the page; their order is that of [`crate::report::SECTIONS`].

pub mod break_even;
pub mod counters;
pub mod machine;
pub mod run;
pub mod studies;

/// The places of rows among all, from 1: their numbers, however they are sorted.
fn places<R>(all: &[R], shown: &[&R]) -> Vec<usize> {
    let place = |row: &&R| all.iter().position(|other| std::ptr::eq(other, *row));
    shown.iter().map(|row| place(row).map_or(0, |place| place + 1)).collect()
}
