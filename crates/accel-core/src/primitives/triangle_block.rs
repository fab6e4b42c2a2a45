//! Eight triangles against one ray: the watertight test in lanes, equal to it to the last bit.
//!
//! Paper: as `triangle.rs`. The arithmetic is that of `watertight.rs`, operation by operation, in
//! vectors. A lane whose edge function rounds to zero, or whose weights are imprecise, is left to
//! the scalar test, which finds exact signs and better weights (`precise.rs`).

use wide::i32x8;

use crate::geometry::lanes::{Eight, Lanes, take_lowest};
use crate::geometry::ray::{Hit, MISS, Ray};
use crate::geometry::scalar::EightOf;
use crate::geometry::scalar::Scalar;
use crate::primitives::shear::{Shear, near_factor};
use crate::primitives::watertight;

const LANES: usize = 8;

/// A bit for each lane.
const ALL: u32 = (1 << LANES) - 1;

/// In `ids[0]`: another block of the same list follows.
const MORE: u32 = 1 << 31;
/// In `ids[0]`: its triangles do not all move alike.
const APART: u32 = 1 << 30;
/// Bits of `ids[0]` that do not belong to the id.
const MARKS: u32 = MORE | APART;

/// Up to `LANES` triangles, transposed; in f32 five cache lines.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy)]
pub struct TriangleBlock<S> {
    /// By corner, axis and lane; NaN in lanes without a triangle, which nothing hits.
    corners: [[[S; LANES]; 3]; 3],
    ids: [u32; LANES],
}

impl<S: Scalar> TriangleBlock<S> {
    /// Triangles in a block.
    pub const LANES: usize = LANES;
    /// The largest number of primitives that ids in blocks can tell apart.
    pub const MOST_IDS: usize = APART as usize - 1;

    pub(crate) fn empty() -> Self {
        let nan = S::from_f64(f64::NAN);
        let mut this = Self { corners: [[[nan; LANES]; 3]; 3], ids: [MISS; LANES] };
        this.ids[0] &= !MARKS;
        this
    }

    /// Block of the first `LANES` triangles. `more`: another block of the same list follows.
    pub fn new(triangles: impl Iterator<Item = (u32, [[S; 3]; 3])>, more: bool) -> Self {
        let mut this = Self::empty();
        this.fill(triangles, more, true);
        this
    }

    /// Makes an empty one that of these triangles, where it is: a block is large. `as_one`: they
    /// all move alike, or are at rest.
    #[inline(always)]
    pub(crate) fn fill(
        &mut self,
        triangles: impl Iterator<Item = (u32, [[S; 3]; 3])>,
        more: bool,
        as_one: bool,
    ) {
        for (lane, (id, corners)) in triangles.take(LANES).enumerate() {
            self.ids[lane] = id;
            for (i, corner) in corners.iter().enumerate() {
                for (k, x) in corner.iter().enumerate() {
                    self.corners[i][k][lane] = *x;
                }
            }
        }
        self.ids[0] |= if more { MORE } else { 0 } | if as_one { 0 } else { APART };
    }

    /// Returns whether its triangles move alike, or are at rest.
    #[inline(always)]
    pub(crate) fn moves_as_one(&self) -> bool {
        self.ids[0] & APART == 0
    }

    /// Returns whether another block of the same list follows.
    #[inline(always)]
    pub fn has_next(&self) -> bool {
        self.ids[0] & MORE != 0
    }

    /// The ids of its triangles: so many of these.
    #[inline(always)]
    pub fn ids(&self) -> ([u32; LANES], usize) {
        let mut ids = self.ids;
        ids[0] &= !MARKS;
        (ids, ids.iter().take_while(|id| **id | MARKS != MISS).count())
    }

    /// The id in a lane that has one: only the first has marks.
    #[inline(always)]
    pub(crate) fn id(&self, lane: usize) -> u32 {
        self.ids[lane] & !MARKS
    }

    /// By corner, axis and lane; NaN in lanes without a triangle.
    #[inline(always)]
    pub(crate) fn corners(&self) -> &[[[S; LANES]; 3]; 3] {
        &self.corners
    }

