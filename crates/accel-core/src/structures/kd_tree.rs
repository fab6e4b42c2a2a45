//! The k-d tree: one axis-parallel plane a cell, placed where the expected cost is least.
//!
//! Papers: J. D. MacDonald, K. S. Booth, "Heuristics for Ray Tracing Using Space Subdivision",
//! The Visual Computer 6(3), 1990 (the surface-area heuristic); I. Wald, V. Havran, "On Building
//! Fast kd-Trees for Ray Tracing, and on Doing That in O(N log N)", RT 2006 (planes at the sides
//! of boxes, empty-space bonus); M. Shevtsov, A. Soupikov, A. Kapustin, "Highly Parallel Fast
//! kd-Tree Construction for Interactive Ray Tracing of Dynamic Scenes", Eurographics 2007 (bins
//! for cells with many references); V. Havran, "Heuristic Ray Shooting Algorithms", 2000 (the
//! traversal with a stack).
//!
//! Deviations: cells of few references are swept exactly, sorting again in each; primitives are
//! not clipped to cells ("perfect splits"), only their boxes are; a line of descent may contain
//! a few cuts that do not pay; intervals on the ray are rounded outwards, so that a ray within a
//! plane, or one that only grazes a cell, visits both sides.

mod subdivide;
mod surface_area;

use std::ops::ControlFlow;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::historical::bounds_rule::BoundsRule;
use crate::params::config::Settings;
use crate::primitives::Primitives;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::region::{Frustum, FrustumTraversal};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats, bounds_of};
use crate::tree::ray_planes::RayPlanes;
use subdivide::{Cells, Node};
use surface_area::{DEEPEST, KdTreeConfig};

pub static INFO: StructureInfo = StructureInfo {
    paper: "MacDonald, Booth 1990; Wald, Havran 2006; Shevtsov et al. 2007 (bins)",
    deviations: "padded boxes; binned above, exact below a number of references; no clipping",
    params: KdTreeConfig::PARAMS,
    also_tested: &[
        "kernel=block",
        "max-leaf=4 traversal-cost=2",
        "empty-bonus=0",
        "exact-below=1024",
        "mailbox=hash",
    ],
    ..StructureInfo::new(
        "kd-tree",
        "binary space subdivision by the surface-area heuristic, traversed with a stack",
    )
};

pub struct KdTree<S: Scalar> {
    bounds: Aabb<S>,
    cells: Cells<S>,
}

impl<S: Scalar> Structure<S> for KdTree<S> {
    const HAS_LISTS: bool = true;

    type Config = KdTreeConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<KdTreeConfig>,
    ) -> Result<Self, BuildError> {
        let boxes = bounds_of(prims, BoundsRule::Padded, settings.structure())?;
        let bounds = boxes.scene();
        let all = boxes.all();
        Ok(Self { bounds, cells: subdivide::cells(&all, bounds, settings)? })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let clipped = self.bounds.clip(ray.origin, ray.direction, ray.t_min, ray.t_max);
        let Some((mut t_in, mut t_out)) = clipped else { return };
        let planes = RayPlanes::new(ray);
        let mut stack = [(0u32, S::ZERO, S::ZERO); DEEPEST];
        let mut waiting = 0;
        let mut cell = 0;
        loop {
            let node = self.cells.links[cell as usize];
            let axis = node.link & 3;
            if axis != Node::<S>::LEAF {
                sink.inner_step();
                let lower = node.link >> 2;
                let above_first = planes.downwards() >> axis & 1;
                let (near, far) = (lower + above_first, lower + 1 - above_first);
                let (early, late) = planes.crossing_interval(axis as usize, node.plane);
                // NaN, a ray within the plane, leaves both sides to be visited
                let far_in = early.greater(t_in);
                let near_out = late.lesser(t_out);
                if t_in > near_out {
                    (cell, t_in) = (far, far_in);
                } else {
                    if far_in <= t_out {
                        stack[waiting] = (far, far_in, t_out);
                        waiting += 1;
                    }
                    (cell, t_out) = (near, near_out);
                }
                continue;
            }
            let ids = self.cells.lists.at((node.link >> 2) as usize);
            sink.elementary_step(ids.is_empty());
            if !ids.is_empty() && sink.test(ids).is_break() {
                return;
            }
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                (cell, t_in, t_out) = stack[waiting];
                if t_in <= sink.t_max() {
                    break;
                }
            }
        }
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.cells.lists.lists().for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let (nodes, lists) = (self.cells.links.as_slice(), self.cells.lists.stats());
        let inner_cells = nodes.len() as u64 - lists.cells;
        StructureStats { inner_cells, bytes: size_of_val(nodes) as u64 + lists.bytes, ..lists }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        let mut waiting = vec![(0, self.bounds, 0)];
        while let Some((cell, bounds, depth)) = waiting.pop() {
            let node = self.cells.links[cell as usize];
            let (axis, link) = ((node.link & 3) as usize, node.link >> 2);
            if axis == Node::<S>::LEAF as usize {
                each(Cell::elementary(bounds, depth, self.cells.lists.at(link as usize)));
                continue;
            }
            each(Cell::inner(bounds, depth));
            let [lower, upper] = bounds.cut(axis, node.plane);
            waiting.extend([(link + 1, upper, depth + 1), (link, lower, depth + 1)]);
        }
        Ok(())
    }
}

/// From the root, the near child first.
impl FrustumTraversal for KdTree<f64> {
    fn traverse_frustum(
        &self,
        frustum: &Frustum,
        cell: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    ) {
        let root = self.bounds.expanded(frustum.tolerance());
        if !frustum.meets_box(&root) {
            return;
        }
        let direction = frustum.direction();
        // cells that wait, each with the least depth of itself and of those below it
        let mut stack = vec![(0u32, root, frustum.least_depth(&root))];
        while let Some((index, bounds, depth)) = stack.pop() {
            let node = self.cells.links[index as usize];
            let axis = (node.link & 3) as usize;
            if node.link & 3 == Node::<f64>::LEAF {
                let ids = self.cells.lists.at((node.link >> 2) as usize);
                if !ids.is_empty() && cell(ids, depth).is_break() {
                    return;
                }
                continue;
            }
            let (mut lower, mut upper) = (bounds, bounds);
            lower.max[axis] = node.plane + frustum.tolerance();
            upper.min[axis] = node.plane - frustum.tolerance();
            let child = node.link >> 2;
            let mut children = [(child + 1, upper), (child, lower)];
            if direction[axis] < 0.0 {
                children.reverse();
            }
            // the far child waits below the near one
            let mut below = stack.last().map_or(f64::INFINITY, |s| s.2);
            for (index, bounds) in children {
                if frustum.meets_box(&bounds) {
                    below = below.min(frustum.least_depth(&bounds));
                    stack.push((index, bounds, below));
                }
            }
        }
    }
}
