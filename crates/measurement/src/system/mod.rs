//! The outside world: clock, machine, threads, processes, signals, files.

pub mod child_process;
pub mod clock;
pub mod created;
pub mod files;
pub mod huge_pages;
pub mod interrupt;
pub mod machine;
pub mod memory_layout;
pub mod memory_limit;
pub mod noise;
pub mod panics;
pub mod pools;
pub mod program_copy;
pub mod progress;
pub mod world;
