//! The next cell is found through the nearest common ancestor (Samet 1989).
//!
//! N_TS as Havran and Sixta's (1999) figures have it: levels down to the first leaf, levels up
//! and down for each next one, and the way up and out when the ray leaves the scene.
//! Deviation: ancestors stand on a stack; father links and tables of adjacent faces and
//! reflections are not needed, since the octants follow from ray parameters.

use crate::geometry::scalar::Scalar;
use crate::query::sink::Sink;
use crate::structures::octree::Octree;
use crate::structures::octree::cells::{Content, DEEPEST};
use crate::tree::ray_planes::{RayCell, RayPlanes};

impl<S: Scalar> Octree<S> {
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
}
