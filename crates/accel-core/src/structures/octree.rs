//! The octree: a cube-like cell is cut by three planes into eight, until few primitives are left.
//!
//! Papers: A. S. Glassner, "Space Subdivision for Fast Ray Tracing", IEEE CG&A 4(10), 1984
//! (subdivision at the centre); H. Samet, "Implementing Ray Tracing with Octrees and Neighbor
//! Finding", Computers & Graphics 13(4), 1989; I. Gargantini, H. H. Atkinson, "Ray Tracing an
//! Octree: Numerical Evaluation of the First Intersection", Computer Graphics Forum 12(4), 1993
//! (their traversals and Glassner's are in `octree/traversals.rs`); K.-Y. Whang et al.,
//! "Octree-R: An Adaptive Octree for Efficient Ray Tracing", TVCG 1(4), 1995 (subdivision where
//! a surface-area cost is least, `octree/subdivide.rs`).
//!
//! Deviations: nodes stand in arrays, not behind pointers or in a hash table of names; places on
//! the ray are ray parameters compared with those of the planes, never rounded points, so that no
//! traversal needs an epsilon; a cell that three cuts would not make cheaper stays whole
//! (`useless-splits`), as does one whose cuts would have multiplied references by more than
//! `max-growth`: boxes that share an edge, or slivers across the axes, are not separated by any
//! number of cuts; a thin axis of the root grows to the longest; neighbours are found through a
//! stack of ancestors, not father links; a ray from so far away that rounding outgrows the padding
//! of boxes is traversed top-down whatever the setting. `boxes=historical` (with `max-leaf=1
//! useless-splits=20` and an `order` that alternates) is what Havran and Sixta (1999) measured: no
//! padding, no limit for growth, traversals from the ray's origin (top-down ones from 0.01 on), and
//! steps of 1e-6 beyond a cell's exit.

mod config;
mod subdivide;
mod traversals;

use self::config::{OctreeConfig, Traversal};
use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::historical::bounds_rule::BoundsRule;
use crate::params::config::Settings;
use crate::primitives::Primitives;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats, bounds_of};
use crate::tree::ray_planes::RayPlanes;
use subdivide::{Cells, Content, octant_of};

pub static INFO: StructureInfo = StructureInfo {
    paper: "Glassner 1984; Samet 1989; Gargantini, Atkinson 1993; Whang et al. 1995 (adaptive)",
    deviations: "padded boxes; ray parameters in place of points; stops cuts that do not pay or \
                 that multiply references",
    params: OctreeConfig::PARAMS,
    also_tested: &[
        "kernel=block",
        "subdivision=adaptive",
        "traversal=neighbour",
        "traversal=point-location",
        "subdivision=adaptive traversal=point-location",
        "mailbox=array",
    ],
    ..StructureInfo::new(
        "octree",
        "cells cut into eight at the centre or by cost; three ways to traverse them",
    )
};

/// Added to every side of a cone's box, as fitted to Havran and Sixta's counters.
const HISTORICAL_CONE_MARGIN: f64 = 0.001;
/// How far beyond a cell's exit the next cell was looked for in 1999.
const HISTORICAL_NUDGE: f64 = 1e-6;

/// Parameter at which the top-down traversal began in 1999 on every ray; the others began at the
/// origin.
const HISTORICAL_START: f64 = 0.01;

pub struct Octree<S: Scalar> {
    bounds: Aabb<S>,
    cells: Cells<S>,
    traversal: Traversal,
    historical: bool,
    /// Rays that are followed beyond this distance are traversed top-down: the rounding of their
    /// parameters outgrows the padding of boxes.
    reach: S,
}

/// A side below this part of the longest one is thin.
const THIN: f64 = 1.0 / 64.0;

/// The root's box: a thin axis grows upwards to the longest one. Otherwise every cut across it
/// would put what is flat into both halves, level after level.
fn without_thin_axes<S: Scalar>(scene: Aabb<S>) -> Aabb<S> {
    let size = scene.size().to_array();
    let longest = size[0].greater(size[1]).greater(size[2]);
    let (lo, mut hi) = (scene.min.to_array(), scene.max.to_array());
    for k in 0..3 {
        if size[k] < longest * S::from_f64(THIN) {
            hi[k] = lo[k] + longest;
        }
    }
    Aabb { min: scene.min, max: Vec3::<S>::from_array(hi) }
}

impl<S: Scalar> Structure<S> for Octree<S> {
    const HAS_LISTS: bool = true;

    type Config = OctreeConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<OctreeConfig>,
    ) -> Result<Self, BuildError> {
        let historical = settings.historical;
        let rule = BoundsRule::of(historical, HISTORICAL_CONE_MARGIN);
        let boxes = bounds_of(prims, rule, settings.structure())?;
        let bounds = if historical { boxes.scene() } else { without_thin_axes(boxes.scene()) };
        let all = boxes.all();
        let cells = subdivide::cells(&all, bounds, settings)?;
        // the parameters of two planes are off by 1.5 epsilon each: at this distance by 9 together,
        // of the 22 that the padding of boxes leaves them (`bounds_rule.rs`)
        let three = S::from_i32(3);
        let reach = if historical { S::INFINITY } else { three * bounds.magnitude() };
        Ok(Self { bounds, cells, traversal: settings.traversal, historical, reach })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let t_start = match (self.historical, self.traversal) {
            (false, _) => ray.t_min,
            (true, Traversal::TopDown) => S::from_f64(HISTORICAL_START),
            (true, _) => S::ZERO,
        };
        let clipped = self.bounds.clip(ray.origin, ray.direction, t_start, ray.t_max);
        let Some((t_in, t_out)) = clipped else { return };
        let planes = RayPlanes::new(ray);
        let is_near = || {
            let d = ray.direction.to_array();
            let longest = d[0].abs().greater(d[1].abs()).greater(d[2].abs());
            t_out * longest <= self.reach
        };
        match self.traversal {
            Traversal::PointLocation if is_near() => self.locate_each(&planes, t_in, sink),
            Traversal::Neighbour if is_near() => self.step_to_neighbours(&planes, t_in, sink),
            _ => _ = self.descend(0, &planes, t_in, t_out, sink),
        }
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.cells.lists.lists().for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let c = &self.cells;
        let lists = c.lists.stats();
        let bytes = (size_of_val(c.links.as_slice()) + size_of_val(c.cuts.as_slice())) as u64;
        StructureStats { inner_cells: c.cuts.len() as u64, bytes: bytes + lists.bytes, ..lists }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let mut waiting = vec![(0, self.bounds, 0)];
        while let Some((cell, bounds, depth)) = waiting.pop() {
            let (planes, first) = match self.cells.content(cell) {
                Content::Leaf(ids) => {
                    each(Cell::elementary(bounds, depth, ids));
                    continue;
                }
                Content::Inner(planes, first) => (planes, first),
            };
            each(Cell::inner(bounds, depth));
            waiting.extend((0..8).rev().map(|child| {
                (first + child, octant_of(&bounds, planes, child as usize), depth + 1)
            }));
        }
        Ok(())
    }
}

impl<S: Scalar> Octree<S> {
    /// How far beyond a cell's exit the next cell is looked for: nothing, but in 1999.
    #[inline(always)]
    fn nudge(&self) -> S {
        if self.historical { S::from_f64(HISTORICAL_NUDGE) } else { S::ZERO }
    }
}
