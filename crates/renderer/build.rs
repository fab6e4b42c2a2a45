//! Tells the crate how it is optimised; every result repeats it.

use std::env;

fn main() {
    if let Ok(level) = env::var("OPT_LEVEL") {
        println!("cargo::rustc-env=RENDERER_OPT_LEVEL={level}");
    }
    println!("cargo::rerun-if-changed=build.rs");
}
