//! The subcommands, one a file.

pub mod accuracy;
pub mod baseline;
pub mod check;
pub mod child;
pub mod compare;
pub mod compare_tracers;
pub mod cost;
pub mod doctor;
pub mod explain;
pub mod list;
pub mod measuring;
pub mod merge;
pub mod named_files;
pub mod printed;
pub mod profile;
pub mod render;
pub mod report;
pub mod reproduce;
mod resumable;
pub mod row_deaths;
pub mod run;
mod run_outputs;
pub mod scale;
pub mod scenes;
pub mod sweep;
mod trial_build;
pub mod verify;
