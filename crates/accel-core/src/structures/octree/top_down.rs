//! The ray's interval is handed down the tree, near children first (Gargantini, Atkinson 1993).
//!
//! N_TS counts the cells entered, the root included. Deviation: intervals are rounded outwards
//! and compared closed, so that a child the ray only grazes is entered as well; of a cell's
//! children all eight are looked at, in an order that is front to back for every ray: a child
//! that is behind on more planes comes later.

use std::ops::ControlFlow;

use crate::geometry::scalar::Scalar;
use crate::query::sink::Sink;
use crate::structures::octree::Octree;
use crate::structures::octree::cells::Content;
use crate::tree::ray_planes::RayPlanes;

impl<S: Scalar> Octree<S> {
    /// Traverses what lies between `t_in` and `t_out`.
    #[inline(always)]
    pub(super) fn descend_from_root<K: Sink<S>>(
        &self,
        ray: &RayPlanes<S>,
        t_in: S,
        t_out: S,
        sink: &mut K,
    ) {
        let _ = self.descend(0, ray, t_in, t_out, sink);
    }

    fn descend<K: Sink<S>>(
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
        for k in 0..3 {
            let (a, b) = ray.crossing_interval(k, planes[k]);
            // NaN, a ray within the plane, leaves both sides to be visited
            early[k] = a.greater(t_in);
            late[k] = b.lesser(t_out);
        }
        for behind in 0..8 {
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
                self.descend(first + (behind ^ ray.downwards()), ray, from, to, sink)?;
            }
        }
        ControlFlow::Continue(())
    }
}
