//! The subcommands, most of them one per file.

pub mod accuracy;
pub mod animate;
pub mod baseline;
pub mod check;
mod check_in_turns;
pub mod child;
pub mod compare;
pub mod compare_tracers;
pub mod cost;
pub mod doctor;
pub mod generate;
pub mod list;
pub mod measuring;
mod processes;
pub mod rays;
pub mod render;
pub mod report;
pub mod reproduce;
pub mod run;
pub mod run_outputs;
pub mod run_state;
pub mod scenes;
pub mod show;
pub mod sweep;
pub mod verify;
