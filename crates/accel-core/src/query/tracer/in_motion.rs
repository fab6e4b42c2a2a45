//! Tracing a set whose primitives move.
//!
//! It walks with the one [`ErasedSink`](crate::query::sink::ErasedSink) that counting walks with, so that
//! motion costs no structure another compiled walk; scenes at rest are traced by [`Bound`] as ever.

use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::InMotion;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::WorkCounters;
use crate::query::tracer::{Bound, ShadowCount, ShadowRule, Tracer};
use crate::query::way::Way;
use crate::structure::{Shape, Structure};

/// A structure over a set in motion.
pub struct BoundInMotion<'a, S: Scalar, T>(pub Bound<S, &'a InMotion<S>, T>);

impl<S: Scalar, T: Structure<S>> Tracer<S> for BoundInMotion<'_, S, T> {
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        self.0.count_all_closest(rays, hits);
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        const PART: usize = 256;
        let mut answers = [ShadowCount::default(); PART];
        for (rays, blocked) in rays.chunks(PART).zip(blocked.chunks_mut(PART)) {
            self.0.count_all_occlusions(rays, ShadowRule::OpaqueBlocks, &mut answers);
            for (blocked, answer) in blocked.iter_mut().zip(&answers) {
                *blocked = answer.blocked;
            }
        }
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        self.0.count_all_closest(rays, hits)
    }

    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters {
        self.0.count_all_occlusions(rays, rule, answers)
    }

    fn shape(&self) -> Shape {
        self.0.whole_shape()
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.0.cells_of(each)
    }

    fn way(&self, ray: &Ray<S>) -> Result<Way<S>, NoCells> {
        Ok(self.0.way_of(ray))
    }
}
