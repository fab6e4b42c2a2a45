//! How much of each proven bound rounding uses: the greatest error that a directed search finds in
//! f32, over the bound of `proofs/`. None may be above it, and a bound far above what is ever seen
//! would cost time for nothing.
//!
//! The search climbs: one of the numbers that an error is made from is changed at a time, by steps
//! of all sizes, as long as the error grows. Exact values are those of f64.

use std::sync::LazyLock;

use accel_core::primitives::{MixedSet, MixedSetBuilder, PrimSet, TriangleSet, Watertight};
use accel_core::{Ray, Vec3};
use glam::{DVec3, dvec3};

use crate::common::Random;
use crate::proofs::constant;

const EPSILON: f64 = f32::EPSILON as f64;
/// Rays start within so many magnitudes of a scene.
const NEAR: f64 = 8.0;

/// The greatest error over parameters in [0, 1); `None` where there is none.
fn greatest<const N: usize>(error: impl Fn(&[f64; N]) -> Option<f64>) -> f64 {
    greatest_of(60, error)
}

/// The greatest error of so many searches.
fn greatest_of<const N: usize>(searches: usize, error: impl Fn(&[f64; N]) -> Option<f64>) -> f64 {
    let mut random = Random::new(26);
    let mut greatest = 0.0f64;
    for _ in 0..searches {
        let mut at: [f64; N] = std::array::from_fn(|_| random.unit());
        let mut seen = error(&at).unwrap_or(0.0);
        for _ in 0..3_000 {
            let mut next = at;
            for _ in 0..1 + (random.unit() * 2.0) as usize {
                let k = (random.unit() * N as f64) as usize;
                let step = (random.unit() - 0.5) * 10f64.powf(-8.0 * random.unit());
                next[k] = (next[k] + step).rem_euclid(1.0).min(0.999_999_9);
            }
            if let Some(found) = error(&next).filter(|found| *found >= seen) {
                (at, seen) = (next, found);
            }
        }
        greatest = greatest.max(seen);
    }
    greatest
}

/// A number in [-1, 1).
fn signed(unit: f64) -> f64 {
    unit * 2.0 - 1.0
}

/// A corner in the sheared space: computed, and exact.
fn sheared(v: [f32; 2], o: [f32; 2], d: [f32; 2]) -> [f64; 2] {
    let inverse = 1.0 / d[1];
    let slope = d[0] * inverse;
    let (x, z) = (v[0] - o[0], v[1] - o[1]);
    let wide = |x: f32| f64::from(x);
    let exact = wide(v[0]) - wide(o[0]) - wide(d[0]) / wide(d[1]) * (wide(v[1]) - wide(o[1]));
    [f64::from(x - slope * z), exact]
}

fn corners_moved(far: f64) -> f64 {
    greatest(|p: &[f64; 7]| {
        let magnitude = 1.0 + p[0];
        let at = |unit: f64, size: f64| (signed(unit) * size * magnitude) as f32;
        let (v, o) = ([at(p[1], 1.0), at(p[2], 1.0)], [at(p[3], far), at(p[4], far)]);
        let long = (1.0 + p[5]) as f32;
        let [found, exact] = sheared(v, o, [(signed(p[6]) * f64::from(long)) as f32, long]);
        // none of a triangle that the ray meets is farther away
        (found.abs() <= 4.0 * magnitude).then_some((found - exact).abs() / (EPSILON * magnitude))
    })
}

/// Weights of a triangle across the ray, computed and exact; `None` where the ray passes it by.
fn weights(corners: &[[f32; 2]; 3]) -> Option<[[f64; 3]; 2]> {
    let [a, b, c] = corners;
    let of = |p: &[f32; 2], q: &[f32; 2]| f64::from(p[0] * q[1] - p[1] * q[0]);
    let wide = |x: f32| f64::from(x);
    // each product is exact in f64
    let exact = |p: &[f32; 2], q: &[f32; 2]| wide(p[0]) * wide(q[1]) - wide(p[1]) * wide(q[0]);
    let exact = [exact(c, b), exact(a, c), exact(b, a)];
    let is_hit = exact.iter().all(|w| *w > 0.0) || exact.iter().all(|w| *w < 0.0);
    is_hit.then_some([[of(c, b), of(a, c), of(b, a)], exact])
}

fn largest(corners: &[[f32; 2]; 3]) -> f64 {
    corners.iter().flatten().fold(0.0, |m: f64, x| m.max(f64::from(x.abs())))
}

