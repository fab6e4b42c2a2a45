//! The subcommands, one a file.

pub mod accuracy;
pub mod baseline;
pub mod check;
pub mod child;
pub mod compare;
pub mod compare_tracers;
pub mod cost;
pub mod doctor;
pub mod list;
pub mod measuring;
pub mod merge;
pub mod printed;
pub mod profile;
pub mod render;
pub mod report;
pub mod reproduce;
pub mod run;
pub mod scale;
pub mod scenes;
pub mod sweep;
pub mod verify;
