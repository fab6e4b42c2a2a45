//! The rows of obvhs by their plain names: the answers are those of obvhs used without us, to the
//! last bit.

use std::time::Duration;

use accel_core::primitives::{MixedSetBuilder, PrimsRef, TriangleSet, Watertight};
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::{Batches, BuildError};
use accel_core::{Hit, Ray};
use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams as Preset;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::triangle::Triangle;

use crate::agreement::closest_hits;
use crate::common::{Random, build, triangle_set};
use crate::test_scenes::occlusions;

const ROWS: [&str; 2] = ["obvhs-bvh2", "obvhs-cwbvh"];

type Answers = (Vec<(f32, u32)>, Vec<bool>);

/// Triangles at places without order, every tenth large; those whose ids are multiples of 3 let
/// shadow rays pass.
fn soup<S: Buildable>(n: usize) -> TriangleSet<S, Watertight> {
    let mut random = Random::new(7);
    let triangle = |i: usize| {
        let (at, size) = (random.signed() * 3.0, if i.is_multiple_of(10) { 1.5 } else { 0.2 });
        [at, at + random.signed() * size, at + random.signed() * size]
    };
    triangle_set((0..n).map(triangle), |id| id.is_multiple_of(3))
}

/// Rays through it, some along axes (with components of -0.0), some with intervals of their own.
fn rays<S: Buildable>(n: usize) -> Vec<Ray<S>> {
    let mut random = Random::new(8);
    let ray = |i: usize| {
        let direction = match i % 4 {
            0 => [DVec3::X, -DVec3::Y, -DVec3::Z][i / 4 % 3],
            _ => random.signed() * [1.0, 0.01, 30.0][i % 3],
        };
        let mut ray = Ray::<S>::from_dvec3(random.signed() * 4.0, direction);
        if i.is_multiple_of(5) {
            (ray.t_min, ray.t_max) = (S::from_f64(0.1), S::from_f64(2.0));
        }
        ray
    };
    (0..n).map(ray).collect()
}

