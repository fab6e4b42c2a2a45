//! Rays from far away whose intervals begin or end at the parameter that was told of a hit.

use accel_core::Ray;
use accel_core::registry::Buildable;
use accel_core::structures::REGISTRY;
use accel_core::{Vec3, Vector};

use crate::agreement::{Answers, mismatches};
use crate::common::{Random, all_scenes};

fn hits_are_found_again<S: Buildable>() {
    let mut random = Random::new(31);
    let mut told = 0;
    for (name, set, (lo, hi)) in all_scenes::<S>() {
        if !["soup", "mixed", "far away", "duplicates"].contains(&name) {
            continue;
        }
        let size = (hi - lo).max_element() + hi.abs().max_element();
        let rays: Vec<Ray<S>> = (0..400)
            .map(|i| {
                let target = lo + (hi - lo) * random.point();
                let away = random.signed() * size * [10.0, 1e3, 1e5, 1e7][i % 4];
                let origin = Vec3::<S>::from_dvec3(target + away);
                let towards = Vec3::<S>::from_dvec3(target) - origin;
                let length = S::from_f64(random.one_of(&[1.0, 1e-3, 1e-30]));
                let sign = if i % 3 == 0 { -S::ONE } else { S::ONE };
                let mut ray = Ray::<S>::new(origin, towards * (sign * length));
                // the scene may lie behind the origin
                ray.t_min = -S::INFINITY;
                ray
            })
            .collect();
        let hits = Answers::expected(set.prims(), &rays).hits;
        let (mut asked, mut expected) = (rays.clone(), hits.clone());
        for (ray, hit) in rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
            let (t, none, all) = (hit.t, -S::INFINITY, S::INFINITY);
            for (t_min, t_max) in [(t, t), (none, t), (t, all)] {
                asked.push(Ray { t_min, t_max, ..*ray });
                expected.push(*hit);
            }
            told += 1;
        }
        let again = Answers::expected(set.prims(), &asked).hits;
        for ((ray, hit), expected) in asked.iter().zip(&again).zip(&expected) {
            assert_eq!(hit, expected, "{} {name} {ray:?}", S::NAME);
        }
        let wrong = mismatches(REGISTRY, name, set.prims(), &asked);
        assert!(wrong.is_empty(), "{} {name} {wrong:#?}", S::NAME);
    }
    assert!(told > 200, "{} {told}", S::NAME);
}

#[test]
fn hits_are_found_again_in_f32() {
    hits_are_found_again::<f32>();
}

#[test]
fn hits_are_found_again_in_f64() {
    hits_are_found_again::<f64>();
}
