//! Eight triangles against one ray: the watertight test in lanes, equal to it to the last bit.
//!
//! Paper: as `triangle.rs`. The arithmetic is that of `Watertight::intersect`, operation by
//! operation, over arrays that the compiler turns into vectors (it never contracts products and
//! sums). A lane whose edge function rounds to zero is left to the scalar test, which finds its
//! exact sign.

use super::triangle::{Shear, TriangleTest, Watertight};
use crate::ray::{Hit, MISS, Ray};
use crate::scalar::Scalar;

/// Triangles in a block.
pub const LANES: usize = 8;

/// In `ids[0]`: another block of the same list follows.
const MORE: u32 = 1 << 31;

/// Up to [`LANES`] triangles, transposed; in f32 five cache lines.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy)]
pub struct TriangleBlock<S> {
    /// By corner, axis and lane; NaN in lanes without a triangle, which nothing hits.
    corners: [[[S; LANES]; 3]; 3],
    ids: [u32; LANES],
}

impl<S: Scalar> TriangleBlock<S> {
    /// The largest number of primitives that ids in blocks can tell apart.
    pub const MOST_IDS: usize = MORE as usize;

    /// Of no more than [`LANES`] triangles; further ones are left out. `more`: another block
    /// of the same list follows.
    pub fn new(triangles: impl Iterator<Item = (u32, [[S; 3]; 3])>, more: bool) -> Self {
        let nan = S::from_f64(f64::NAN);
        let mut this = Self { corners: [[[nan; LANES]; 3]; 3], ids: [MISS; LANES] };
        for (lane, (id, corners)) in triangles.take(LANES).enumerate() {
            this.ids[lane] = id;
            for (i, corner) in corners.iter().enumerate() {
                for (k, x) in corner.iter().enumerate() {
                    this.corners[i][k][lane] = *x;
                }
            }
        }
        if !more {
            this.ids[0] &= !MORE;
        } else {
            this.ids[0] |= MORE;
        }
        this
    }

    /// Whether another block of the same list follows.
    #[inline(always)]
    pub fn has_next(&self) -> bool {
        self.ids[0] & MORE != 0
    }

    /// The id in a lane that has one.
    #[inline(always)]
    fn id(&self, lane: usize) -> u32 {
        if lane == 0 { self.ids[0] & !MORE } else { self.ids[lane] }
    }

    /// Replaces `best` by a closer hit within the ray's interval, or by an equal one of a lower id.
    #[inline(always)]
    pub fn closest(&self, ray: &Ray<S>, shear: &Shear<S>, best: &mut Hit<S>) {
        let (mut lanes, doubtful, mut t) = self.test(ray, shear, best.t);
        if doubtful != 0 {
            lanes |= self.test_again(ray, shear, best.t, doubtful, &mut t);
        }
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let (t, id) = (t[lane], self.id(lane));
            if t < best.t || t == best.t && id < best.id {
                *best = Hit { t, id };
            }
        }
    }

    /// Whether the ray meets a triangle of which `counts` holds.
    #[inline(always)]
    pub fn any(&self, ray: &Ray<S>, shear: &Shear<S>, counts: impl Fn(u32) -> bool) -> bool {
        let (mut lanes, doubtful, mut t) = self.test(ray, shear, ray.t_max);
        if doubtful != 0 {
            lanes |= self.test_again(ray, shear, ray.t_max, doubtful, &mut t);
        }
        while lanes != 0 {
            if counts(self.id(lanes.trailing_zeros() as usize)) {
                return true;
            }
            lanes &= lanes - 1;
        }
        false
    }

    /// Lanes that are hit, lanes that the scalar test must judge, and parameters.
    #[inline(always)]
    fn test(&self, ray: &Ray<S>, shear: &Shear<S>, t_max: S) -> (u32, u32, [S; LANES]) {
        let (a, b, c) = (
            sheared(&self.corners[0], shear),
            sheared(&self.corners[1], shear),
            sheared(&self.corners[2], shear),
        );
        let (mut hits, mut doubts, mut ts) = (0, 0, [S::ZERO; LANES]);
        for l in 0..LANES {
            let u = c[0][l] * b[1][l] - c[1][l] * b[0][l];
            let v = a[0][l] * c[1][l] - a[1][l] * c[0][l];
            let w = b[0][l] * a[1][l] - b[1][l] * a[0][l];
            let doubtful = (u == S::ZERO) | (v == S::ZERO) | (w == S::ZERO);
            let below = (u < S::ZERO) | (v < S::ZERO) | (w < S::ZERO);
            let above = (u > S::ZERO) | (v > S::ZERO) | (w > S::ZERO);
            let det = u + v + w;
            let t = (u * a[2][l] + v * b[2][l] + w * c[2][l]) * shear.shear[2] / det;
            // NaN fails both comparisons with the interval; a zero determinant is no hit
            let hit = !(below & above) & (det != S::ZERO) & (t >= ray.t_min) & (t <= t_max);
            ts[l] = t;
            hits |= u32::from(hit & !doubtful) << l;
            doubts |= u32::from(doubtful) << l;
        }
        (hits, doubts, ts)
    }

    /// The scalar test for some lanes: those that are hit, their parameters written to `t`.
    #[cold]
    #[inline(never)]
    fn test_again(
        &self,
        ray: &Ray<S>,
        shear: &Shear<S>,
        t_max: S,
        lanes: u32,
        t: &mut [S; LANES],
    ) -> u32 {
        let mut hits = 0;
        for (lane, t) in t.iter_mut().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1) {
            let triangle = self.corners.map(|corner| corner.map(|axis| axis[lane]));
            if let Some(found) = Watertight::intersect(&triangle, ray, shear, t_max) {
                *t = found;
                hits |= 1 << lane;
            }
        }
        hits
    }
}

