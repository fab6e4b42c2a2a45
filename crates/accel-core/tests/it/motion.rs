//! Primitives that move: a moment of a motion is the set at rest there.

use accel_core::primitives::{Cone, MixedSet, MixedSetBuilder, PrimSet, Primitives};
use accel_core::{Ray, Scalar};
use glam::{DVec3, dvec3};

const VELOCITY: DVec3 = dvec3(0.5, -2.0, 8.0);

/// One primitive of each kind, moved by `way` at once or by `velocity` in time.
fn set<S: Scalar>(way: DVec3, velocity: DVec3, exposure: f64) -> MixedSet<S> {
    let mut set = MixedSetBuilder::<S>::default();
    let [a, b, c] = [dvec3(0.0, 0.0, 0.0), dvec3(1.0, 0.0, 0.0), dvec3(0.0, 1.0, 0.0)];
    let p = |p: DVec3| p + way;
    set.triangle([a, b, c].map(p)).unwrap();
    set.last_moves(velocity, exposure).unwrap();
    set.polygon(&[a, b, b + c, c].map(p)).unwrap();
    set.last_moves(velocity, exposure).unwrap();
    set.sphere(p(a), 0.75).unwrap();
    set.last_moves(velocity, exposure).unwrap();
    set.cone(Cone::new(p(a), 0.5, p(b), 0.25)).unwrap();
    // the last call counts
    set.last_moves(DVec3::ONE, 1.0).unwrap();
    set.last_moves(velocity, exposure).unwrap();
    set.finish()
}

fn a_moment_is_the_set_at_rest_there<S: Scalar>() {
    let moving = set::<S>(DVec3::ZERO, VELOCITY, 1.0);
    let mut hits = 0;
    for quarter in 0..=4 {
        let time = f64::from(quarter) / 4.0;
        let way = VELOCITY * time;
        let still = set::<S>(way, DVec3::ZERO, 0.0);
        for id in 0..4 {
            let (bounds, part) = (moving.bounds(id), still.bounds(id));
            let rounding = S::from_f64(S::EPSILON.to_f64() * 32.0);
            let bounds = bounds.expanded(rounding);
            assert_eq!(bounds, bounds.union(part), "{} {id} {time}", S::NAME);
            for n in [DVec3::X, dvec3(1.0, -2.0, 0.5), -DVec3::Z] {
                let (all, part) = (moving.extent(id, n), still.extent(id, n));
                assert!(all.0 <= part.0 + 1e-6 && part.1 - 1e-6 <= all.1, "{id} {n}");
            }
            let from = dvec3(3.0, 1.0, -2.0);
            assert!(moving.farthest(id, from) >= still.farthest(id, from) - 1e-6);
            assert_eq!(moving.kind(id), still.kind(id));
        }
        for k in 0..50 {
            let target = way + dvec3(f64::from(k % 7) * 0.125, f64::from(k / 7) * 0.125, 0.0);
            let from = target + dvec3(0.25, -0.5, 4.0);
            let mut ray = Ray::<S>::from_dvec3(from, target - from);
            ray.time = S::from_f64(time);
            for id in 0..4 {
                // these numbers are exact in both precisions, so the answers are too
                let t = |s: &MixedSet<S>| {
                    let s = s.in_motion();
                    s.intersect(id, &ray, &s.setup(&ray), S::INFINITY)
                };
                let (a, b) = (t(&moving), t(&still));
                assert_eq!(a.is_some(), b.is_some(), "{} {id} {time} {k}", S::NAME);
                if let (Some(a), Some(b)) = (a, b) {
                    hits += 1;
                    let near = S::EPSILON.to_f64() * 32.0;
                    assert!((a.to_f64() - b.to_f64()).abs() <= near, "{id} {time}: {a} {b}");
                }
            }
        }
    }
    assert!(hits > 200, "{hits}");
}

#[test]
fn a_moment_of_a_motion_is_the_set_at_rest_there() {
    a_moment_is_the_set_at_rest_there::<f32>();
    a_moment_is_the_set_at_rest_there::<f64>();
}

#[test]
fn a_motion_that_is_not_finite_is_a_typed_error() {
    for (velocity, exposure) in
        [(dvec3(f64::NAN, 0.0, 0.0), 1.0), (DVec3::X, f64::INFINITY), (DVec3::X * 1e30, 1e30)]
    {
        let mut set = MixedSetBuilder::<f32>::default();
        set.sphere(DVec3::ZERO, 1.0).unwrap();
        assert!(set.last_moves(velocity, exposure).is_err(), "{velocity} {exposure}");
    }
}
