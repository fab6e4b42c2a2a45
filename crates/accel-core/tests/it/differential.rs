//! Every structure of the registry, in every variant, against brute force: same primitive, same
//! parameter bits, same occlusion, on random and on awkward scenes and rays, in f32 and f64.

use crate::agreement::{Answers, mismatches};
use crate::common::{Random, all_scenes, rays_for};
use accel_core::primitives::PrimsRef;
use accel_core::registry::Buildable;
use accel_core::structures::REGISTRY;
use accel_core::{Hit, Ray};

fn check<S: Buildable>() {
    let mut wrong = Vec::new();
    let mut hit_anything = 0;
    for (name, set, bounds) in all_scenes::<S>() {
        let rays = rays_for::<S>(bounds, &mut Random::new(7));
        let hits = Answers::expected(set.prims(), &rays).hits;
        hit_anything += hits.iter().filter(|h| h.is_hit()).count();
        wrong.extend(mismatches(REGISTRY, name, set.prims(), &rays));
    }
    assert!(hit_anything > 1000, "the rays hit next to nothing: {hit_anything}");
    let shown: Vec<_> = wrong.iter().take(10).collect();
    assert!(wrong.is_empty(), "{} mismatches, first ones:\n{shown:#?}", wrong.len());
}

#[test]
fn all_structures_agree_with_brute_force_in_f32() {
    check::<f32>();
}

#[test]
fn all_structures_agree_with_brute_force_in_f64() {
    check::<f64>();
}

#[test]
fn meaningless_rays_miss() {
    let [x, nan, inf] = [1.0f32, f32::NAN, f32::INFINITY];
    let ray = |o: [f32; 3], d: [f32; 3], t_min, t_max| Ray::<f32> {
        origin: o.into(),
        direction: d.into(),
        t_min,
        t_max,
        time: 0.0,
    };
    let rays = [
        ray([0.0; 3], [0.0; 3], 0.0, inf),
        ray([0.0; 3], [-0.0; 3], 0.0, inf),
        ray([nan, 0.0, 0.0], [x, x, x], 0.0, inf),
        ray([0.0; 3], [nan, 0.0, x], 0.0, inf),
        ray([inf, 0.0, 0.0], [x, 0.0, 0.0], 0.0, inf),
        ray([0.0; 3], [inf, 0.0, 0.0], 0.0, inf),
        ray([0.0; 3], [x, x, x], nan, inf),
        ray([0.0; 3], [x, x, x], 0.0, nan),
        ray([0.0; 3], [x, x, x], 2.0, 1.0),
    ];
    for (name, set, _) in all_scenes::<f32>() {
        for entry in REGISTRY {
            let tracer = entry.build(set.prims(), &entry.params([]).unwrap()).unwrap();
            let mut hits = vec![Hit { t: 5.0, id: 5 }; rays.len()];
            tracer.closest_hits(&rays, &mut hits);
            assert!(hits.iter().all(|h| !h.is_hit()), "{name} {}: {hits:?}", entry.info.name);
            let mut blocked = vec![true; rays.len()];
            tracer.occlusions(&rays, &mut blocked);
            assert!(blocked.iter().all(|b| !b), "{name} {}", entry.info.name);
        }
    }
}

#[test]
fn an_empty_set_is_a_typed_error() {
    let set = accel_core::primitives::MixedSetBuilder::<f32>::default().finish();
    for entry in REGISTRY {
        let result = entry.build(PrimsRef::Mixed(&set), &entry.params([]).unwrap());
        assert!(matches!(
            result.err(),
            Some(accel_core::structure::BuildError::NoPrimitives { .. })
        ));
    }
}
