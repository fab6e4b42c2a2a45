//! A batch of rays through the grid: several on their way at once, each on its own; one that is
//! finished makes room for the next.
//!
//! A single ray is a chain of loads that wait for one another: voxel, triangles, voxel. Rays do not
//! wait for each other, so the processor works on some while others wait. The answers are those of
//! the walk of one ray to the last bit: triangles are tested by the same arithmetic, eight at a
//! time.

use crate::geometry::far_ray::{self, Parameters, Place};
use crate::geometry::ray::{Hit, MISS, Ray};
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::primitives::{PrimSet, Shear, TriangleBlock};
use crate::structures::irregular_grid::IrregularGrid;
use crate::structures::irregular_grid::course::Course;
use crate::structures::irregular_grid::voxels::Point;
use crate::structures::irregular_grid::voxels::Voxel;

/// Rays on their way at once.
const LANES: usize = 24;

/// What a batch asks of each ray.
pub(super) trait Query<S: Scalar> {
    /// Tests a block; true when the ray's query is over.
    fn test(&self, block: &TriangleBlock<S>, lane: &mut Lane<S>) -> bool;
    /// Keeps the answer of the ray at that place of the batch.
    fn finish(&mut self, place: usize, best: Hit<S>);
}

/// A ray on its way.
#[derive(Clone, Copy)]
pub(super) struct Lane<S: Scalar> {
    course: Course<S>,
    at: Point,
    /// The one at that point.
    voxel: Voxel,
    shear: Shear<S>,
    ray: Ray<S>,
    best: Hit<S>,
    /// What those of the ray became.
    parameters: Parameters<S>,
    /// In the batch.
    place: usize,
}

/// The place of a lane without a ray.
const IDLE: usize = usize::MAX;

impl<S: Scalar> Lane<S> {
    fn idle() -> Self {
        let ray = Ray::new(Vec3::<S>::splat(S::ZERO), Vec3::<S>::splat(S::ONE));
        Self {
            course: Course::idle(),
            at: Point::ZERO,
            voxel: Voxel::NOTHING,
            shear: Shear::of(&ray, S::ONE),
            ray,
            best: Hit { t: S::ZERO, id: MISS },
            parameters: Parameters::SAME,
            place: IDLE,
        }
    }
}

/// Some of the lanes.
struct Chosen {
    lanes: [u8; LANES],
    n: usize,
}

impl Chosen {
    #[inline(always)]
    fn new() -> Self {
        Self { lanes: [0; LANES], n: 0 }
    }

    /// Adds a lane when it is wanted; lanes in order, each once.
    #[inline(always)]
    fn add(&mut self, lane: usize, wanted: bool) {
        self.lanes[self.n.min(LANES - 1)] = lane as u8;
        self.n += usize::from(wanted);
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = usize> {
        self.lanes.iter().take(self.n).map(|&i| usize::from(i))
    }
}

impl<S: Scalar> IrregularGrid<S> {
    /// Sets a ray on its way; false when it meets nothing.
    #[inline(always)]
    fn start(&self, lane: &mut Lane<S>, ray: &Ray<S>, place: usize, reach: S) -> bool {
        let (ray, parameters) = match far_ray::place(ray, reach) {
            Place::Near => (*ray, Parameters::SAME),
            Place::Moved(near, parameters) => (near, parameters),
            Place::Nowhere => return false,
        };
        let Some((course, at)) = Course::of(&ray, &self.place) else { return false };
        lane.course = course;
        lane.at = at;
        lane.shear = Shear::of(&ray, self.magnitude);
        lane.best = Hit { t: ray.t_max, id: MISS };
        lane.ray = ray;
        lane.parameters = parameters;
        lane.place = place;
        true
    }

    /// Tests a lane's list; true when its query is over.
    #[inline(always)]
    fn test<Q: Query<S>>(
        &self,
        blocks: &[TriangleBlock<S>],
        lane: &mut Lane<S>,
        query: &Q,
    ) -> bool {
        let mut number = lane.voxel.list() as usize;
        loop {
            let block = &blocks[number];
            if query.test(block, lane) {
                return true;
            }
            if !block.has_next() {
                return false;
            }
            number += 1;
        }
    }

    /// Goes on to the point where the next voxel begins; false when there is none, or what it has
    /// no longer matters.
    #[inline(always)]
    fn step(&self, lane: &mut Lane<S>) -> bool {
        lane.course.leave(&mut lane.at, &lane.voxel, lane.best.t, &self.place)
    }

