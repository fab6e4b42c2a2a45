//! HUG and the adaptive grid give the oracle's answers, bit for bit, and survive hard scenes.

use crate::agreement::agreed;
use crate::common::{Random, build, squares, triangle_set};
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{
    Cone, MixedSet, MixedSetBuilder, Primitives, TriangleSet, Watertight,
};
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::{Hit, Ray, Scalar};
use glam::{DVec3, dvec3};

/// Every structure and setting under test.
const SETTINGS: &[(&str, &str)] = &[
    ("hug", ""),
    ("hug", "size-classes=1"),
    ("hug", "size-classes=2 gap=0.1 density=8"),
    ("hug", "size-classes=16 min-objects=1"),
    ("hug", "size-classes=6 gap=-0.05 min-objects=2"),
    ("adaptive-grid", ""),
    ("adaptive-grid", "m=0.01 split=2 levels=8"),
    ("adaptive-grid", "m=0.1 orphan-grid=on levels=0"),
    ("adaptive-grid", "f=1 exact-clusters=16 density=6 split=3"),
    ("adaptive-grid", "f=0 m=0"),
];

/// In [-1, 1) on each axis, mostly small numbers of 1/4 so that ties occur.
fn direction(random: &mut Random) -> DVec3 {
    let d = random.signed();
    match (random.unit() * 6.0) as u32 {
        0 => (d * 1.99).trunc(),
        1 => (d * 4.0).round() / 4.0,
        2 => dvec3(d.x, 0.0, d.z),
        3 => dvec3(-0.0, -1.0, 0.0) * d.y.signum(),
        _ => d,
    }
}

fn rays<S: Scalar>(lo: DVec3, hi: DVec3, count: usize, seed: u64) -> Vec<Ray<S>> {
    let mut random = Random::new(seed);
    let size = hi - lo;
    (0..count)
        .map(|i| {
            let direction = direction(&mut random);
            let target = lo + size * random.point();
            let origin = match i % 3 {
                0 => target,
                1 => target - direction * size.length(),
                _ => ((lo + size * random.point()) * 4.0).round() / 4.0,
            };
            let mut ray = Ray::<S>::from_dvec3(origin, direction);
            if i % 5 == 0 {
                ray.t_min = S::from_f64(0.1);
                ray.t_max = S::from_f64(random.unit() * size.length());
            }
            ray
        })
        .collect()
}

fn agree<S: Buildable>(scene: &str, prims: PrimsRef<S>, rays: &[Ray<S>]) {
    agreed(scene, prims, rays, 2 * rays.len(), SETTINGS);
}

/// Spheres, triangles, quads and cones of very different sizes, some twice, some glass.
fn mixed<S: Scalar>(count: usize, seed: u64) -> MixedSet<S> {
    let mut random = Random::new(seed);
    let mut set = MixedSetBuilder::<S>::default();
    for i in 0..count {
        let p = random.point() * 8.0;
        let side = 0.02 * 100f64.powf(random.unit());
        match i % 4 {
            0 => set.sphere(p, side).unwrap(),
            1 => {
                let v = [p, p + direction(&mut random) * side, p + direction(&mut random) * side];
                set.triangle(v).unwrap();
                set.triangle(v).unwrap();
            }
            2 => {
                let (a, b) = (dvec3(side, 0.0, 0.0), dvec3(0.0, side, 0.0));
                let p = (p * 4.0).round() / 4.0;
                set.polygon(&[p, p + a, p + a + b, p + b]).unwrap();
            }
            _ => {
                let top = p + random.signed() * side;
                set.cone(Cone::new(p, 0.2 * side, top, 0.1 * side)).unwrap();
            }
        }
        if i % 7 == 0 {
            set.last_is_transmissive();
        }
    }
    set.finish()
}

