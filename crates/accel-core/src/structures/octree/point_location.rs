//! Every cell is located from the root (Glassner 1984).
//!
//! N_TS counts every cell on the way down, the leaf included. Deviation: see `ray_planes.rs`.

use crate::geometry::scalar::Scalar;
use crate::query::sink::Sink;
use crate::structures::octree::Octree;
use crate::structures::octree::cells::Content;
use crate::tree::ray_planes::RayPlanes;

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
}
