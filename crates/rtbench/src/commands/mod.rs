//! The subcommands, one a file.

pub mod list;
pub mod render;
pub mod run;
pub mod scenes;
