//! rtbench command line.
fn main() {}