#[test]
fn mixed_scenes_agree_with_brute_force() {
    for (count, seed) in [(1, 1), (7, 2), (300, 3), (1500, 4)] {
        let (lo, hi) = (DVec3::ZERO, DVec3::splat(8.0));
        let set = mixed::<f64>(count, seed);
        let b = set.scene_bounds();
        agree("mixed f64", PrimsRef::Mixed(&set), &rays(b.min, b.max, 3000, seed));
        let set = mixed::<f32>(count, seed);
        agree("mixed f32", PrimsRef::Mixed(&set), &rays(lo, hi, 3000, seed + 100));
    }
}

fn triangles<S: Scalar>(all: &[[DVec3; 3]]) -> TriangleSet<S, Watertight> {
    triangle_set(all.iter().copied(), |_| false)
}

/// A heightfield of 2 n n triangles over the unit square times `size`.
fn field(n: usize, size: f64, height: impl Fn(f64, f64) -> f64) -> Vec<[DVec3; 3]> {
    let at = |i: usize, j: usize| {
        let (x, z) = (i as f64 / n as f64 * size, j as f64 / n as f64 * size);
        dvec3(x, height(x, z), z)
    };
    squares(n, n, at)
}

#[test]
fn flat_scenes_agree_with_brute_force() {
    let flat = triangles::<f32>(&field(22, 10.0, |_, _| 0.0));
    let (lo, hi) = (dvec3(0.0, -1.0, 0.0), dvec3(10.0, 1.0, 10.0));
    agree("flat", PrimsRef::Watertight(&flat), &rays(lo, hi, 2000, 5));
    let point = triangles::<f32>(&[[dvec3(1.0, 1.0, 1.0); 3], [DVec3::X, DVec3::Y, DVec3::Z]]);
    agree("points", PrimsRef::Watertight(&point), &rays(DVec3::ZERO, DVec3::ONE, 500, 6));
}

#[test]
fn a_teapot_in_a_stadium_agrees_with_brute_force() {
    let mut all = vec![
        [dvec3(-5e3, 0.0, -5e3), dvec3(5e3, 0.0, -5e3), dvec3(5e3, 0.0, 5e3)],
        [dvec3(-5e3, 0.0, -5e3), dvec3(5e3, 0.0, 5e3), dvec3(-5e3, 0.0, 5e3)],
    ];
    all.extend(field(40, 0.5, |x, z| 0.2 + 0.1 * (20.0 * x).sin() * (17.0 * z).cos()));
    let set = triangles::<f64>(&all);
    let rays: Vec<_> = rays(DVec3::ZERO, dvec3(0.5, 0.4, 0.5), 2000, 7);
    agree("stadium", PrimsRef::Watertight(&set), &rays);
    // few rays may test more than a few of the teapot's 3,200 triangles
    for name in ["hug", "adaptive-grid"] {
        let tracer = build(PrimsRef::Watertight(&set), name, "").unwrap();
        let work = tracer.count_closest_hits(&rays, &mut vec![Hit::NONE; rays.len()]);
        let tests = work.intersection_tests as f64 / rays.len() as f64;
        assert!(tests < 60.0, "{name}: {tests} tests per ray");
    }
}

#[test]
fn ten_thousand_copies_of_a_triangle_stay_within_memory() {
    let set = triangles::<f32>(&vec![[DVec3::X, DVec3::Y, DVec3::Z]; 10_000]);
    let rays = rays(DVec3::ZERO, DVec3::ONE, 20, 8);
    agree("copies", PrimsRef::Watertight(&set), &rays);
    for &(name, settings) in SETTINGS {
        let bytes = build(PrimsRef::Watertight(&set), name, settings).unwrap().stats().bytes;
        assert!(bytes < 16 << 20, "{name} {settings}: {bytes} bytes");
    }
}

#[test]
fn limits_are_typed_errors() {
    let set = mixed::<f64>(1000, 9);
    for name in ["hug", "adaptive-grid"] {
        for limit in ["max-cells", "max-references"] {
            let settings = format!("{limit}=20 boxes=historical");
            let error = build(PrimsRef::Mixed(&set), name, &settings).err();
            assert!(matches!(error, Some(BuildError::TooLarge { .. })), "{name} {limit}");
        }
    }
}
