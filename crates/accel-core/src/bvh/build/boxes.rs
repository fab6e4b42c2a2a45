//! Boxes that a tree is built over, four lanes each.

use std::ops::Range;

use obvhs::aabb::Aabb;
use wide::{f32x4, f32x8};

use crate::geometry::lanes::Lanes;
use crate::parallel::map_parts;

/// A box and its number, which stands in the lane behind the lower corner's; behind the upper one's
/// stands of how many boxes it is made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item(pub(super) Bounds);

impl Item {
    pub(super) fn of(aabb: &Aabb, number: u32) -> Self {
        Self::of_cluster(aabb, number, 1)
    }

    /// The box around so many.
    pub(super) fn of_cluster(aabb: &Aabb, number: u32, boxes: u32) -> Self {
        let low = aabb.min.extend(f32::from_bits(number)).to_array();
        let negated = (-aabb.max).extend(f32::from_bits(boxes)).to_array();
        Self(Bounds(bytemuck::cast([f32x4::new(low), f32x4::new(negated)])))
    }

    pub(super) fn half_area(&self) -> f32 {
        self.0.half_area()
    }

    #[inline(always)]
    pub(super) fn boxes(&self) -> u32 {
        self.0.0.to_array()[7].to_bits()
    }

    #[inline(always)]
    pub(super) fn number(&self) -> u32 {
        self.0.0.to_array()[3].to_bits()
    }

    /// Around the sum of both corners. The other two lanes are 0: numbers, read as floats, are
    /// subnormal, and slow to multiply and to divide by on some processors.
    #[inline(always)]
    pub(super) fn centre(&self) -> Bounds {
        let [low, negated] = self.0.corners();
        let exchanged: f32x8 = bytemuck::cast([negated, low]);
        Bounds((self.0.0 - exchanged) & AXES)
    }
}

/// All ones for the axes of both corners.
const AXES: f32x8 = {
    let ones = f32::from_bits(u32::MAX);
    f32x8::new([ones, ones, ones, 0.0, ones, ones, ones, 0.0])
};

/// A box: the lower corner, then the upper one negated, so that one operation joins two boxes; of
/// what is in the fourth and in the last lane nothing is known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds(f32x8);

impl Bounds {
    pub(super) const NONE: Self = Self(f32x8::splat(f32::INFINITY));

    /// The lower corner, and the upper one negated.
    #[inline(always)]
    pub(super) fn corners(&self) -> [f32x4; 2] {
        bytemuck::cast(self.0)
    }

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.0 = self.0.lesser(other.0);
    }

    /// Adds the other if its sign is set, else nothing.
    #[inline(always)]
    pub(super) fn add_if_negative(&mut self, sign: i32, other: &Self) {
        let infinity = f32::INFINITY.to_bits() | sign as u32 & 1 << 31;
        self.0 = self.0.lesser(other.0.greater(f32x8::splat(f32::from_bits(infinity))));
    }

    /// Lengths of the edges, negated.
    #[inline(always)]
    pub(super) fn negated_extent(&self) -> f32x4 {
        let [low, negated] = self.corners();
        low + negated
    }

    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        // products of two are not negative
        let [x, y, z, _] = self.negated_extent().to_array();
        x * y + y * z + z * x
    }

    pub(super) fn aabb(&self) -> Aabb {
        let [x, y, z, _, u, v, w, _] = self.0.to_array();
        Aabb::new([x, y, z].into(), [-u, -v, -w].into())
    }
}

/// Boxes of items and of their centres.
#[derive(Clone, Copy)]
pub(super) struct SetBounds {
    pub(super) items: Bounds,
    pub(super) centres: Bounds,
}

impl SetBounds {
    pub(super) const NONE: Self = Self { items: Bounds::NONE, centres: Bounds::NONE };

    #[inline(always)]
    fn add(&mut self, item: &Item) {
        self.items.add(&item.0);
        self.centres.add(&item.centre());
    }

    pub(super) fn of(items: &[Item]) -> Self {
        let mut around = Self::NONE;
        items.iter().for_each(|item| around.add(item));
        around
    }

    /// The same of many, on all threads.
    pub(super) fn of_all(items: &[Item]) -> Self {
        let of_part = |part: Range<u32>| Self::of(&items[part.start as usize..part.end as usize]);
        let mut around = Self::NONE;
        map_parts(items.len(), of_part).iter().for_each(|part| around.join(part));
        around
    }

    /// Adds the items of the other.
    pub(super) fn join(&mut self, other: &Self) {
        self.items.add(&other.items);
        self.centres.add(&other.centres);
    }
}
