//! The traversal through voxels: accumulated, recomputed, driven by an axis, in f64; against whole
//! numbers.
//!
//! The rays that are judged are those of the scene, as seen from the cells of a fine grid and moved
//! to 1024ths of a cell near by: then the oracle of `verify` says exactly which cells they pierce.
//! A ray is wrong when its traversal passes by a cell that it pierces, however shortly.

use accel_core::grid::cell_traversal::CellTraversal;
use accel_core::grid::voxel_traversal::GridFrame;
use accel_core::variants::voxel_traversals::DoubleTraversal;
use accel_core::{Aabb, Ray, Vector};
use glam::{DVec3, Vec3};
use renderer::RayKind;

use crate::accuracy::axis::*;
use crate::accuracy::integer_ray::IntegerRay;
use crate::verify::draw::point;

pub static AXIS: Axis = Axis {
    name: "voxel-traversal",
    summary: "plane parameters of a traversal of voxels: accumulated, recomputed, in f64",
    paper: "Amanatides, Woo 1987; Fujimoto, Tanaka, Iwata 1986",
    metric: "rays in 10^6 whose traversal misses a cell that they pierce",
    reference: "exact integers",
    scenes: &["teapot", "tree", "pavilion"],
    setting: "uniform-grid.traversal",
    measure: Measure::Whole(measure),
};

/// Cells an axis, in a full run and in a quick one.
const CELLS: [u32; 2] = [256, 64];

/// Cells an axis of the grid that rays are judged in: no list is kept for them.
const FINE: u32 = 1024;

/// One trial of so many that are asked for is made: each visits thousands of cells.
const SHARE: usize = 5;

/// Kinds of traversal, as the setting has them.
const TRAVERSALS: [&str; 4] = ["accumulate", "t-next", "driving-axis", "f64"];

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let n = CELLS[usize::from(stage.limits.quick)];
    let label = |traversal| format!("uniform-grid:resolution={n}x{n}x{n}:traversal={traversal}");
    let settings = TRAVERSALS.map(|traversal| (traversal, label(traversal)));
    let batches = stage.all_batches();
    let aimed = lattice_rays(stage, FINE);
    let mut found = TRAVERSALS.map(|_| (TrialCounts::default(), 0));
    for aim in &aimed {
        let pierced = aim.pierced();
        for ((tally, missed), traversal) in found.iter_mut().zip(TRAVERSALS) {
            let passed_by = aim.passed_by(traversal, &pierced);
            tally.add(passed_by > 0);
            *missed += passed_by;
        }
    }
    let said = SceneOutcome::new(
        format!("of the scene through {n}^3 cells"),
        format!("{} rays of the scene on a lattice of {FINE}^3 cells", aimed.len()),
    );
    timed_settings(stage, &settings, "f64", &batches, said, |i, _, replays| {
        let (tally, missed) = found[i];
        let differing = replays.last().map_or(0, |last| replays[i].differing(last));
        let figures = vec![
            ("cells passed by", missed as f64),
            ("wrong hits in 10^6", in_a_million(differing, count(&batches) as u64)),
        ];
        Ok((tally.error(), figures))
    })
}

/// A ray whose numbers the integer oracle can hold, in the coordinates of cells.
pub struct LatticeRay {
    n: u32,
    ray: Ray<f32>,
    exact: IntegerRay,
}

impl LatticeRay {
    /// In a grid of `n` cells per axis; `None` where the oracle or single precision cannot hold it.
    pub fn new(n: u32, origin: DVec3, direction: DVec3) -> Option<Self> {
        let exact = IntegerRay::new(origin, direction)?;
        let ray = Ray::<f32>::new(origin.as_vec3(), direction.as_vec3());
        let is_held = ray.origin.as_dvec3() == origin && ray.direction.as_dvec3() == direction;
        is_held.then_some(Self { n, ray, exact })
    }

    pub fn pierced(&self) -> Vec<[i32; 3]> {
        self.exact.pierced(self.n as i32).into_iter().map(|p| p.cell).collect()
    }

    pub fn visited(&self, traversal: &str) -> Vec<[i32; 3]> {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::splat(self.n as f32) };
        let frame = GridFrame::<f32>::new(bounds, [self.n; 3]);
        match traversal {
            "accumulate" => cells(frame.accumulating_traversal_from(&self.ray, 0.0)),
            "driving-axis" => cells(frame.driving_traversal_from(&self.ray, 0.0)),
            "f64" => cells::<f32>(DoubleTraversal::from(&frame.in_double(), &self.ray, 0.0)),
            _ => cells(frame.traversal(&self.ray)),
        }
    }

    /// Number of pierced cells that a traversal misses.
    fn passed_by(&self, traversal: &str, pierced: &[[i32; 3]]) -> usize {
        let mut visited = self.visited(traversal);
        visited.sort_unstable();
        pierced.iter().filter(|cell| visited.binary_search(cell).is_err()).count()
    }
}

fn cells<S: accel_core::Scalar>(traversal: Option<impl CellTraversal<S>>) -> Vec<[i32; 3]> {
    let mut visited = Vec::new();
    let Some(mut traversal) = traversal else { return visited };
    loop {
        visited.push(traversal.coords());
        if !traversal.advance() {
            return visited;
        }
    }
}

/// The scene's closest-hit rays in a grid of `n` cells per axis, moved onto the lattice, each by up
/// to a cell so that there are as many as are asked for.
pub fn lattice_rays(stage: &Stage<'_>, n: u32) -> Vec<LatticeRay> {
    let bounds = stage.bounds();
    let (low, size) = (bounds.min.to_dvec3(), bounds.size().to_dvec3());
    let cell = (size / f64::from(n)).max(DVec3::splat(f64::MIN_POSITIVE));
    let batches = stage.batches(stage.trials(), |kind| kind != RayKind::Shadow);
    let rays: Vec<_> = batches.iter().flat_map(|(_, rays)| rays).collect();
    let mut random = stage.random("lattice");
    let drawn = (0..2 * stage.trials() / SHARE).filter_map(|_| {
        let ray = rays.get(random.below(rays.len()))?;
        let origin = (ray.origin.to_dvec3() - low) / cell + point(&mut random);
        let along = ray.direction.to_dvec3() / cell;
        let direction = (along / along.abs().max_element() * f64::from(1 << 16)).round();
        let aim = LatticeRay::new(n, (origin * 1024.0).round() / 1024.0, direction)?;
        // most that miss the grid would be right whatever the traversal
        (!aim.visited("f64").is_empty()).then_some(aim)
    });
    drawn.take(stage.trials() / SHARE).collect()
}
