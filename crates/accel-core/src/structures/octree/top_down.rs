//! The ray's interval is handed down the tree, near children first (Gargantini, Atkinson 1993).
//!
//! N_TS counts the cells entered, the root included. Deviation: intervals are rounded outwards
//! and compared closed, so that a child the ray only grazes is entered as well; of a cell's
//! children all eight are looked at, side by side, and visited in an order that is front to back for
//! every ray: a child that is behind on more planes comes later.

use crate::geometry::lanes::{Eight, Lanes, take_lowest};
use crate::geometry::scalar::{EightOf, Scalar};
use crate::query::sink::Sink;
use crate::structures::octree::Octree;
use crate::structures::octree::cells::{Content, DEEPEST};
use crate::tree::ray_planes::RayPlanes;

/// The children of a cell. In child number `i` the ray is behind the planes that the bits of `i` name.
#[derive(Clone, Copy)]
struct Children<S> {
    /// Between which parameters the ray is in each.
    from: [S; 8],
    to: [S; 8],
    /// A bit for each that is met and not visited yet.
    waiting: u32,
    first: u32,
}

impl<S: Scalar> Children<S> {
    const NONE: Self = Self { from: [S::ZERO; 8], to: [S::ZERO; 8], waiting: 0, first: 0 };

    /// Of a cell in which the ray is between these parameters, cut by these planes.
    #[inline(always)]
    fn of(ray: &RayPlanes<S>, planes: &[S; 3], first: u32, (t_in, t_out): (S, S)) -> Self {
        let (mut from, mut to) = (EightOf::<S>::splat(t_in), EightOf::<S>::splat(t_out));
        for (k, plane) in planes.iter().enumerate() {
            let (early, late) = ray.crossing_interval(k, *plane);
            // NaN, a ray within the plane, leaves both sides to be visited
            let (early, late) = (early.greater(t_in), late.lesser(t_out));
            let of_each = |before: S, behind: S| {
                let side = |child: usize| if child >> k & 1 == 1 { behind } else { before };
                EightOf::<S>::new(std::array::from_fn(side))
            };
            from = from.greater(of_each(t_in, early));
            to = to.lesser(of_each(late, t_out));
        }
        let waiting = from.at_most(to).high_bits();
        Self { from: from.to_array(), to: to.to_array(), waiting, first }
    }
}

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
        let mut stack = [Children::NONE; DEEPEST];
        let mut depth = 0;
        let (mut cell, mut span) = (0, (t_in, t_out));
        loop {
            match self.cells.content(cell) {
                Content::Inner(planes, first) => {
                    sink.inner_step();
                    stack[depth] = Children::of(ray, planes, first, span);
                    depth += 1;
                }
                Content::Leaf(ids) => {
                    sink.elementary_step(ids.is_empty());
                    if !ids.is_empty() && sink.test(ids).is_break() {
                        return;
                    }
                }
            }
            loop {
                if depth == 0 {
                    return;
                }
                let children = &mut stack[depth - 1];
                if children.waiting == 0 {
                    depth -= 1;
                    continue;
                }
                let child = take_lowest(&mut children.waiting);
                span = (children.from[child], children.to[child]);
                if span.0 <= sink.t_max() {
                    cell = children.first + (child as u32 ^ ray.downwards());
                    break;
                }
            }
        }
    }
}
