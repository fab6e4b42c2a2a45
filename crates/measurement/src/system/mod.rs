//! The outside world: clock, machine, threads, processes, signals, files.

pub mod child_process;
pub mod clock;
pub mod created;
pub mod file_limit;
pub mod files;
pub mod instruction_set;
pub mod interrupt;
pub mod kept_folder;
pub mod machine;
pub mod memory_layout;
pub mod memory_limit;
pub mod panics;
pub mod pools;
pub mod pressure;
pub mod program_copy;
pub mod progress;
pub mod world;
pub mod write_error;
