//! Rigid parts in the next frame: the structures of objects stay, copies are where they stand now.
//!
//! An object's structure stays in the space that its first copy had when it was built; from the
//! next frame on a ray is carried there from the first copy as well.

use glam::DAffine3;

use super::object::{Copy, Members, margin, padding_of};
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::primitives::Primitives;

/// Factor by which margins are enlarged when objects are built, so that they suffice for later
/// frames.
pub(super) const ROOM_FOR_FRAMES: f64 = 4.0;

/// State of the build that updates need.
#[derive(Default)]
pub(super) struct Frames<S: Scalar> {
    pub objects: Vec<FirstCopy>,
    /// The boxes of the copies, as the upper structure was built over them.
    pub tight: Vec<Aabb<S>>,
}

/// Place of an object's structure.
pub(super) struct FirstCopy {
    /// Placement of its first copy; `None` for primitives outside of copies, which do not move.
    placement: Option<DAffine3>,
    /// Epsilons by which the boxes of its primitives are larger.
    margin: f64,
}

impl FirstCopy {
    pub fn of<S: Scalar>(
        members: &Members,
        first: u32,
        prims: &dyn Primitives<S>,
        margin: f64,
    ) -> Self {
        let part = prims.instances().and_then(|instances| instances.part_of(first));
        let is_part = *members == Members::Consecutive;
        Self { placement: part.filter(|_| is_part).map(|part| part.placement), margin }
    }
}

impl<S: Scalar> Frames<S> {
    pub fn bytes(&self) -> u64 {
        (size_of_val(self.objects.as_slice()) + size_of_val(self.tight.as_slice())) as u64
    }

    /// Places all copies as the parts of these primitives are; `count` says how many primitives an
    /// object has. False where that cannot be: something moved that is part of nothing, a part is
    /// another one, or rounding there is more than margins are for. All is of no use then.
    pub fn place(
        &mut self,
        copies: &mut [Copy<S>],
        count: impl Fn(u32) -> u32,
        prims: &dyn Primitives<S>,
        moved: &[u32],
    ) -> bool {
        let Some(parts) = prims.instances() else { return false };
        if moved.iter().any(|&id| parts.part_of(id).is_none()) {
            return false;
        }
        let magnitude = prims.magnitude();
        let padding = padding_of(magnitude);
        for (copy, tight) in copies.iter_mut().zip(&mut self.tight) {
            let object = &self.objects[copy.object as usize];
            let count = count(copy.object);
            if let Some(built) = object.placement {
                let part = parts.part_of(copy.first);
                let Some(part) = part.filter(|p| (p.first, p.count) == (copy.first, count)) else {
                    return false;
                };
                let is_there = part.placement == built;
                copy.to_first = (!is_there).then(|| built * part.placement.inverse());
                let ids = copy.first..copy.first + count;
                let begin = moved.partition_point(|&id| id < ids.start);
                if moved.get(begin).is_some_and(|&id| id < ids.end) {
                    *tight = ids.fold(Aabb::empty(), |all, id| all.union(prims.bounds(id)));
                }
            }
            let needed = margin([copy.to_first].into_iter(), magnitude.to_f64());
            // NaN is no margin either
            let is_served = needed <= object.margin && tight.is_finite();
            if !is_served {
                return false;
            }
            copy.bounds = tight.expanded(padding);
        }
        true
    }
}
