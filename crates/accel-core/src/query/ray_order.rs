//! An order of a batch's rays in which neighbours start close to each other and run alike.
//!
//! Papers: B. Moon, Y. Byun, T.-J. Kim, P. Claudio, H.-S. Kim, Y.-J. Ban, S. W. Nam, S.-E. Yoon,
//! "Cache-Oblivious Ray Reordering", TOG 29(3), 2010; K. Garanzha, C. Loop, "Fast Ray Sorting and
//! Breadth-First Packet Traversal for GPU Ray Tracing", EG 2010 (rays sorted by cells of origins
//! and directions). Deviations: the cells are those of one Morton code of all six coordinates,
//! whose bits go to the axis along which cells are longest; a ray's end stands for its origin where
//! ends lie closer together; a batch whose neighbours start or run alike already keeps its own order,
//! and so does one whose neighbours would not run alike in ours.

use std::array::from_fn;

use wide::f32x8;

use crate::counting_sort::{DIGIT_BITS, by_two_digits};
use crate::geometry::lanes::{Eight, Lanes};
use crate::geometry::ray::Ray;
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::Scalar;

/// Smaller batches keep their order.
const LEAST_RAYS: usize = 4096;
/// So many rays of a batch are looked at, or groups of eight.
const SAMPLED: u32 = 128;
/// Neighbours start or run alike where they are so many times nearer to each other than rays from
/// all over the batch.
const NEARER: f32 = 4.0;
/// Rays go together if their origins lie within this part of the scene's size, on each axis, and
/// their directions within this part of their largest component.
pub(crate) const ALIKE: f32 = 0.125;

/// Bits of a code: two digits of a sort.
const CODE_BITS: usize = 2 * DIGIT_BITS as usize;
/// Bits of each coordinate at most.
const MOST_BITS: usize = 8;

/// Of eight rays: a point of each, in units of half the scene's size, and direction, its largest
/// component 1.
type Coordinates = [[f32; LANES]; 6];

/// Cells of rays in the space of their coordinates.
struct RayCells {
    /// The point of a ray is its end.
    by_ends: bool,
    low: [f32; 6],
    /// Cells by coordinate.
    per_unit: [f32; 6],
    /// The last cell of each axis.
    last: [f32; 6],
    /// By axis and cell, up to the last one: the bits of the code.
    bits: [[u32; 1 << MOST_BITS]; 6],
}

/// The places of the rays in that order, for a scene whose coordinates lie within 2 once they are
/// multiplied by `unit`; `None` where the batch is to keep its own.
pub(crate) fn of<S: Scalar>(rays: &[Ray<S>], unit: f64) -> Option<Vec<u32>> {
    let unit = unit as f32;
    let eights = rays.as_chunks().0;
    if rays.len() < LEAST_RAYS || !are_scattered(eights, unit) {
        return None;
    }
    let cells = RayCells::around(eights, unit);
    cells.put_like_rays_together(rays, unit).then(|| cells.order(rays, unit))
}

/// Places all over so many: where multiples of the golden ratio lie within one.
fn spread(n: usize) -> impl Iterator<Item = usize> {
    let part = |i: u32| u64::from(i.wrapping_mul(0x9e37_79b9));
    (0..SAMPLED).map(move |i| ((part(i) * n as u64) >> 32) as usize)
}

#[inline(always)]
fn coordinates<S: Scalar>(rays: &[Ray<S>; LANES], unit: f32, by_ends: bool) -> Coordinates {
    let RayLanes { origin, direction, t_max, .. } = RayLanes::of(rays);
    let lanes = |column: [S; LANES]| f32x8::new(column.map(|x| x.to_f64() as f32));
    let (origin, direction) = (origin.map(lanes), direction.map(lanes));
    let [x, y, z] = direction.map(Eight::absolute);
    let scale = f32x8::splat(1.0) / x.greater(y).greater(z);
    from_fn(|k| match k {
        0..3 if by_ends => (origin[k] + direction[k] * lanes(t_max)) * f32x8::splat(unit),
        0..3 => origin[k] * f32x8::splat(unit),
        _ => direction[k - 3] * scale,
    })
    .map(f32x8::to_array)
}

