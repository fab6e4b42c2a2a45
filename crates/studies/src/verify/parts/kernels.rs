//! The test of eight triangles at once against that of one after the other.
//!
//! Structures choose between them, and instruction sets do: what a block says must be what the test
//! of one triangle says, to the last bit, on whatever the program was compiled for.

use accel_core::geometry::scalar::{Vec3, Vector};
use accel_core::primitives::Shear;
use accel_core::primitives::{PrimSet, TriangleBlock, TriangleSet, TriangleTest, Watertight};
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray};

use super::{Findings, Part};
use crate::verify::draw::{one_of, signed, unit, whole};
use statistics::random::Random;

/// The block of eight.
pub const KERNELS: &[Part] =
    &[Part { name: "triangle-block", single: block::<f32>, double: block::<f64> }];

/// Three corners.
type Triangle<S> = [[S; 3]; 3];

/// Triangles with their ids.
type Numbered<S> = [(u32, Triangle<S>)];

fn block<S: Buildable>(random: &mut Random, rays: usize) -> Findings {
    examine::<S>(random, rays, |triangles, ray, best| {
        let block = TriangleBlock::new(triangles.iter().copied(), false);
        let coordinates = triangles.iter().flat_map(|(_, corners)| corners.iter().flatten());
        let magnitude = coordinates.fold(S::ZERO, |most, c| most.greater(c.abs()));
        let shear = Shear::of(ray, magnitude);
        Watertight::closest_in_block(&block, ray, &shear, best);
        Watertight::any_in_block(&block, ray, &shear, |_| true)
    })
}

/// Asks a kernel for the closest hit of a ray among up to eight triangles, in place of a hit beyond
/// which none counts, and whether there is any within the ray's own interval.
pub fn examine<S: Buildable>(
    random: &mut Random,
    rays: usize,
    kernel: impl Fn(&Numbered<S>, &Ray<S>, &mut Hit<S>) -> bool,
) -> Findings {
    let mut findings = Findings::default();
    for _ in 0..rays {
        let (triangles, ray) = draw::<S>(random);
        let mut best = Hit { t: ray.t_max, ..Hit::NONE };
        let any = kernel(&triangles, &ray, &mut best);
        let (right, is_hit) = one_by_one(&triangles, &ray);
        let is_same = best.id == right.id && best.t == right.t && any == is_hit;
        let told = || format!("{ray:?}: {best:?} and {any}, one by one {right:?} and {is_hit}");
        findings.record(if is_same { Ok(0) } else { Err(told()) });
    }
    findings
}

fn one_by_one<S: Buildable>(triangles: &Numbered<S>, ray: &Ray<S>) -> (Hit<S>, bool) {
    let mut best = Hit { t: ray.t_max, ..Hit::NONE };
    let corners = triangles.iter().map(|(_, corners)| *corners).collect();
    // refused only for what is not finite
    let Ok(set) = TriangleSet::<S>::new(corners, |_| false) else { return (best, false) };
    let setup = set.setup(ray);
    let mut is_hit = false;
    for (i, &(id, _)) in (0_u32..).zip(triangles) {
        if let Some(t) = set.intersect(i, ray, &setup, ray.t_max) {
            is_hit = true;
            if t < best.t || t == best.t && id < best.id {
                best = Hit { t, id };
            }
        }
    }
    (best, is_hit)
}

/// Up to eight triangles and a ray at them: on a coarse lattice, where edges are met exactly and
/// parameters tie, or anywhere; far away, tiny, or with a component next to nothing.
fn draw<S: Buildable>(random: &mut Random) -> (Vec<(u32, Triangle<S>)>, Ray<S>) {
    let is_coarse = random.below(2) == 0;
    let size: f64 = one_of(random, &[1.0, 1.0, 1e-6, 1e6]);
    let at = size * one_of(random, &[0.0, 0.0, 1000.0]);
    let coordinate = |random: &mut Random| {
        at + size * if is_coarse { whole(random, 2) } else { signed(random) * 2.0 }
    };
    let point = |random: &mut Random| [0; 3].map(|_| S::from_f64(coordinate(random)));
    let many = 1 + random.below(8);
    let first = random.below(90) as u32;
    let mut triangles: Vec<(u32, Triangle<S>)> =
        (0..many as u32).map(|i| (first + i, [0; 3].map(|_| point(random)))).collect();
    let twin = triangles.first().map(|(_, first)| *first);
    if let (Some(twin), Some(last)) = (twin, triangles.last_mut()) {
        last.1 = twin;
    }
    // lines have no area: sets of triangles take care of those themselves
    triangles.retain(|(_, t)| has_area(t));
    // lanes are no order of ids
    random.shuffle(&mut triangles);
    let (from, to) = (point(random), point(random));
    let mut d: [S; 3] = std::array::from_fn(|k| to[k] - from[k]);
    if random.below(4) == 0 {
        let tiny = one_of(random, &[0.0, -0.0, 1e-45, -1e-40, 1e-30]);
        d[random.below(3)] = S::from_f64(tiny);
    }
    let mut ray = Ray::new(Vec3::<S>::from_array(from), Vec3::<S>::from_array(d));
    ray.t_min = S::from_f64(one_of(random, &[0.0, -1.0, 0.5]));
    let short = 0.5 + unit(random);
    ray.t_max = S::from_f64(one_of(random, &[f64::INFINITY, 3.0, short]));
    (triangles, ray)
}

/// Whether sets keep it as it is.
fn has_area<S: Buildable>(&triangle: &Triangle<S>) -> bool {
    TriangleSet::<S>::new(vec![triangle], |_| false)
        .is_ok_and(|set| set.triangles().first() == Some(&triangle))
}
