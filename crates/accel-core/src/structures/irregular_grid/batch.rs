//! A batch of rays through the grid: several on their way at once, each on its own; one that is
//! finished makes room for the next.
//!
//! A single ray is a chain of loads that wait for one another: entry, cell, list, triangles. Rays
//! do not wait for each other, so the processor works on some while others wait for memory. The
//! steps of a ray are those of the walk of one ray, its triangles are tested eight at a time by the
//! same arithmetic, so that answers are the same to the last bit.

use super::course::{Course, nearest};
use super::subdivide::{Cell, Cells};
use super::{IrregularGrid, Point};
use crate::far_ray::{self, Place};
use crate::primitives::{PrimSet, Shear, TriangleBlock};
use crate::ray::{Hit, MISS, Ray};
use crate::scalar::{Scalar, Vector};

/// Rays on their way at once.
const LANES: usize = 16;

/// The cells once more, with triangles in place of ids.
#[derive(Debug)]
pub(super) struct Gathered<S> {
    /// `list` is the number of the first block, and 0 for an empty list.
    cells: Vec<Cell>,
    /// The first is that of the empty list.
    blocks: Vec<TriangleBlock<S>>,
}

impl<S: Scalar> Gathered<S> {
    /// `None` when some primitive is not a triangle at rest, or there are too many for blocks.
    pub(super) fn of<P: PrimSet<S>>(cells: &Cells, prims: &P) -> Option<Self> {
        let corners = |id| prims.corners(id).map(|corners| corners.map(|p| p.to_array()));
        if prims.len() > TriangleBlock::<S>::MOST_IDS
            || (0..prims.len() as u32).any(|id| corners(id).is_none())
        {
            return None;
        }
        let mut blocks = vec![TriangleBlock::new(std::iter::empty(), false)];
        // the first block of the list that begins at that place
        let mut first = vec![0u32; cells.lists.len()];
        let mut gathered = cells.cells.clone();
        for cell in gathered.iter_mut().filter(|cell| cell.list != 0) {
            let begin = &mut first[cell.list as usize];
            if *begin == 0 {
                *begin = u32::try_from(blocks.len()).ok()?;
                let mut parts = cells.list(cell.list).chunks(8).peekable();
                while let Some(part) = parts.next() {
                    let triangles = part.iter().filter_map(|&id| Some((id, corners(id)?)));
                    blocks.push(TriangleBlock::new(triangles, parts.peek().is_some()));
                }
            }
            cell.list = *begin;
        }
        Some(Self { cells: gathered, blocks })
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice()) + size_of_val(self.blocks.as_slice())
    }
}

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
    ray: Ray<S>,
    shear: Shear<S>,
    /// Parameters were made smaller by this.
    moved_by: S,
    best: Hit<S>,
    /// In the batch.
    place: usize,
}

impl<S: Scalar> IrregularGrid<S> {
    /// A ray that is on its way; `None` when it meets nothing.
    #[inline(always)]
    fn lane(&self, ray: &Ray<S>, place: usize, reach: S) -> Option<Lane<S>> {
        let (ray, moved_by) = match far_ray::place(ray, reach) {
            Place::Near => (*ray, S::ZERO),
            Place::Moved(near, by) => (near, by),
            Place::Nowhere => return None,
        };
        let (start, _) = self.bounds.clip(ray.origin, ray.direction, ray.t_min, ray.t_max)?;
        let resolution = self.finder.resolution();
        let (course, at) = Course::of(&ray, start, self.bounds.min, self.a_length, resolution);
        Some(Lane {
            at,
            course,
            shear: Shear::of(&ray),
            moved_by,
            best: Hit { t: ray.t_max, id: MISS },
            ray,
            place,
        })
    }

    /// Answers all rays.
    #[inline(always)]
    fn trace<Q: Query<S>>(&self, gathered: &Gathered<S>, rays: &[Ray<S>], reach: S, query: &mut Q) {
        let resolution = self.finder.resolution();
        let entries = self.cells.entries.as_slice();
        let mut waiting = rays.iter().enumerate();
        let mut next = |query: &mut Q| {
            for (place, ray) in waiting.by_ref() {
                match self.lane(ray, place, reach) {
                    Some(lane) => return Some(lane),
                    None => query.finish(place, Hit { t: ray.t_max, id: MISS }),
                }
            }
            None
        };
        let mut lanes: Vec<Lane<S>> = Vec::with_capacity(LANES);
        while lanes.len() < LANES
            && let Some(lane) = next(query)
        {
            lanes.push(lane);
        }
        let none = Cell { first: [0; 3], last: [0; 3], list: 0 };
        let mut cells = [none; LANES];
        while !lanes.is_empty() {
            for (lane, cell) in lanes.iter().zip(&mut cells) {
                *cell = gathered.cells[self.finder.cell_at(entries, lane.at) as usize];
            }
            let mut over = 0u32;
            for (i, (lane, cell)) in lanes.iter_mut().zip(&cells).enumerate() {
                let mut block = cell.list as usize;
                let mut is_over = false;
                while block != 0 && !is_over {
                    let triangles = &gathered.blocks[block];
                    is_over = query.test(triangles, lane);
                    block = if triangles.has_next() { block + 1 } else { 0 };
                }
                over |= u32::from(is_over) << i;
            }
            for (i, (lane, cell)) in lanes.iter_mut().zip(&cells).enumerate() {
                let exits = lane.course.exits(cell);
                let exit = nearest(exits);
                let ends = (lane.best.t < exit) | !exit.is_finite();
                let goes_on = lane.course.advance(&mut lane.at, cell, exits, exit, resolution);
                over |= u32::from(ends | !goes_on) << i;
            }
            // from the last: a lane that is not refilled is replaced by one already looked at
            for i in (0..lanes.len()).rev().filter(|i| over >> i & 1 == 1) {
                let Lane { place, best, moved_by, .. } = lanes[i];
                query.finish(place, Hit { t: best.t + moved_by, ..best });
                match next(query) {
                    Some(lane) => lanes[i] = lane,
                    None => {
                        lanes.swap_remove(i);
                    }
                }
            }
        }
    }

    /// Closest hits of all rays.
    pub(super) fn trace_closest(
        &self,
        gathered: &Gathered<S>,
        rays: &[Ray<S>],
        reach: S,
        hits: &mut [Hit<S>],
    ) {
        self.trace(gathered, rays, reach, &mut Closest { rays, hits });
    }

    /// Occlusion of all rays.
    pub(super) fn trace_occlusions<P: PrimSet<S>>(
        &self,
        gathered: &Gathered<S>,
        prims: &P,
        rays: &[Ray<S>],
        reach: S,
        blocked: &mut [bool],
    ) {
        self.trace(gathered, rays, reach, &mut Occlusion { prims, blocked });
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