    /// Answers all rays, several at once. What is done for each lane is done without branches where
    /// it can be: one that depends on what a lane waits for would keep the others waiting.
    #[inline(always)]
    fn trace<Q: Query<S>>(
        &self,
        blocks: &[TriangleBlock<S>],
        rays: &[Ray<S>],
        reach: S,
        query: &mut Q,
    ) {
        let mut waiting = rays.iter().enumerate();
        let mut lanes = vec![Lane::idle(); LANES];
        let mut over = u32::MAX >> (u32::BITS as usize - LANES);
        loop {
            // from the last: a lane that is not refilled is replaced by one already looked at
            while over != 0 {
                let i = over.ilog2() as usize;
                over ^= 1 << i;
                let Lane { place, best, parameters, .. } = lanes[i];
                if place != IDLE {
                    query.finish(place, Hit { t: parameters.restored(best.t), ..best });
                }
                loop {
                    let Some((place, ray)) = waiting.next() else {
                        lanes.swap_remove(i);
                        break;
                    };
                    if self.start(&mut lanes[i], ray, place, reach) {
                        break;
                    }
                    query.finish(place, Hit { t: ray.t_max, id: MISS });
                }
            }
            if lanes.is_empty() {
                return;
            }
            let mut divided = Chosen::new();
            for (i, lane) in lanes.iter_mut().enumerate() {
                lane.voxel = self.voxels.top(lane.at);
                divided.add(i, lane.voxel.is_divided());
            }
            while divided.n > 0 {
                let mut still = Chosen::new();
                for i in divided.iter() {
                    let lane = &mut lanes[i];
                    lane.voxel = self.voxels.part(&lane.voxel, lane.at);
                    still.add(i, lane.voxel.is_divided());
                }
                divided = still;
            }
            let mut full = Chosen::new();
            for (i, lane) in lanes.iter().enumerate() {
                full.add(i, lane.voxel.list() != 0);
            }
            for i in full.iter() {
                over |= u32::from(self.test(blocks, &mut lanes[i], query)) << i;
            }
            for (i, lane) in lanes.iter_mut().enumerate() {
                over |= u32::from(!self.step(lane)) << i;
            }
        }
    }

    /// Closest hits of all rays.
    pub(super) fn trace_closest(
        &self,
        blocks: &[TriangleBlock<S>],
        rays: &[Ray<S>],
        reach: S,
        hits: &mut [Hit<S>],
    ) {
        self.trace(blocks, rays, reach, &mut Closest { rays, hits });
    }

    /// Occlusion of all rays.
    pub(super) fn trace_occlusions<P: PrimSet<S>>(
        &self,
        blocks: &[TriangleBlock<S>],
        prims: &P,
        rays: &[Ray<S>],
        reach: S,
        blocked: &mut [bool],
    ) {
        self.trace(blocks, rays, reach, &mut Occlusion { prims, blocked });
    }
}

struct Closest<'a, S: Scalar> {
    rays: &'a [Ray<S>],
    hits: &'a mut [Hit<S>],
}

impl<S: Scalar> Query<S> for Closest<'_, S> {
    #[inline(always)]
    fn test(&self, block: &TriangleBlock<S>, lane: &mut Lane<S>) -> bool {
        block.closest(&lane.ray, &lane.shear, &mut lane.best);
        false
    }

    #[inline(always)]
    fn finish(&mut self, place: usize, best: Hit<S>) {
        // the bound of a miss is given back as it came, even if the ray was moved
        let miss = Hit { t: self.rays[place].t_max, id: MISS };
        self.hits[place] = if best.is_hit() { best } else { miss };
    }
}

struct Occlusion<'a, P> {
    prims: &'a P,
    blocked: &'a mut [bool],
}

impl<S: Scalar, P: PrimSet<S>> Query<S> for Occlusion<'_, P> {
    #[inline(always)]
    fn test(&self, block: &TriangleBlock<S>, lane: &mut Lane<S>) -> bool {
        let blocked = block.any(&lane.ray, &lane.shear, |id| self.prims.is_opaque(id));
        if blocked {
            lane.best.id = 0;
        }
        blocked
    }

    #[inline(always)]
    fn finish(&mut self, place: usize, best: Hit<S>) {
        self.blocked[place] = best.is_hit();
    }
}
