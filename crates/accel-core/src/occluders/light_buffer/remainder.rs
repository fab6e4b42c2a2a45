//! The rays that a light buffer leaves to a structure: those of long lists, and those that do not
//! run from the scene to a light.

use std::sync::OnceLock;

use crate::geometry::far_ray;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::primitives::{PrimSet, PrimsRef};
use crate::query::batch::each_near;
use crate::query::counters::WorkCounters;
use crate::query::tracer::Tracer;
use crate::registry::Buildable;
use crate::structure::BuildError;
use crate::{bvh, structures};

/// A structure made when it is first needed, over the same primitives.
pub(super) struct Remainder<'a, S: Scalar, P> {
    prims: &'a P,
    any: PrimsRef<'a, S>,
    reach: S,
    /// None when the structure refuses the scene: then all primitives are tested.
    made: OnceLock<Option<Box<dyn Tracer<S> + 'a>>>,
}

impl<'a, S: Buildable, P: PrimSet<S>> Remainder<'a, S, P> {
    pub(super) fn new(prims: &'a P, any: PrimsRef<'a, S>) -> Self {
        let reach = far_ray::reach(prims.magnitude());
        Self { prims, any, reach, made: OnceLock::new() }
    }

    /// Builds the structure now.
    ///
    /// # Errors
    /// [`BuildError`] of the structure.
    pub(super) fn make(&self) -> Result<(), BuildError> {
        if self.made.get().is_none() {
            let _ = self.made.set(structure(self.any)?);
        }
        Ok(())
    }

    /// Bytes of what was built.
    pub(super) fn bytes(&self) -> u64 {
        let made = self.made.get().and_then(Option::as_ref);
        made.map_or(0, |tracer| tracer.stats().bytes)
    }

    /// Returns whether the ray is blocked.
    #[cold]
    #[inline(never)]
    pub(super) fn is_blocked(&self, ray: &Ray<S>) -> bool {
        let mut blocked = [false];
        self.occlusions(std::slice::from_ref(ray), &mut blocked);
        blocked[0]
    }

    /// Writes whether the rays at these places are blocked.
    pub(super) fn answer(&self, rays: &[Ray<S>], places: &[u32], blocked: &mut [bool]) {
        if places.is_empty() {
            return;
        }
        let some: Vec<Ray<S>> = places.iter().map(|&i| rays[i as usize]).collect();
        let mut answers = vec![false; some.len()];
        self.occlusions(&some, &mut answers);
        for (&i, answer) in places.iter().zip(answers) {
            blocked[i as usize] = answer;
        }
    }

    /// Returns whether the ray is blocked, counting the work.
    pub(super) fn count_blocked(&self, ray: &Ray<S>, work: &mut WorkCounters) -> bool {
        let Some(tracer) = self.tracer() else {
            work.intersection_tests += self.prims.len() as u64;
            return self.is_blocked(ray);
        };
        let mut blocked = [false];
        *work += tracer.count_occlusions(std::slice::from_ref(ray), &mut blocked);
        blocked[0]
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        if let Some(tracer) = self.tracer() {
            return tracer.occlusions(rays, blocked);
        }
        each_near(self.reach, rays, blocked, |ray| {
            let setup = self.prims.setup(ray);
            (0..self.prims.len() as u32).any(|id| {
                self.prims.is_opaque(id)
                    && self.prims.intersect(id, ray, &setup, ray.t_max).is_some()
            })
        });
    }

    fn tracer(&self) -> Option<&(dyn Tracer<S> + 'a)> {
        self.made.get_or_init(|| structure(self.any).unwrap_or(None)).as_deref()
    }
}

fn structure<'a, S: Buildable>(
    prims: PrimsRef<'a, S>,
) -> Result<Option<Box<dyn Tracer<S> + 'a>>, BuildError> {
    let Some(entry) = structures::find(bvh::INFO.name) else { return Ok(None) };
    // one ray is asked as it would be without
    Ok(Some(entry.build(prims, &entry.params([("query", "batch")])?)?))
}