/// Corners across the ray, half of them of a thin triangle.
fn across(p: &[f64; 8]) -> [[f32; 2]; 3] {
    let thin = if p[6] < 0.5 { 1.0 } else { 10f64.powf(-6.0 * p[7]) };
    let at = |i: usize| {
        let (x, y) = (signed(p[2 * i]), signed(p[2 * i + 1]));
        [x as f32, (y * thin + x * (1.0 - thin)) as f32]
    };
    [at(0), at(1), at(2)]
}

fn weights_off() -> f64 {
    greatest(|p: &[f64; 8]| {
        let corners = across(p);
        let [found, _] = weights(&corners)?;
        let terms = |i: usize, k: usize| {
            let (p, q) = (corners[i], corners[k]);
            f64::from((p[0] * q[1]).abs() + (p[1] * q[0]).abs())
        };
        let terms = terms(2, 1).max(terms(0, 2)).max(terms(1, 0));
        let det: f64 = found.iter().sum();
        // the smallest scene for whose largest coordinate the code takes these weights
        let magnitude = terms * largest(&corners) / (4.0 * det.abs());
        let off = |k: usize| {
            let sum: f64 = (0..3).map(|i| found[i] * f64::from(corners[i][k])).sum();
            (sum / det).abs()
        };
        Some(off(0).max(off(1)) / (EPSILON * magnitude))
    })
}

fn depth_off() -> f64 {
    greatest(|p: &[f64; 11]| {
        let corners = across(p.first_chunk()?);
        let [found, exact] = weights(&corners)?;
        let depths = [signed(p[8]), signed(p[9]), signed(p[10])].map(|z| z as f32);
        let most = depths.iter().fold(0.0, |m: f64, z| m.max(f64::from(z.abs())));
        let [u, v, w] = found.map(|w| w as f32);
        let depth = f64::from(u * depths[0] + v * depths[1] + w * depths[2]);
        let right: f64 = (0..3).map(|i| exact[i] * f64::from(depths[i])).sum();
        Some((depth - right).abs() / (EPSILON * largest(&corners).powi(2) * most))
    })
}

fn along(far: f64) -> f64 {
    greatest(|p: &[f64; 13]| {
        let corners = across(p.first_chunk()?);
        let [found, _] = weights(&corners)?;
        let magnitude = 1.0 + p[8];
        let o = (signed(p[9]) * far * magnitude) as f32;
        let v = [p[10], p[11], p[12]].map(|x| (signed(x) * magnitude) as f32);
        let depths = v.map(|v| v - o);
        let [u, v_, w] = found.map(|w| w as f32);
        let long = (1.0 + p[7]) as f32;
        let t = (u * depths[0] + v_ * depths[1] + w * depths[2]) * (1.0 / long) / (u + v_ + w);
        let sum: f64 = (0..3).map(|i| found[i] * (f64::from(v[i]) - f64::from(o))).sum();
        let exact = sum / found.iter().sum::<f64>();
        Some((f64::from(t) * f64::from(long) - exact).abs() / (EPSILON * magnitude))
    })
}

fn voxel_planes() -> f64 {
    greatest(|p: &[f64; 6]| {
        let magnitude = 1.0 + p[0];
        let [o, d] = [(signed(p[1]) * NEAR * magnitude) as f32, (1.0 + p[2]) as f32];
        let lo = (-magnitude * p[3]) as f32;
        let n = 1.0 + (p[4] * 1000.0).floor();
        let cell = ((magnitude - f64::from(lo)) / n) as f32;
        let plane = (p[5] * n).floor() as f32;
        let t = (plane * cell + (lo - o)) * (1.0 / d);
        let exact = f64::from(plane) * f64::from(cell) + f64::from(lo) - f64::from(o);
        Some((f64::from(t) * f64::from(d) - exact).abs() / (EPSILON * magnitude))
    })
}

fn placement() -> f64 {
    greatest(|p: &[f64; 4]| {
        let magnitude = 1.0 + p[0];
        let [lo, x] = [-magnitude * p[1], signed(p[2]) * magnitude].map(|x| x as f32);
        let cell = ((magnitude - f64::from(lo)) / (1.0 + (p[3] * 1000.0).floor())) as f32;
        let index = (x - lo) * (1.0 / cell);
        let exact = f64::from(x) - f64::from(lo);
        (x >= lo)
            .then_some((f64::from(index) * f64::from(cell) - exact).abs() / (EPSILON * magnitude))
    })
}

