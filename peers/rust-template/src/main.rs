//! `rtbench` with a structure of mine among its own: every command knows it.

mod median_bvh;

use std::process::ExitCode;

use rtbench::accel_core::entry;

fn main() -> ExitCode {
    // rtbench::main_over(&[...]) has the structures given and no others
    rtbench::main_with(&[entry!(median_bvh::MedianBvh, median_bvh::INFO)])
}
