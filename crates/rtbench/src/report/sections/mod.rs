//! The parts of the page, one per file; their order is that of [`crate::report::SECTIONS`].

pub mod accuracy;
pub mod break_even;
pub mod by_kind;
pub mod counters;
pub mod glossary;
pub mod headlines;
pub mod heat_maps;
pub mod lecture;
pub mod machine;
pub mod scenes;
pub mod summary;
pub mod sweeps;
pub mod tracers;
pub mod warnings;

/// The places of rows among all, from 1: their numbers, however they are sorted.
fn places<R>(all: &[R], shown: &[&R]) -> Vec<usize> {
    let place = |row: &&R| all.iter().position(|other| std::ptr::eq(other, *row));
    shown.iter().map(|row| place(row).map_or(0, |place| place + 1)).collect()
}
