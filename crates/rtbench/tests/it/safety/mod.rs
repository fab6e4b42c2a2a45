//! What a second attack found, each by name: journals that are edited, results that would be
//! written over, names that give orders to terminals, places that are no files, disks that take no
//! more.

mod disks;
mod journals;
mod many;
mod memory;
mod occupied;
mod outside;
mod places;
mod printed;
mod seeds;
mod shared;

use std::ffi::OsString;
use std::path::Path;

use accel_core::structures::REGISTRY;

use crate::resuming::run_in;

/// Runs the program on arguments that may hold anything; exit code, standard output, standard
/// error.
fn run_words(arguments: &[&str]) -> (u8, String, String) {
    run_in(REGISTRY, arguments.iter().map(OsString::from))
}

/// A triangle as an OBJ file.
fn write_triangle(path: &Path) {
    std::fs::write(path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
}