/// The corners of all lanes in the sheared space, as `Shear::apply` has them. A function with this
/// attribute: what is called for each block must not be a call.
#[inline(always)]
fn sheared<S: Scalar>(corner: &[[S; LANES]; 3], shear: &Shear<S>) -> [[S; LANES]; 3] {
    let [kx, ky, kz] = shear.axes;
    let (mut x, mut y, mut z) = (corner[kx.min(2)], corner[ky.min(2)], corner[kz.min(2)]);
    for l in 0..LANES {
        z[l] = z[l] - shear.origin[2];
        x[l] = (x[l] - shear.origin[0]) - shear.shear[0] * z[l];
        y[l] = (y[l] - shear.origin[1]) - shear.shear[1] * z[l];
    }
    [x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    /// Corners and rays on a coarse lattice, so that edges are met exactly and twins tie.
    fn agrees<S: Scalar>() {
        let mut random = Random(3);
        let mut point =
            |cells: f64| [0; 3].map(|_| S::from_f64((random.unit() * cells).floor() / cells));
        let (mut hits, mut ties, mut doubtful) = (0, 0, 0);
        for round in 0..3000 {
            let cells = if round % 2 == 0 { 4.0 } else { 1e6 };
            let mut triangles = [0; 5].map(|_| [0; 3].map(|_| point(cells)));
            triangles[3] = triangles[1];
            // ids descend: lanes are no order of ids
            let numbered = || triangles.iter().enumerate().map(|(i, t)| (90 - i as u32, *t));
            let block = TriangleBlock::new(numbered(), round % 3 == 0);
            assert_eq!(block.has_next(), round % 3 == 0);
            let (from, to) = (point(cells), point(cells));
            let d: [S; 3] = std::array::from_fn(|k| to[k] - from[k]);
            if d == [S::ZERO; 3] {
                continue;
            }
            use crate::scalar::{Vec3, Vector};
            let mut ray = Ray::<S>::new(Vec3::<S>::from_array(from), Vec3::<S>::from_array(d));
            ray.t_max = S::from_f64(3.0);
            let shear = Shear::of(&ray);
            let mut expected = Hit { t: ray.t_max, id: MISS };
            for (id, triangle) in numbered() {
                if let Some(t) = Watertight::intersect(&triangle, &ray, &shear, expected.t)
                    && (t < expected.t || id < expected.id)
                {
                    expected = Hit { t, id };
                }
            }
            let mut best = Hit { t: ray.t_max, id: MISS };
            block.closest(&ray, &shear, &mut best);
            assert_eq!(best, expected, "{round}");
            assert_eq!(block.any(&ray, &shear, |_| true), expected.is_hit());
            assert!(!block.any(&ray, &shear, |_| false));
            hits += usize::from(best.is_hit());
            ties += usize::from(best.id == 87);
            doubtful += usize::from(block.test(&ray, &shear, ray.t_max).1 & 31 != 0);
        }
        assert!(hits > 200 && ties > 30 && doubtful > 100, "{hits} {ties} {doubtful}");
    }

    #[test]
    fn eight_at_once_are_one_after_the_other() {
        agrees::<f32>();
        agrees::<f64>();
        assert_eq!(size_of::<TriangleBlock<f32>>(), 320);
    }
}
