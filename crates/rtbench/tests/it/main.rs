//! Tests of the command from outside, in one program: it is linked once.

mod accuracy;
mod adoption;
mod animate;
#[cfg(unix)]
mod check;
mod command_line;
mod common;
mod compare_tracers;
mod effects;
mod explain;
mod far_scenes;
#[cfg(unix)]
mod git_bisect;
mod hard_cases;
mod headings;
mod history;
mod house;
mod in_rust;
mod kills;
mod occluders;
mod own_view;
mod plugins;
mod processes;
mod report;
mod results;
mod resuming;
mod safety;
mod show;
mod snapshots;
mod speed;
mod stand_in;
mod sweep;
mod sweep_sizes;
mod verdicts;
mod verify;
mod verify_batches;
mod verify_oracles;
mod verify_planted;
mod verify_planted_shapes;
