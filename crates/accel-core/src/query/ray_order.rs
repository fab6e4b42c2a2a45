//! An order of a batch's rays in which neighbours start close to each other and run alike.
//!
//! Papers: B. Moon, Y. Byun, T.-J. Kim, P. Claudio, H.-S. Kim, Y.-J. Ban, S. W. Nam, S.-E. Yoon,
//! "Cache-Oblivious Ray Reordering", TOG 29(3), 2010; K. Garanzha, C. Loop, "Fast Ray Sorting and
//! Breadth-First Packet Traversal for GPU Ray Tracing", EG 2010 (rays sorted by cells of origins
//! and directions). Deviations: the cells are those of one Morton code of all six coordinates,
//! whose bits go to the axis along which cells are longest; a batch whose neighbours start or run
//! alike already keeps its own order, and so does one whose neighbours would not run alike in ours.

use std::array::from_fn;

use crate::counting_sort::{DIGIT_BITS, by_two_digits};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};

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

/// Origin, in units of half the scene's size, and direction, its largest component 1.
type Coordinates = [f32; 6];

/// Cells of rays in the space of their coordinates.
struct RayCells {
    low: Coordinates,
    /// Cells by coordinate.
    per_unit: Coordinates,
    /// By axis and cell: the bits of the code.
    bits: [[u32; 1 << MOST_BITS]; 6],
}

/// The places of the rays in that order, for a scene whose coordinates lie within 2 once they are
/// multiplied by `unit`; `None` where the batch is to keep its own.
pub(crate) fn of<S: Scalar>(rays: &[Ray<S>], unit: f64) -> Option<Vec<u32>> {
    if rays.len() < LEAST_RAYS || !are_scattered(rays, unit as f32) {
        return None;
    }
    let order = RayCells::around(rays, unit as f32).order(rays, unit as f32);
    let eights = order.as_chunks::<8>().0;
    let run_alike = |eight: &[u32; 8]| {
        let [first, rest @ ..] = eight.map(|place| coordinates(&rays[place as usize], 1.0));
        let differ = |a: f32, b: f32| (a - b).abs() > ALIKE || a * b < 0.0;
        !rest.iter().any(|other| (3..6).any(|k| differ(first[k], other[k])))
    };
    let alike = spread(eights.len()).filter(|&at| run_alike(&eights[at])).count();
    (2 * alike > SAMPLED as usize).then_some(order)
}

/// Places all over a batch of so many: where multiples of the golden ratio lie within one.
fn spread(n: usize) -> impl Iterator<Item = usize> {
    let part = |i: u32| u64::from(i.wrapping_mul(0x9e37_79b9));
    (0..SAMPLED).map(move |i| ((part(i) * n as u64) >> 32) as usize)
}

#[inline(always)]
fn coordinates<S: Scalar>(ray: &Ray<S>, unit: f32) -> Coordinates {
    let [ox, oy, oz] = ray.origin.to_array().map(|x| x.to_f64() as f32 * unit);
    let [dx, dy, dz] = ray.direction.to_array().map(|x| x.to_f64() as f32);
    let scale = 1.0 / dx.abs().max(dy.abs()).max(dz.abs());
    [ox, oy, oz, dx * scale, dy * scale, dz * scale]
}

/// Returns whether neighbours neither start nor run alike, measured by how far apart rays from all
/// over the batch are.
fn are_scattered<S: Scalar>(rays: &[Ray<S>], unit: f32) -> bool {
    let eights = rays.as_chunks::<8>().0;
    let (mut near, mut far) = ([0.0; 2], [0.0; 2]);
    let mut before = coordinates(&rays[0], unit);
    for at in spread(eights.len()) {
        let [first, last] = [0, 7].map(|lane| coordinates(&eights[at][lane], unit));
        for (k, axes) in [[0, 1, 2], [3, 4, 5]].into_iter().enumerate() {
            let apart = |a: &Coordinates, b: &Coordinates| {
                axes.iter().fold(0.0f32, |most, &axis| most.max((a[axis] - b[axis]).abs()))
            };
            near[k] += apart(&first, &last);
            far[k] += apart(&before, &first);
        }
        before = first;
    }
    near[0] + near[1] > 0.0 && near[0] * NEARER >= far[0] && near[1] * NEARER >= far[1]
}

impl RayCells {
    /// Cells around most of these rays.
    fn around<S: Scalar>(rays: &[Ray<S>], unit: f32) -> Self {
        let (mut low, mut high) = ([f32::INFINITY; 6], [f32::NEG_INFINITY; 6]);
        for at in spread(rays.len()) {
            for (k, x) in coordinates(&rays[at], unit).into_iter().enumerate() {
                (low[k], high[k]) = (low[k].min(x), high[k].max(x));
            }
        }
        let mut lengths: Coordinates = from_fn(|k| high[k] - low[k]);
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
            for (cell, bits) in bits.iter_mut().enumerate() {
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
        Self { low, per_unit, bits }
    }

    #[inline(always)]
    fn code(&self, at: &Coordinates) -> u32 {
        let of = |k: usize| {
            let cell = ((at[k] - self.low[k]) * self.per_unit[k]) as u8;
            self.bits[k][usize::from(cell)]
        };
        of(0) | of(1) | of(2) | of(3) | of(4) | of(5)
    }

    /// The places of the rays, sorted by their codes.
    fn order<S: Scalar>(&self, rays: &[Ray<S>], unit: f32) -> Vec<u32> {
        let code = |ray| u64::from(self.code(&coordinates(ray, unit)));
        let coded = rays.iter().zip(0..).map(|(ray, place)| code(ray) << 32 | place);
        let coded = by_two_digits(coded.collect(), 32);
        coded.into_iter().map(|coded| coded as u32).collect()
    }
}