/// Returns whether neighbours neither start nor run alike, measured by how far apart rays from all
/// over the batch are.
fn are_scattered<S: Scalar>(eights: &[[Ray<S>; LANES]], unit: f32) -> bool {
    let (mut near, mut far) = ([0.0; 2], [0.0; 2]);
    let mut before = coordinates(&eights[0], unit, false);
    for at in spread(eights.len()) {
        let here = coordinates(&eights[at], unit, false);
        for (k, axes) in [[0, 1, 2], [3, 4, 5]].into_iter().enumerate() {
            let apart = |other: &Coordinates, lane: usize| {
                let of = |&axis: &usize| (here[axis][0] - other[axis][lane]).abs();
                axes.iter().map(of).fold(0.0, f32::max)
            };
            near[k] += apart(&here, LANES - 1);
            far[k] += apart(&before, 0);
        }
        before = here;
    }
    near[0] + near[1] > 0.0 && near[0] * NEARER >= far[0] && near[1] * NEARER >= far[1]
}

/// The least and the greatest coordinates of some of the rays, a quarter of those that are looked at
/// elsewhere.
fn bounds<S: Scalar>(eights: &[[Ray<S>; LANES]], unit: f32, by_ends: bool) -> [[f32; 6]; 2] {
    let [mut low, mut high] = [[f32::INFINITY; 6], [f32::NEG_INFINITY; 6]];
    for at in spread(eights.len()).take(SAMPLED as usize / 4) {
        for (k, lanes) in coordinates(&eights[at], unit, by_ends).into_iter().enumerate() {
            low[k] = lanes.into_iter().fold(low[k], f32::min);
            high[k] = lanes.into_iter().fold(high[k], f32::max);
        }
    }
    [low, high]
}

impl RayCells {
    /// Cells around most of these rays, by their ends if these lie closer together than their
    /// origins do, as those of shadow rays at a light.
    fn around<S: Scalar>(eights: &[[Ray<S>; LANES]], unit: f32) -> Self {
        let [starts, ends] = [false, true].map(|by_ends| bounds(eights, unit, by_ends));
        let lengths = |[low, high]: &[[f32; 6]; 2]| -> [f32; 6] { from_fn(|k| high[k] - low[k]) };
        let [sx, sy, sz, ..] = lengths(&starts);
        let longest = sx.max(sy).max(sz);
        // those of rays without an end are infinite or not numbers
        let by_ends = lengths(&ends)[..3].iter().all(|&length| length < longest);
        let [low, high] = if by_ends { ends } else { starts };
        let mut lengths = lengths(&[low, high]);
        let mut axes = [0; CODE_BITS];
        let mut counts = [0; 6];
        for axis in &mut axes {
            let free = (0..6).filter(|&k| counts[k] < MOST_BITS);
            *axis = free.max_by(|&a, &b| lengths[a].total_cmp(&lengths[b])).unwrap_or(0);
            counts[*axis] += 1;
            lengths[*axis] /= 2.0;
        }
        let mut bits = [[0; 1 << MOST_BITS]; 6];
        for (k, bits) in bits.iter_mut().enumerate() {
            for (cell, bits) in bits[..1 << counts[k]].iter_mut().enumerate() {
                let mut left = counts[k];
                for axis in axes {
                    *bits <<= 1;
                    if axis == k {
                        left -= 1;
                        *bits |= (cell >> left & 1) as u32;
                    }
                }
            }
        }
        let per_unit =
            from_fn(|k| (1 << counts[k]) as f32 / (high[k] - low[k]).max(f32::MIN_POSITIVE));
        let last = counts.map(|bits| ((1 << bits) - 1) as f32);
        Self { by_ends, low, per_unit, last, bits }
    }

    /// The codes of eight rays.
    #[inline(always)]
    fn codes<S: Scalar>(&self, rays: &[Ray<S>; LANES], unit: f32) -> [u32; LANES] {
        let mut codes = [0; LANES];
        for (k, x) in coordinates(rays, unit, self.by_ends).into_iter().enumerate() {
            let low = f32x8::splat(self.low[k]);
            let cells = (f32x8::new(x) - low) * f32x8::splat(self.per_unit[k]);
            let cells =
                cells.greater(f32x8::splat(0.0)).lesser(f32x8::splat(self.last[k])).truncate();
            for (code, cell) in codes.iter_mut().zip(cells.to_array()) {
                *code |= self.bits[k][usize::from(cell as u8)];
            }
        }
        codes
    }