fn asked<S: Buildable>(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> (Vec<Hit<S>>, Vec<bool>) {
    (closest_hits(tracer, rays), occlusions(tracer, rays))
}

fn in_bits(hits: Vec<Hit<f32>>, blocked: Vec<bool>) -> (Vec<(u32, u32)>, Vec<bool>) {
    (hits.into_iter().map(|hit| (hit.t.to_bits(), hit.id)).collect(), blocked)
}

/// Answers of obvhs called directly, through an index, as its basic examples do.
fn without_us(
    set: &TriangleSet<f32, Watertight>,
    is_wide: bool,
    preset: Preset,
    rays: &[Ray<f32>],
) -> Answers {
    let corners = set.triangles().iter().map(|t| t.map(Vec3A::from_array));
    let triangles: Vec<_> = corners.map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
    let laid_out: Vec<_> = triangles.iter().map(obvhs::rt_triangle::RtTriangle::from).collect();
    let time = &mut Duration::default();
    let (mut hits, mut blocked) = (Vec::new(), Vec::new());
    macro_rules! ask {
        ($tree:expr) => {{
            let (tree, ids) = (&$tree, &$tree.primitive_indices);
            for ray in rays {
                let own = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
                let own = ObvhsRay::new(own.0, own.1, ray.t_min, ray.t_max);
                let mut hit = RayHit::none();
                let test = |ray: &ObvhsRay, i: usize| laid_out[ids[i] as usize].intersect(ray);
                hits.push(if tree.ray_traverse(own, &mut hit, test) {
                    (hit.t, ids[hit.primitive_id as usize])
                } else {
                    (ray.t_max, u32::MAX)
                });
                let opaque = |ray: &ObvhsRay, i: usize| {
                    if ids[i].is_multiple_of(3) { f32::INFINITY } else { test(ray, i) }
                };
                blocked.push(!tree.ray_traverse_miss(own, opaque));
            }
        }};
    }
    if is_wide {
        ask!(build_cwbvh_from_tris(&triangles, preset, time));
    } else {
        ask!(build_bvh2_from_tris(&triangles, preset, time));
    }
    (hits, blocked)
}

#[test]
fn answers_equal_those_of_plain_obvhs() {
    let presets = [
        ("fastest", Preset::fastest_build()),
        ("very-fast", Preset::very_fast_build()),
        ("fast", Preset::fast_build()),
        ("medium", Preset::medium_build()),
        ("slow", Preset::slow_build()),
        ("very-slow", Preset::very_slow_build()),
    ];
    let (set, rays) = (soup::<f32>(3000), rays::<f32>(3000));
    for name in ROWS {
        for (preset, theirs) in presets {
            let settings = format!("preset={preset}");
            let tracer = build(PrimsRef::Watertight(&set), name, &settings).unwrap();
            assert_eq!(tracer.batches(), Batches::Library);
            let (hits, blocked) = asked(&*tracer, &rays);
            let number = hits.iter().filter(|hit| hit.is_hit()).count();
            assert!(number > 300 && blocked.contains(&true) && blocked.contains(&false));
            let expected = without_us(&set, name == "obvhs-cwbvh", theirs, &rays);
            let expected = expected.0.into_iter().map(|(t, id)| (t.to_bits(), id)).collect();
            let theirs = without_us(&set, name == "obvhs-cwbvh", theirs, &rays).1;
            assert!(in_bits(hits, blocked) == (expected, theirs), "{name} {preset}");
        }
    }
}

#[test]
fn answers_of_another_test_or_occlusion_differ() {
    // planted faults: our own test in the same traversal, and triangles that let no ray pass
    let (set, rays) = (soup::<f32>(3000), rays::<f32>(3000));
    let expected = without_us(&set, true, Preset::medium_build(), &rays);
    let robust = build(PrimsRef::Watertight(&set), "obvhs-cwbvh", "adapter=robust").unwrap();
    let (hits, _) = asked(&*robust, &rays);
    assert_eq!(robust.batches(), Batches::RayByRay);
    let differ = |(a, b): (&Hit<f32>, &(f32, u32))| a.t.to_bits() != b.0.to_bits();
    assert!(hits.iter().zip(&expected.0).filter(|pair| differ(*pair)).count() > 100);
    let opaque = TriangleSet::new(set.triangles().to_vec(), |_| false).unwrap();
    let opaque = build(PrimsRef::Watertight(&opaque), "obvhs-cwbvh", "").unwrap();
    let (_, blocked) = asked(&*opaque, &rays);
    assert!(blocked.iter().zip(&expected.1).filter(|(a, b)| a != b).count() > 100);
}

#[test]
fn mixed_and_double_sets_use_our_primitive_tests() {
    let double = soup::<f64>(1000);
    let mut builder = MixedSetBuilder::<f32>::default();
    let mut random = Random::new(9);
    for _ in 0..500 {
        builder.sphere(random.signed() * 3.0, 0.2 * random.unit()).unwrap();
    }
    let mixed = builder.finish();
    fn check<S: Buildable>(prims: PrimsRef<'_, S>) {
        let rays = rays::<S>(2000);
        let expected = asked(&*build(prims, "brute-force", "").unwrap(), &rays);
        for name in ROWS {
            let direct = build(prims, name, "").unwrap();
            assert_eq!(direct.batches(), Batches::RayByRay);
            let found = asked(&*direct, &rays);
            let equal = found.0.iter().zip(&expected.0).filter(|(a, b)| a == b && a.is_hit());
            // its boxes lose some, but what is hit is hit as our own test has it
            assert!(equal.count() > 100, "{name} {}", S::NAME);
        }
    }
    check(PrimsRef::Watertight(&double));
    check(PrimsRef::Mixed(&mixed));
}

#[test]
fn trees_that_obvhs_cannot_traverse_are_refused() {
    let nested = |i: usize| {
        let size = 1.0 + i as f32 / 6000.0;
        [[0.0; 3], [size, 0.0, 0.0], [0.0, size, size]]
    };
    for n in [1500, 6000] {
        let set = TriangleSet::<f32, Watertight>::new((0..n).map(nested).collect(), |_| false);
        let set = set.unwrap();
        let wide = build(PrimsRef::Watertight(&set), "obvhs-cwbvh", "preset=fastest");
        assert!(matches!(wide.err(), Some(BuildError::TooLarge { .. })), "{n}");
        for preset in ["fastest", "medium"] {
            let settings = format!("preset={preset}");
            let deep = build(PrimsRef::Watertight(&set), "obvhs-bvh2", &settings).unwrap();
            let ray = Ray::new([0.3, 0.2, 5.0].into(), [0.0, 0.0, -1.0].into());
            assert!(asked(&*deep, &[ray]).0[0].is_hit(), "{n} {preset}");
        }
    }
}

#[test]
fn invalid_rays_hit_nothing() {
    let set = soup::<f32>(1000);
    let ray = |origin: [f32; 3], direction: [f32; 3], t_max: f32| Ray {
        t_max,
        ..Ray::new(origin.into(), direction.into())
    };
    let none = [
        ray([f32::NAN; 3], [1.0, 0.0, 0.0], f32::INFINITY),
        ray([f32::INFINITY, 0.0, 0.0], [-1.0, 0.0, 0.0], f32::INFINITY),
        ray([0.0; 3], [f32::NAN, 1.0, 0.0], f32::INFINITY),
        ray([-4.0, 0.0, 0.0], [1.0, 0.0, 0.0], -1.0),
    ];
    for name in ROWS {
        let tracer = build(PrimsRef::Watertight(&set), name, "").unwrap();
        let (hits, blocked) = asked(&*tracer, &none);
        assert!(hits.iter().all(|hit| !hit.is_hit()) && blocked == [false; 4], "{name}");
    }
}
