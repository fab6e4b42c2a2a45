//! The outside world: clock, machine, threads, processes, signals, files.

pub mod child_process;
pub mod clock;
pub mod files;
pub mod interrupt;
pub mod machine;
pub mod memory;
pub mod noise;
pub mod panics;
pub mod pools;
pub mod progress;
pub mod world;