/// Of a parameter, in epsilons of it: how far it is off, and how much later the parameters of two
/// axes are told for the same point.
fn crossing(p: &[f64; 3]) -> Option<f64> {
    let [plane, o, d] = [signed(p[0]), signed(p[1]) * NEAR, 1.0 + p[2]].map(|x| x as f32);
    let t = f64::from((plane - o) * (1.0 / d));
    let exact = (f64::from(plane) - f64::from(o)) / f64::from(d);
    (exact != 0.0).then_some((t / exact - 1.0) / EPSILON)
}

fn node_exit() -> f64 {
    greatest(|p: &[f64; 4]| {
        let far = 16.0 * 10f64.powf(-4.0 * p[3]);
        let [plane, o, d] =
            [signed(p[0]) * 1.999_9, signed(p[1]) * far, 1.0 + p[2]].map(|x| x as f32);
        let inverse = 1.0 / d;
        let leave = o * inverse;
        let rounding = leave.abs() * (1.0 + 1.0 / 32.0) * f32::EPSILON + inverse * f32::EPSILON;
        // before its last rounding, which keeps order
        let left = f64::from(plane * inverse) + f64::from(-leave);
        let exact = (f64::from(plane) - f64::from(o)) * f64::from(inverse);
        Some((exact - left) / f64::from(rounding))
    })
}

fn sphere() -> f64 {
    greatest(|p: &[f64; 10]| {
        let magnitude = 1.0 + p[0];
        let at =
            |i: usize, size: f64| dvec3(signed(p[i]), signed(p[i + 1]), signed(p[i + 2])) * size;
        let radius = magnitude * 10f64.powf(-3.0 * p[7]);
        let centre = at(1, magnitude - radius).as_vec3();
        let o = at(4, NEAR * magnitude).as_vec3();
        let mut set = MixedSetBuilder::<f32>::default();
        set.sphere(centre.as_dvec3(), radius).ok()?;
        let set: MixedSet<f32> = set.finish();
        let radius = f64::from(radius as f32);
        // past the sphere by a few epsilons of the scene
        let to = (centre - o).as_dvec3();
        let aside = to.normalize().any_orthonormal_vector();
        let turned = aside * (p[8] * 7.0).cos() + to.normalize().cross(aside) * (p[8] * 7.0).sin();
        let target = centre.as_dvec3() + turned * (radius + p[9] * 30.0 * EPSILON * magnitude);
        let ray = Ray::<f32>::new(o, (target - o.as_dvec3()).as_vec3());
        set.intersect(0, &ray, &set.setup(&ray), f32::INFINITY)?;
        let d = ray.direction.as_dvec3();
        let f = o.as_dvec3() - centre.as_dvec3();
        let apart = (f.cross(d).length() / d.length() - radius).max(0.0);
        Some(apart / (EPSILON * magnitude))
    })
}

/// A triangle that is hit in f32.
struct HitTriangle {
    corners: [DVec3; 3],
    o: DVec3,
    d: DVec3,
    t: f64,
    magnitude: f64,
}

/// A triangle, some of them thin, and a ray at a point of its outline or next to it, from `far`
/// magnitudes away at most.
fn hit(p: &[f64; 18], far: f64) -> Option<HitTriangle> {
    let magnitude = 1.0 + p[0];
    let at = |i: usize, size: f64| dvec3(signed(p[i]), signed(p[i + 1]), signed(p[i + 2])) * size;
    let size = magnitude * 10f64.powf(-4.0 * p[1]) * 0.5;
    let middle = at(2, magnitude - 2.0 * size);
    let (a, b) = (at(5, size), at(8, size));
    let thin = if p[11] < 0.5 { 1.0 } else { 10f64.powf(-4.0 * p[12]) };
    let corners =
        [middle + a, middle - a, middle + a * signed(p[13]) + b * thin].map(|v| v.as_vec3());
    let wide = corners.map(|v| v.as_dvec3());
    let point = wide[0] + (wide[1] - wide[0]) * p[13];
    let o = (point + at(14, 1.0).normalize_or(DVec3::X) * far * magnitude * p[17]).as_vec3();
    let aim = (wide[0] + wide[1] + wide[2]) / 3.0 - point;
    let target = point - aim * (p[12] * 1e-6);
    let ray = Ray::<f32>::new(o, (target - o.as_dvec3()).as_vec3());
    let set = TriangleSet::<f32, Watertight>::new(vec![corners.map(|v| v.to_array())], |_| false);
    let set = set.ok()?;
    if o.abs().max_element() > (NEAR * magnitude) as f32 || ray.direction.length() < 1e-6 {
        return None;
    }
    let t = set.intersect(0, &ray, &set.setup(&ray), f32::INFINITY)?;
    let [o, d]: [Vec3<f64>; 2] = [ray.origin.as_dvec3(), ray.direction.as_dvec3()];
    Some(HitTriangle { corners: wide, o, d, t: f64::from(t), magnitude })
}

