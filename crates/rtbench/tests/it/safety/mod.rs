//! Regression tests of an attack: edited journals, overwritten results, escape sequences in names,
//! places that are not files, full disks.

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
