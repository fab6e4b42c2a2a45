//! `rtbench` with a structure that can be slowed down on purpose, to see whether `rtbench check`
//! finds it: for `scripts/check-trials.sh` and nothing else.
//!
//! `slowed-grid` is the uniform grid, and after each traversal a loop of as many turns as
//! PLANTED_LOOPS says, of which nothing is kept. Its answers and counters are the grid's.

use std::hint::black_box;
use std::process::ExitCode;

use accel_core::params::config::Settings;
use accel_core::primitives::{PrimSet, Primitives};
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats};
use accel_core::structures::Entry;
use accel_core::structures::obvhs::{bvh2, cwbvh};
use accel_core::structures::uniform_grid::{self, UniformGrid};
use accel_core::{Ray, Scalar};

static INFO: StructureInfo = StructureInfo {
    params: uniform_grid::INFO.params,
    ..StructureInfo::new("slowed-grid", "the uniform grid with a loop after each traversal")
};

static REGISTRY: &[Entry] = &[
    accel_core::entry!(bvh2::ObvhsBvh2, bvh2::INFO),
    accel_core::entry!(cwbvh::ObvhsCwBvh, cwbvh::INFO),
    accel_core::entry!(crate::Slowed, crate::INFO),
];

/// A grid and how long it dawdles after each traversal.
struct Slowed<S: Scalar> {
    grid: UniformGrid<S>,
    loops: u32,
}

impl<S: Scalar> Structure<S> for Slowed<S> {
    type Config = <UniformGrid<S> as Structure<S>>::Config;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
    ) -> Result<Self, BuildError> {
        let loops = std::env::var("PLANTED_LOOPS").ok().and_then(|n| n.parse().ok()).unwrap_or(0);
        Ok(Self { grid: UniformGrid::build(prims, settings)?, loops })
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        self.grid.traverse(ray, sink);
        for turn in 0..self.loops {
            black_box(turn);
        }
    }

    fn stats(&self) -> StructureStats {
        self.grid.stats()
    }
}

fn main() -> ExitCode {
    rtbench::main_over(REGISTRY)
}