    /// The corners in a lane.
    #[inline(always)]
    pub(crate) fn triangle(&self, lane: usize) -> [[S; 3]; 3] {
        self.corners.map(|corner| corner.map(|axis| axis[lane]))
    }

    /// The same triangles in f64.
    #[inline(always)]
    pub(crate) fn widened(&self) -> TriangleBlock<f64> {
        let corners = self.corners.map(|corner| corner.map(|axis| axis.map(S::to_f64)));
        TriangleBlock { corners, ids: self.ids }
    }

    /// Lanes that the watertight test says are hit, with their parameters; `None` or no lanes where
    /// none is.
    #[inline(always)]
    pub(crate) fn hits(
        &self,
        ray: &Ray<S>,
        shear: &Shear<S>,
        t_max: S,
    ) -> Option<(u32, [S; LANES])> {
        let from = StartLanes::same(shear);
        self.hits_from(&from, ray.t_min, shear, t_max, |lane| {
            watertight::intersect(&self.triangle(lane), ray, shear, t_max)
        })
    }

    /// The same of a ray that begins elsewhere for each lane; `again` is the scalar test of a lane.
    #[inline(always)]
    pub(crate) fn hits_from(
        &self,
        from: &StartLanes<S>,
        t_min: S,
        shear: &Shear<S>,
        t_max: S,
        again: impl Fn(usize) -> Option<S>,
    ) -> Option<(u32, [S; LANES])> {
        let (mut lanes, doubtful, mut t) = self.test(from, t_min, shear, t_max)?;
        if doubtful != 0 {
            lanes |= test_again(doubtful, &mut t, again);
        }
        Some((lanes, t))
    }

    /// Replaces `best` by the closest of the lanes that are hit, or by an equal one of a lower id.
    #[inline(always)]
    pub(crate) fn take_closest(&self, mut lanes: u32, t: &[S; LANES], best: &mut Hit<S>) {
        while lanes != 0 {
            let lane = take_lowest(&mut lanes);
            let (t, id) = (t[lane], self.id(lane));
            if t < best.t || t == best.t && id < best.id {
                *best = Hit { t, id };
            }
        }
    }

    /// Whether `counts` holds of any of the lanes that are hit.
    #[inline(always)]
    pub(crate) fn any_of(&self, mut lanes: u32, counts: impl Fn(u32) -> bool) -> bool {
        while lanes != 0 {
            if counts(self.id(take_lowest(&mut lanes))) {
                return true;
            }
        }
        false
    }

    /// Lanes that have a triangle.
    #[inline(always)]
    fn filled(&self) -> u32 {
        // ids are below the highest bit but for that of the first lane, which is always filled
        let is_empty = i32x8::new(bytemuck::cast(self.ids)).to_bitmask();
        (!is_empty & ALL) | 1
    }

    /// Lanes that are hit, lanes that the scalar test must judge, and parameters; `None` where
    /// there are neither.
    #[inline(always)]
    fn test(
        &self,
        from: &StartLanes<S>,
        t_min: S,
        shear: &Shear<S>,
        t_max: S,
    ) -> Option<(u32, u32, [S; LANES])> {
        let splat = EightOf::<S>::splat;
        if shear.is_too_small() {
            return Some((0, self.filled(), [S::ZERO; LANES]));
        }
        let [a, b, c] = sheared_from(&self.corners, &from.origin, shear);
        let products =
            [[c[0] * b[1], c[1] * b[0]], [a[0] * c[1], a[1] * c[0]], [b[0] * a[1], b[1] * a[0]]];
        let [u, v, w] = products.map(|[p, q]| p - q);
        let zero = splat(S::ZERO);
        let (least, most) = (u.lesser(v).lesser(w), u.greater(v).greater(w));
        // not missed where no two have different signs, whatever the sign of one that rounds to
        // zero; without a triangle they are NaN, which fails both comparisons
        let alike = (zero.at_most(least) | most.at_most(zero)).high_bits();
        if alike == 0 {
            return None;
        }
        let doubtful = least.equal(zero) | most.equal(zero);
        let det = u + v + w;
        let x = a[0].absolute().greater(b[0].absolute()).greater(c[0].absolute());
        let y = a[1].absolute().greater(b[1].absolute()).greater(c[1].absolute());
        let largest = x.greater(y);
        let square = largest * largest;
        let [of_u, of_v, of_w] = products.map(|[p, q]| p.absolute() + q.absolute());
        let terms = of_u.greater(of_v).greater(of_w);
        let size = det.absolute();
        let suffice = (terms * largest).below(splat(shear.fine) * size)
            & splat(S::LEAST_DETERMINANT).at_most(size);
        let depth = u * a[2] + v * b[2] + w * c[2];
        let t = depth * splat(shear.depth_scale()) / det;
        // NaN fails all comparisons
        let near = zero.at_most(t) & depth.absolute().below(from.near * square);
        let doubts = (doubtful | near).high_bits() | !suffice.high_bits();
        let within = splat(t_min).at_most(t) & t.at_most(splat(t_max));
        Some((within.high_bits() & alike & !doubts, doubts & alike, t.to_array()))
    }
}