/// By how much the point at the parameter of a hit lies outside of the triangle's box, in epsilons
/// of the scene's largest coordinate, and how much of that is across the longest axis alone.
fn beyond_box(p: &[f64; 18]) -> Option<f64> {
    let HitTriangle { corners: [a, b, c], o, d, t, magnitude } = hit(p, NEAR)?;
    let (low, high, at) = (a.min(b).min(c), a.max(b).max(c), o + d * t);
    Some((low - at).max(at - high).max_element() / (EPSILON * magnitude))
}

/// The constants of `SHIFT` in `bvh/node.rs`: of the scene, whose largest coordinate is below 2, and
/// of the origin's.
static SHIFT: LazyLock<[f64; 2]> = LazyLock::new(|| ["SHIFT_SCENE", "SHIFT_ORIGIN"].map(constant));

/// How much later a ray enters the tight box of a triangle than the parameter of the hit, in parts
/// of the shift.
fn entered_late(p: &[f64; 18]) -> Option<f64> {
    let HitTriangle { corners: [a, b, c], o, d, t, magnitude } = hit(p, NEAR)?;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let unit = 2f64.powi(-(magnitude.log2().floor() as i32));
    let late = |k: usize| {
        let plane = if d[k] > 0.0 { low[k] } else { high[k] } * unit;
        let origin = o[k] * unit;
        let inverse = 1.0 / d[k] as f32;
        let enter = plane as f32 * inverse + -(origin as f32 * inverse);
        let shift = SHIFT[0] + SHIFT[1] * o.abs().max_element() * unit;
        (f64::from(enter) - t * unit) * d[k].abs() / (shift * EPSILON)
    };
    let axes = (0..3).filter(|k| d[*k].abs() > 1e-6 * d.abs().max_element());
    axes.map(late).reduce(f64::max)
}

#[test]
fn no_error_exceeds_its_bound() {
    let (planes, placement, weights) = (voxel_planes(), placement(), weights_off());
    let beyond = greatest_of(400, beyond_box);
    let exit = |p: &[f64; 6]| Some(crossing(p.first_chunk()?)? - crossing(p.last_chunk()?)?);
    let hit_bound = ["CORNERS", "WEIGHTS", "ALONG"].map(constant).iter().sum();
    let proved = |name, seen| (name, constant(name), seen);
    let all = [
        proved("CORNERS", corners_moved(NEAR)),
        proved("WEIGHTS", weights),
        proved("NEAR_DEPTH", depth_off()),
        proved("ALONG", along(NEAR)),
        proved("PLANES", planes),
        proved("PLACEMENT", placement),
        ("hit beyond box", hit_bound, beyond),
        proved("PADDING_ULPS", beyond + planes + placement),
        proved("OUTWARDS", greatest(|p: &[f64; 3]| crossing(p).map(f64::abs))),
        proved("EXIT", greatest(exit)),
        // in parts of the shift, and of the rounding of products
        ("SHIFT", 1.0, greatest_of(400, entered_late)),
        ("its parts", SHIFT[0] / 2.0 + SHIFT[1], weights + corners_moved(1.0) + along(1.0)),
        ("PRODUCT_ROUNDING", 1.0, node_exit()),
        proved("SPHERE", sphere()),
    ];
    for (name, bound, seen) in all {
        let part = seen / bound;
        println!("{name:17} bound {bound:5.1}, greatest error seen {seen:5.2}, {part:.2} of it");
    }
    for (name, bound, seen) in all {
        // the factor is for tight boxes, and does not suffice for all of them
        let most = if name == "EXIT" { 1.5 * bound } else { bound };
        assert!(seen <= most, "{name}: {seen} of {bound}");
        assert!(seen >= bound / 16.0, "{name}: {seen} of {bound}: the search has no power");
    }
}
