//! The subcommands, one a file.

pub mod accuracy;
pub mod compare_tracers;
pub mod cost;
pub mod list;
pub mod measuring;
pub mod render;
pub mod report;
pub mod reproduce;
pub mod run;
pub mod scenes;
pub mod sweep;
pub mod verify;