/// The scalar test for some lanes: those that are hit, their parameters written to `t`.
#[cold]
#[inline(never)]
fn test_again<S: Scalar>(
    lanes: u32,
    t: &mut [S; LANES],
    again: impl Fn(usize) -> Option<S>,
) -> u32 {
    let mut hits = 0;
    for (lane, t) in t.iter_mut().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1) {
        if let Some(found) = again(lane) {
            *t = found;
            hits |= 1 << lane;
        }
    }
    hits
}

/// Ray origin per lane, in sheared space; it differs per triangle if triangles move differently.
pub(crate) struct StartLanes<S: Scalar> {
    origin: [EightOf<S>; 3],
    near: EightOf<S>,
}

impl<S: Scalar> StartLanes<S> {
    /// The origin of the sheared ray in all lanes.
    #[inline(always)]
    pub(crate) fn same(shear: &Shear<S>) -> Self {
        let splat = EightOf::<S>::splat;
        Self { origin: shear.origin.map(splat), near: splat(shear.near) }
    }

    /// For each lane what [`Shear::moved_back`] makes of it.
    #[inline(always)]
    pub(crate) fn each(
        velocities: [&[S; 3]; LANES],
        shear: &Shear<S>,
        time: S,
        magnitude: S,
    ) -> Self {
        let splat = EightOf::<S>::splat;
        let along: [_; 3] = std::array::from_fn(|k| {
            let axis = shear.axes[k].min(2);
            EightOf::<S>::new(velocities.map(|velocity| velocity[axis])) * splat(time)
        });
        let origin: [_; 3] = std::array::from_fn(|k| splat(shear.origin[k]) - along[k]);
        let near = splat(near_factor::<S>());
        Self { origin, near: near * (splat(magnitude) + origin[2].absolute()) }
    }
}

/// The corners of all lanes in the sheared space, as `Shear::apply` has them.
#[inline(always)]
pub(super) fn sheared<S: Scalar>(
    corners: &[[[S; LANES]; 3]; 3],
    shear: &Shear<S>,
) -> [[EightOf<S>; 3]; 3] {
    sheared_from(corners, &shear.origin.map(EightOf::<S>::splat), shear)
}

