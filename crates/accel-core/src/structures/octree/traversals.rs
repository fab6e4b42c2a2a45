//! Three ways of a ray through an octree.
//!
//! **Point location** (Glassner 1984): every cell is located from the root. N_TS counts every cell
//! on the way down, the leaf included.
//!
//! **Neighbour finding** (Samet 1989): the next cell is found through the nearest common ancestor.
//! N_TS as Havran and Sixta's (1999) figures have it: levels down to the first leaf, levels up and
//! down for each next one, and the way up and out when the ray leaves the scene. Deviation:
//! ancestors stand on a stack; father links and tables of adjacent faces and reflections are not
//! needed, since the octants follow from ray parameters.
//!
//! **Top-down** (Gargantini, Atkinson 1993): the ray's interval is handed down the tree, near
//! children first. N_TS counts the cells entered, the root included. Deviation: intervals are
//! rounded outwards and compared closed, so that a child the ray only grazes is entered as well; of
//! a cell's children those are looked at that lie on a side of each plane where the ray goes, in an
//! order that is front to back for every ray: a child that is behind on more planes comes later.

use std::ops::ControlFlow;

use crate::geometry::lanes::take_lowest;
use crate::geometry::scalar::Scalar;
use crate::query::sink::Sink;
use crate::structures::octree::Octree;
use crate::structures::octree::config::DEEPEST;
use crate::structures::octree::subdivide::Content;
use crate::tree::ray_planes::{RayCell, RayPlanes};

impl<S: Scalar> Octree<S> {
    /// Traverses from parameter `t` on, one search from the root for each cell.
    #[inline(always)]
    pub(super) fn locate_each<K: Sink<S>>(&self, ray: &RayPlanes<S>, mut t: S, sink: &mut K) {
        let root = ray.root(&self.bounds);
        loop {
            let mut place = root;
            let ids = loop {
                match self.cells.content(place.cell) {
                    Content::Inner(planes, first) => {
                        sink.inner_step();
                        place = ray.child(&place, planes, first, t);
                    }
                    Content::Leaf(ids) => break ids,
                }
            };
            sink.elementary_step(ids.is_empty());
            if !ids.is_empty() && sink.test(ids).is_break() {
                return;
            }
            let exit = place.exit();
            t = exit + self.nudge();
            let goes_on = t < root.exit() && exit <= sink.t_max();
            if !goes_on {
                return;
            }
        }
    }

    /// Traverses from parameter `t` on, climbing only as far as needed for each next cell.
    #[inline(always)]
    pub(super) fn step_to_neighbours<K: Sink<S>>(
        &self,
        ray: &RayPlanes<S>,
        mut t: S,
        sink: &mut K,
    ) {
        let mut ancestors = [RayCell::unset(); DEEPEST + 1];
        ancestors[0] = ray.root(&self.bounds);
        let scene_exit = ancestors[0].exit();
        let mut depth = 0;
        let mut levels = 0;
        loop {
            let ids = loop {
                let place = &ancestors[depth];
                match self.cells.content(place.cell) {
                    Content::Inner(planes, first) => {
                        ancestors[depth + 1] = ray.child(place, planes, first, t);
                        depth += 1;
                        levels += 1;
                    }
                    Content::Leaf(ids) => break ids,
                }
            };
            (1..levels).for_each(|_| sink.inner_step());
            sink.elementary_step(ids.is_empty());
            if !ids.is_empty() && sink.test(ids).is_break() {
                return;
            }
            let exit = ancestors[depth].exit();
            t = exit + self.nudge();
            if sink.t_max() < exit {
                return;
            }
            let stays_inside = t < scene_exit;
            if !stays_inside {
                (0..=depth).for_each(|_| sink.inner_step());
                return;
            }
            levels = 0;
            while depth > 0 && ancestors[depth].exit() <= t {
                depth -= 1;
                levels += 1;
            }
        }
    }

    /// Traverses what lies below a cell between `t_in` and `t_out`, from the root on.
    pub(super) fn descend<K: Sink<S>>(
        &self,
        cell: u32,
        ray: &RayPlanes<S>,
        t_in: S,
        t_out: S,
        sink: &mut K,
    ) -> ControlFlow<()> {
        let (planes, first) = match self.cells.content(cell) {
            Content::Inner(planes, first) => (planes, first),
            Content::Leaf(ids) => {
                sink.elementary_step(ids.is_empty());
                return if ids.is_empty() { ControlFlow::Continue(()) } else { sink.test(ids) };
            }
        };
        sink.inner_step();
        let mut early = [t_in; 3];
        let mut late = [t_out; 3];
        // a bit for each child, by the planes that it is behind
        let mut children: u32 = 0xFF;
        for k in 0..3 {
            let (a, b) = ray.crossing_interval(k, planes[k]);
            // NaN, a ray within the plane, leaves both sides to be visited
            early[k] = a.greater(t_in);
            late[k] = b.lesser(t_out);
            let before = [0x55, 0x33, 0x0F][k];
            if late[k] < t_in {
                children &= !before;
            }
            if early[k] > t_out {
                children &= before;
            }
        }
        while children != 0 {
            let behind = take_lowest(&mut children);
            let mut from = t_in;
            let mut to = t_out;
            for k in 0..3 {
                if behind >> k & 1 == 1 {
                    from = early[k].greater(from);
                } else {
                    to = late[k].lesser(to);
                }
            }
            if from <= to && from <= sink.t_max() {
                self.descend(first + (behind as u32 ^ ray.downwards()), ray, from, to, sink)?;
            }
        }
        ControlFlow::Continue(())
    }
}
