//! A light buffer filled on demand: a cell remembers the last primitive that was found to block a
//! ray through it, and the next ray tests that one before the structure is asked.
//!
//! Paper: as `mod.rs`; Haines and Greenberg fill cells as occluders are found, too. Deviation: a
//! cell holds one occluder, not a list.
//!
//! An occluder is tested like any other candidate, and a ray that it does not block is the
//! structure's, so no answer depends on what a cell holds or which thread put it there.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;

use crate::geometry::ray::{MISS, Ray};
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::occluders::Occluder;
use crate::occluders::light_buffer::direction_cube::{Cube, Cubes, in_frame};
use crate::occluders::light_buffer::face_tree::Face;
use crate::occluders::light_buffer::footprint::ProjectedBody;
use crate::occluders::light_buffer::margins::Margins;
use crate::occluders::light_buffer::remainder::Remainder;
use crate::primitives::{Ball, PrimSet, PrimsRef};
use crate::query::counters::{Counters, NoCounters, WorkCounters};
use crate::registry::Buildable;
use crate::structure::{BuildError, StructureStats};

/// A buffer filled on demand, with its primitives.
pub(super) struct LazyBuffer<'a, S: Scalar, P> {
    prims: &'a P,
    /// The faces of each are flat grids over what shows the scene.
    cubes: Cubes<S>,
    /// The last occluder found in each cell, or [`MISS`].
    cells: Vec<AtomicU32>,
    remainder: Remainder<'a, S, P>,
}

impl<'a, S: Buildable, P: PrimSet<S>> LazyBuffer<'a, S, P> {
    /// An empty buffer with faces of 2 to the power `bits` cells per side, and its structure.
    ///
    /// # Errors
    /// [`BuildError`] of the structure.
    pub(super) fn new(
        prims: &'a P,
        any: PrimsRef<'a, S>,
        lights: &[DVec3],
        margins: &Margins,
        bits: u32,
    ) -> Result<Self, BuildError> {
        let remainder = Remainder::new(prims, any);
        remainder.make()?;
        let scene = prims.scene_bounds();
        let corners = [scene.min.to_dvec3(), scene.max.to_dvec3()];
        let mut count = 0;
        let cube = |light: &DVec3| {
            let position = Vec3::<S>::from_dvec3(*light);
            let face = |face| scene_on_face(corners, position.to_dvec3(), face, margins);
            let faces = std::array::from_fn(|i| match face(i) {
                None => Face::empty(),
                Some((low, high)) => {
                    let first = count;
                    count += 1 << (2 * bits);
                    Face::over(low, high, margins, [bits, bits], first as u32).0
                }
            });
            Cube { position, faces }
        };
        let mut cubes = Cubes::new(prims, margins);
        cubes.all.extend(lights.iter().map(cube));
        let cells = (0..count).map(|_| AtomicU32::new(MISS)).collect();
        Ok(Self { prims, cubes, cells, remainder })
    }

    /// The cell of a ray: `Err` for one that the buffer does not speak for, `None` where no
    /// primitive is seen.
    fn cell(&self, ray: &Ray<S>, light: u32) -> Result<Option<usize>, ()> {
        let (place, face) = self.cubes.place(ray, light).ok_or(())?;
        Ok(face.index(place.at))
    }

    fn is_blocked_by<C: Counters>(&self, ray: &Ray<S>, id: u32, counters: &mut C) -> bool {
        if id == MISS {
            return false;
        }
        counters.intersection_tests(1);
        let setup = self.prims.setup(ray);
        self.prims.intersect(id, ray, &setup, ray.t_max).is_some()
    }
}

/// Bounds of the scene's box on a face.
fn scene_on_face(
    corners: [DVec3; 2],
    light: DVec3,
    face: usize,
    margins: &Margins,
) -> Option<(glam::DVec2, glam::DVec2)> {
    let corner = |i: usize| {
        let pick = |k: usize| corners[i >> k & 1][k];
        let center = in_frame(face, DVec3::new(pick(0), pick(1), pick(2)) - light);
        Ball { center, radius: margins.position }
    };
    let seen = ProjectedBody { balls: (0..8).map(corner).collect(), is_outline: false };
    seen.footprint(0, margins, &mut Vec::new()).map(|f| (f.low, f.high))
}

impl<S: Buildable, P: PrimSet<S>> Occluder<S> for LazyBuffer<'_, S, P> {
    fn occlusions(&self, rays: &[Ray<S>], lights: &[u32], blocked: &mut [bool]) {
        for ((ray, &light), blocked) in rays.iter().zip(lights).zip(blocked) {
            let cell = match self.cell(ray, light) {
                Ok(None) => {
                    *blocked = false;
                    continue;
                }
                Ok(Some(i)) => self.cells.get(i),
                Err(()) => None,
            };
            let last = cell.map_or(MISS, |c| c.load(Ordering::Relaxed));
            *blocked = self.is_blocked_by(ray, last, &mut NoCounters);
            if !*blocked {
                *blocked = self.remainder.is_blocked(ray);
                if *blocked && let (Some(cell), Some(id)) = (cell, self.remainder.occluder(ray)) {
                    cell.store(id, Ordering::Relaxed);
                }
            }
        }
    }

    /// Counts from an empty buffer for every batch, so that counters do not depend on what was
    /// asked before, or by which thread.
    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        lights: &[u32],
        blocked: &mut [bool],
    ) -> WorkCounters {
        let mut work = WorkCounters::default();
        let mut cells: HashMap<usize, u32> = HashMap::new();
        for ((ray, &light), blocked) in rays.iter().zip(lights).zip(blocked) {
            let cell = self.cell(ray, light);
            work.elementary_step(cell == Ok(None));
            *blocked = match cell {
                Ok(None) => false,
                Err(()) => self.remainder.count_blocked(ray, &mut work),
                Ok(Some(i)) => {
                    let last = cells.get(&i).copied().unwrap_or(MISS);
                    self.is_blocked_by(ray, last, &mut work) || {
                        let is_blocked = self.remainder.count_blocked(ray, &mut work);
                        if is_blocked && let Some(id) = self.remainder.occluder(ray) {
                            cells.insert(i, id);
                        }
                        is_blocked
                    }
                }
            };
        }
        work
    }

    fn stats(&self) -> StructureStats {
        let filled = self.cells.iter().filter(|c| c.load(Ordering::Relaxed) != MISS).count();
        let bytes = size_of_val(self.cells.as_slice()) + size_of_val(self.cubes.all.as_slice());
        StructureStats {
            cells: self.cells.len() as u64,
            empty_cells: (self.cells.len() - filled) as u64,
            references: filled as u64,
            bytes: bytes as u64 + self.remainder.bytes(),
            ..StructureStats::default()
        }
    }
}