/// The same from an origin for each lane.
#[inline(always)]
fn sheared_from<S: Scalar>(
    corners: &[[[S; LANES]; 3]; 3],
    origin: &[EightOf<S>; 3],
    shear: &Shear<S>,
) -> [[EightOf<S>; 3]; 3] {
    let [kx, ky, kz] = shear.axes;
    let factors = shear.shear.map(EightOf::<S>::splat);
    std::array::from_fn(|i| {
        let corner = &corners[i];
        // SAFETY: `axes` is only ever set to a permutation of 0, 1, 2
        let (x, y, z) = unsafe {
            (corner.get_unchecked(kx), corner.get_unchecked(ky), corner.get_unchecked(kz))
        };
        let z = EightOf::<S>::new(*z) - origin[2];
        let x = (EightOf::<S>::new(*x) - origin[0]) - factors[0] * z;
        let y = (EightOf::<S>::new(*y) - origin[1]) - factors[1] * z;
        [x, y, z]
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use std::any::type_name;

    use super::*;
    use crate::geometry::scalar::{Vec3, Vector};
    use crate::primitives::{TriangleTest, Watertight};
    use crate::structures::test_scenes::Random;

    pub(crate) fn ray_to_3<S: Scalar>(from: [S; 3], direction: [S; 3]) -> Ray<S> {
        let (from, direction) = (Vec3::<S>::from_array(from), Vec3::<S>::from_array(direction));
        Ray { t_max: S::from_f64(3.0), ..Ray::new(from, direction) }
    }

    /// The hit that the block finds, and that its triangles find one after the other.
    pub(crate) fn agreed<S: Scalar, T: TriangleTest<S>>(
        block: &TriangleBlock<S>,
        triangles: impl Iterator<Item = (u32, [[S; 3]; 3])>,
        ray: &Ray<S>,
        setup: &T::Setup,
    ) -> Hit<S> {
        let mut expected = Hit { t: ray.t_max, id: MISS };
        let mut best = expected;
        for (id, triangle) in triangles {
            if let Some(t) = T::intersect(&triangle, ray, setup, expected.t)
                && (t < expected.t || id < expected.id)
            {
                expected = Hit { t, id };
            }
        }
        T::closest_in_block(block, ray, setup, &mut best);
        assert_eq!(best, expected, "{} {ray:?}", type_name::<T>());
        assert_eq!(T::any_in_block(block, ray, setup, |_| true), best.is_hit());
        assert!(!T::any_in_block(block, ray, setup, |_| false));
        best
    }

    /// Corners and rays on a coarse lattice, so that edges are met exactly and twins tie; rays with
    /// components however small; and triangles in whose planes the rays run.
    fn agrees<S: Scalar>(tiny: f64) {
        let mut random = Random(3);
        let mut point =
            |cells: f64| [0; 3].map(|_| S::from_f64((random.unit() * cells).floor() / cells));
        let (mut hits, mut ties, mut doubtful, mut edge_on) = (0, 0, 0, 0);
        for round in 0..4000 {
            let cells = if round % 2 == 0 { 4.0 } else { 1e6 };
            let mut triangles = [0; 5].map(|_| [0; 3].map(|_| point(cells)));
            let (from, to) = (point(cells), point(cells));
            let mut d: [S; 3] = std::array::from_fn(|k| to[k] - from[k]);
            if round % 8 >= 6 {
                // along the ray and across it
                let across = point(1e6);
                let within = |p: [S; 3]| {
                    std::array::from_fn(|k| {
                        from[k] + d[k] * (p[0] + p[1]) + across[k] * (p[2] - p[0])
                    })
                };
                triangles = triangles.map(|t| t.map(within));
            }
            if (4..7).contains(&(round % 8)) {
                d[round % 3] = S::from_f64(tiny);
            }
            triangles[3] = triangles[1];
            // ids descend: lanes are no order of ids
            let numbered = || triangles.iter().enumerate().map(|(i, t)| (90 - i as u32, *t));
            let block = TriangleBlock::new(numbered(), round % 3 == 0);
            assert_eq!(block.has_next(), round % 3 == 0);
            assert_eq!(block.filled(), 31);
            if d == [S::ZERO; 3] {
                continue;
            }
            let ray = ray_to_3(from, d);
            let shear = Shear::of(&ray, S::ONE);
            let best = agreed::<S, Watertight>(&block, numbered(), &ray, &shear);
            hits += usize::from(best.is_hit());
            ties += usize::from(best.id == 87);
            let tested = block.test(&StartLanes::same(&shear), ray.t_min, &shear, ray.t_max);
            let is_doubtful = tested.is_some_and(|(_, doubts, _)| doubts & 31 != 0);
            doubtful += usize::from(is_doubtful && round % 8 < 4);
            edge_on += usize::from(is_doubtful && round % 8 == 7);
        }
        let counts = [hits, ties, doubtful, edge_on];
        assert!(hits > 200 && ties > 30 && doubtful > 100 && edge_on > 100, "{counts:?}");
    }

    #[test]
    fn eight_lanes_equal_eight_single_rays() {
        agrees::<f32>(1e-44);
        agrees::<f64>(1e-322);
        agrees::<f32>(1e-12);
        assert_eq!(size_of::<TriangleBlock<f32>>(), 320);
    }
}
