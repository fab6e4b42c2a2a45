//! Boxes that a tree is built over, four lanes each.

use std::ops::Range;

use obvhs::aabb::Aabb;
use wide::{f32x4, i32x4};

use crate::geometry::lanes::{Four, Lanes};
use crate::parallel::map_parts;

/// A box and its number, which stands in the fourth lane of `low`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item(pub(super) Bounds);

impl Item {
    pub(super) fn of(aabb: &Aabb, number: u32) -> Self {
        Self::of_cluster(aabb, number, 1)
    }

    /// The box around so many.
    pub(super) fn of_cluster(aabb: &Aabb, number: u32, boxes: u32) -> Self {
        let ([x, y, z], [u, v, w]) = (aabb.min.to_array(), aabb.max.to_array());
        Self(Bounds {
            low: f32x4::new([x, y, z, f32::from_bits(number)]),
            high: f32x4::new([u, v, w, f32::from_bits(boxes)]),
        })
    }

    pub(super) fn half_area(&self) -> f32 {
        self.0.half_area()
    }

    pub(super) fn boxes(&self) -> u32 {
        self.0.high.to_array()[3].to_bits()
    }

    pub(super) fn number(&self) -> u32 {
        self.0.low.to_array()[3].to_bits()
    }

    #[inline(always)]
    pub(super) fn centre(&self) -> f32x4 {
        (self.0.low + self.0.high) & XYZ
    }
}

/// All ones for the axes. A number would be a subnormal one, slow to multiply on some processors.
const XYZ: f32x4 =
    f32x4::new([f32::from_bits(u32::MAX), f32::from_bits(u32::MAX), f32::from_bits(u32::MAX), 0.0]);

/// A box; of what is in the fourth lanes nothing is known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub(super) low: f32x4,
    pub(super) high: f32x4,
}

impl Bounds {
    pub(super) const NONE: Self =
        Self { low: f32x4::splat(f32::INFINITY), high: f32x4::splat(f32::NEG_INFINITY) };

    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.low = self.low.lesser(other.low);
        self.high = self.high.greater(other.high);
    }

    /// Adds the other where the mask is set.
    #[inline(always)]
    fn add_where(&mut self, mask: i32x4, other: &Self) {
        self.add(&Self {
            low: other.low.where_set(mask, Self::NONE.low),
            high: other.high.where_set(mask, Self::NONE.high),
        });
    }

    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let [x, y, z, _] = (self.high - self.low).to_array();
        x * y + y * z + z * x
    }

    pub(super) fn aabb(&self) -> Aabb {
        let ([x, y, z, _], [u, v, w, _]) = (self.low.to_array(), self.high.to_array());
        Aabb::new([x, y, z].into(), [u, v, w].into())
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
        let centre = item.centre();
        self.items.add(&item.0);
        self.centres.add(&Bounds { low: centre, high: centre });
    }

    /// Adds the item where the mask is set.
    #[inline(always)]
    pub(super) fn add_where(&mut self, mask: i32x4, item: &Item) {
        let centre = item.centre();
        self.items.add_where(mask, &item.0);
        self.centres.add_where(mask, &Bounds { low: centre, high: centre });
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
        for part in map_parts(items.len(), of_part) {
            around.items.add(&part.items);
            around.centres.add(&part.centres);
        }
        around
    }
}