    /// Returns whether most neighbours in that order run alike: one ray of eight is put into it, so
    /// that two neighbours are as far apart as the first and the last of eight will be.
    fn put_like_rays_together<S: Scalar>(&self, rays: &[Ray<S>], unit: f32) -> bool {
        let some: Vec<_> = rays.iter().step_by(LANES).copied().collect();
        let order = self.order(&some, unit);
        let eights = order.as_chunks::<LANES>().0;
        let alike = spread(eights.len()).map(|at| {
            let rays = eights[at].map(|place| some[place as usize]);
            let [_, _, _, directions @ ..] = coordinates(&rays, unit, false);
            let run_alike = |d: &[f32; LANES], lane: usize| {
                (d[lane] - d[lane + 1]).abs() <= ALIKE && d[lane] * d[lane + 1] >= 0.0
            };
            let pairs = 0..LANES - 1;
            pairs.filter(|&lane| directions.iter().all(|d| run_alike(d, lane))).count()
        });
        alike.sum::<usize>() > SAMPLED as usize * (LANES - 1) * 3 / 4
    }

    /// The places of the rays, sorted by their codes.
    fn order<S: Scalar>(&self, rays: &[Ray<S>], unit: f32) -> Vec<u32> {
        let (eights, rest) = rays.as_chunks();
        let mut coded = Vec::with_capacity(rays.len());
        for (eight, first) in eights.iter().zip((0..).step_by(LANES)) {
            let codes = self.codes(eight, unit).into_iter().zip(first..);
            coded.extend(codes.map(|(code, place): (_, u64)| u64::from(code) << 32 | place));
        }
        // fewer than eight: they go alone wherever they stand
        let rest = rays.len() - rest.len()..rays.len();
        let coded = by_two_digits(coded, 32, 1).into_iter().map(|coded| coded as u32);
        coded.chain(rest.map(|place| place as u32)).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::structures::test_scenes::Random;

    /// From points within the unit cube to others, ending there or nowhere.
    fn rays(mut to: impl FnMut(DVec3) -> DVec3, t_max: f32) -> Vec<Ray<f32>> {
        let mut random = Random(3);
        let ray = |_| {
            let from = random.point([1.0; 3]);
            Ray { t_max, ..Ray::from_dvec3(from, to(from) - from) }
        };
        (0..1 << 15).map(ray).collect()
    }

    fn by_ends(rays: &[Ray<f32>]) -> bool {
        RayCells::around(rays.as_chunks().0, 1.0).by_ends
    }

    #[test]
    fn rays_to_a_light_are_sorted_by_their_ends() {
        let light = DVec3::new(0.5, 0.5, 4.0);
        let shadow = rays(|_| light, 1.0);
        assert!(by_ends(&shadow) && !by_ends(&rays(|_| light, f32::INFINITY)));
        let order = of(&shadow, 1.0).unwrap();
        let mut places = order.clone();
        places.sort_unstable();
        assert!(places.into_iter().eq(0..1 << 15));
        // eight of them share a 48th of the range of directions
        let apart = order.as_chunks::<8>().0.iter().map(|eight| {
            let [_, _, _, x, y, _] = coordinates(&eight.map(|at| shadow[at as usize]), 1.0, true);
            [x, y].map(|x| x.into_iter().fold(0.0f32, |most, other| most.max((other - x[0]).abs())))
        });
        let mean = apart.flatten().sum::<f32>() / (2 * order.len() / 8) as f32;
        assert!(mean < 1.0 / 3.0 / 48.0, "{mean}");
    }

    #[test]
    fn rays_of_all_directions_keep_their_order() {
        let mut random = Random(5);
        let everywhere = rays(|from| from + random.point([2.0; 3]) - 1.0, f32::INFINITY);
        assert!(!by_ends(&everywhere) && of(&everywhere, 1.0).is_none());
    }
}
