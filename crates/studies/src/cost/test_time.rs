//! Cost of an intersection test in a scene: a polygon with 144 corners is not a sphere.
//!
//! Tests are made as the leaves of a structure make them: of primitives drawn by the area of their
//! boxes (the chance that a ray meets them: J. Goldsmith, J. Salmon, "Automatic Creation of Object
//! Hierarchies for Ray Tracing", IEEE CG&A 7(5), 1987), with rays through those boxes.

use accel_core::primitives::PrimSet;
use accel_core::primitives::PrimsRef;
use accel_core::{Ray, Vector};
use glam::DVec3;

use measurement::system::clock::Clock;
use statistics::estimate::median;
use statistics::random::Random;

/// Tests of a pass, and passes, of which the median counts.
const TESTS: usize = 4096;
const PASSES: usize = 7;

/// Seconds a test, on average.
pub fn seconds_per_test(prims: PrimsRef<'_, f32>, clock: &dyn Clock) -> f64 {
    match prims {
        PrimsRef::Watertight(p) => of(p, clock),
        PrimsRef::Mixed(p) if p.has_motion() => of(p.in_motion(), clock),
        PrimsRef::Mixed(p) => of(p, clock),
    }
}

fn of<P: PrimSet<f32>>(prims: &P, clock: &dyn Clock) -> f64 {
    let pairs: Vec<(u32, Ray<f32>)> = drawn(prims);
    let asked: Vec<_> = pairs.iter().map(|(id, ray)| (*id, ray, prims.setup(ray))).collect();
    let pass = || {
        let start = clock.now();
        let hits = asked
            .iter()
            .filter(|(id, ray, setup)| prims.intersect(*id, ray, setup, f32::INFINITY).is_some())
            .count();
        std::hint::black_box(hits);
        clock.seconds_since(start)
    };
    // the first pass finds no caches
    pass();
    let seconds: Vec<f64> = (0..PASSES).map(|_| pass()).collect();
    median(&seconds).unwrap_or(f64::NAN) / asked.len().max(1) as f64
}

/// Primitives and rays through their boxes.
fn drawn<P: PrimSet<f32>>(prims: &P) -> Vec<(u32, Ray<f32>)> {
    let mut sums = Vec::with_capacity(prims.len());
    let mut total = 0.0;
    for id in 0..prims.len() as u32 {
        // flat boxes on an axis still have an area; a point has next to none
        total += prims.bounds(id).half_area().max(f64::MIN_POSITIVE);
        sums.push(total);
    }
    let reach = prims.scene_bounds().size().to_dvec3().length();
    let mut random = Random::new(1, "test time");
    let mut unit = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut pairs = Vec::with_capacity(TESTS);
    for i in 0..TESTS {
        let at = (i as f64 + unit()) / TESTS as f64 * total;
        let id = sums.partition_point(|sum| *sum <= at).min(prims.len().saturating_sub(1)) as u32;
        if prims.is_empty() {
            break;
        }
        let bounds = prims.bounds(id);
        let size = bounds.size().to_dvec3();
        let target = bounds.min.to_dvec3() + size * DVec3::new(unit(), unit(), unit());
        let direction = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5);
        let direction = direction.normalize_or(DVec3::X);
        pairs.push((id, Ray::from_dvec3(target - direction * reach, direction)));
    }
    pairs
}

#[cfg(test)]
mod tests {
    use accel_core::primitives::MixedSetBuilder;
    use glam::dvec3;

    use super::*;

    #[test]
    fn large_primitives_are_drawn_more_often_and_rays_meet_their_boxes() {
        let mut set = MixedSetBuilder::<f32>::default();
        set.sphere(DVec3::ZERO, 1.0).unwrap();
        // a hundred times the area
        set.sphere(dvec3(30.0, 0.0, 0.0), 10.0).unwrap();
        let set = set.finish();
        let pairs = drawn(&set);
        assert_eq!(pairs.len(), TESTS);
        let small = pairs.iter().filter(|(id, _)| *id == 0).count();
        assert!((20..70).contains(&small), "{small}");
        let hits = |(id, ray): &&(u32, Ray<f32>)| {
            set.intersect(*id, ray, &set.setup(ray), f32::INFINITY).is_some()
        };
        let met = pairs.iter().filter(hits).count();
        assert!(met > TESTS / 2 && met < TESTS, "{met}");
        let clock =
            measurement::system::clock::SteppingClock::new(std::time::Duration::from_millis(1));
        assert!((of(&set, &clock) * TESTS as f64 - 1e-3).abs() < 1e-12);
    }
}
