//! Segments of time change no answer, whatever the time of a ray; and before and after the exposure
//! what moves stands still.

use accel_core::params::config::Settings;
use accel_core::primitives::{Cone, MixedSet, MixedSetBuilder, Primitives, PrimsRef};
use accel_core::query::sink::Sink;
use accel_core::registry::Buildable;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats};
use accel_core::structures::REGISTRY;
use accel_core::{Aabb, Hit, Ray, Scalar};
use glam::{DVec3, dvec3};

use crate::agreement::{Answers, mismatches_under};
use crate::common::{Random, build, planted_entry, rays_for};

/// Settings that are tested, as many segments each.
const SEGMENTS: [usize; 4] = [1, 2, 3, 8];

/// Primitives of all kinds within the unit cube at the end of the exposure, most of which come from
/// as far away as `from`; or triangles alone, which structures keep in blocks.
fn scene<S: Scalar>(kinds: u32, from: DVec3, exposure: f64, seed: u64) -> MixedSet<S> {
    let mut r = Random::new(seed);
    let mut set = MixedSetBuilder::<S>::default();
    for i in 0..160 {
        let velocity = from * r.signed() / exposure;
        let is_moving = i % 4 != 0;
        let p = r.point() - if is_moving { velocity * exposure } else { DVec3::ZERO };
        match i % kinds {
            1 => set.sphere(p, 0.02 + 0.08 * r.unit()),
            2 => set.cone(Cone::new(p, 0.05, p + r.signed() * 0.2, 0.03)),
            3 => {
                let corner = |x: f64, y: f64| p + dvec3(x, y, 0.0) * 0.2;
                set.polygon(&[corner(0., 0.), corner(1., 0.), corner(1., 1.), corner(0., 1.)])
            }
            _ => set.triangle([p, p + r.signed() * 0.2, p + r.signed() * 0.2]),
        }
        .unwrap();
        if is_moving {
            set.last_moves(velocity, exposure).unwrap();
        }
    }
    set.finish()
}

/// Rays at the unit cube when the shutter opens, when it closes, where segments meet, next to that,
/// between, and outside of the exposure.
fn rays<S: Buildable>(exposure: f64, seed: u64) -> Vec<Ray<S>> {
    let mut r = Random::new(seed);
    let all = rays_for::<S>((DVec3::ZERO, DVec3::ONE), &mut r);
    let mut rays: Vec<_> = all.into_iter().step_by(11).collect();
    for (i, ray) in rays.iter_mut().enumerate() {
        let boundary = r.one_of(&[0., 1. / 8., 1. / 3., 3. / 8., 1. / 2., 2. / 3., 7. / 8., 1.]);
        let next = 1.0 + S::EPSILON.to_f64() * r.one_of(&[-2.0, -0.5, 0.0, 1.0, 3.0]);
        let time = match i % 4 {
            0 => r.unit(),
            1 => boundary,
            2 => boundary * next,
            _ => r.one_of(&[1.0, 0.0, -0.0, 1.0, 1.5, -1.0, f64::INFINITY, f64::NAN]),
        };
        ray.time = S::from_f64(exposure * time);
    }
    rays
}

fn agree<S: Buildable>() {
    let mut hits = 0;
    let far = dvec3(700.0, 20.0, 3.0);
    for (name, kinds, from, exposure) in [
        ("near", 5, DVec3::splat(0.5), 1.0),
        ("triangles", 1, DVec3::splat(0.5), 1.0),
        ("far", 5, far, 0.3),
        ("far triangles", 1, far, 0.3),
    ] {
        let set = scene::<S>(kinds, from, exposure, 31);
        let rays = rays::<S>(exposure, 32);
        let expected = Answers::expected(PrimsRef::Mixed(&set), &rays);
        hits += expected.hits.iter().filter(|hit| hit.is_hit()).count();
        for segments in SEGMENTS.map(|n| n.to_string()) {
            let also = [("time-segments", segments.as_str())];
            let wrong = mismatches_under(REGISTRY, &also, name, PrimsRef::Mixed(&set), &rays);
            let shown: Vec<_> = wrong.iter().take(5).collect();
            assert!(wrong.is_empty(), "{} mismatches, first ones:\n{shown:#?}", wrong.len());
        }
    }
    assert!(hits > 800, "the rays hit next to nothing: {hits}");
}

#[test]
fn all_structures_agree_with_brute_force_in_f32() {
    agree::<f32>();
}

#[test]
fn all_structures_agree_with_brute_force_in_f64() {
    agree::<f64>();
}

/// The planted fault: boxes that end before the way does.
struct CutShort<S: Scalar>(Vec<Aabb<S>>);

static CUT_SHORT: StructureInfo = StructureInfo::new("cut-short", "misses the end of the way");

impl<S: Scalar> Structure<S> for CutShort<S> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        let cut = |id| {
            let Aabb { min, max } = prims.bounds(id);
            Aabb { min, max: max - (max - min) * S::from_f64(0.2) }
        };
        Ok(Self((0..prims.len() as u32).map(cut).collect()))
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        for (id, bounds) in (0..).zip(&self.0) {
            let enters = bounds.clip(ray.origin, ray.direction, ray.t_min, sink.t_max());
            if enters.is_some() && sink.test(&[id]).is_break() {
                return;
            }
        }
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

#[test]
fn bounds_that_miss_the_end_of_a_motion_are_caught() {
    let mut set = MixedSetBuilder::<f32>::default();
    for i in 0..40 {
        set.sphere(dvec3(f64::from(i % 7), f64::from(i / 7), 0.0), 0.2).unwrap();
        set.last_moves(dvec3(0.0, 0.0, 3.0), 1.0).unwrap();
    }
    let set = set.finish();
    let mut rays = rays_for::<f32>((DVec3::ZERO, dvec3(7., 6., 4.)), &mut Random::new(3));
    rays.iter_mut().for_each(|ray| ray.time = 1.0);
    for segments in ["1", "2", "3", "8"] {
        let also = [("time-segments", segments)];
        let planted = [planted_entry!(CutShort, CUT_SHORT)];
        let wrong = mismatches_under(&planted, &also, "planted", PrimsRef::Mixed(&set), &rays);
        assert!(wrong.len() > 10, "{segments}: {wrong:?}");
    }
}

#[test]
fn memory_is_the_sum_of_segments_and_a_scene_at_rest_has_one() {
    let built = |set: &MixedSet<f32>, segments: &str| {
        let segments = format!("time-segments={segments}");
        let tracer = build(PrimsRef::Mixed(set), "kd-tree", &segments).unwrap();
        let mut cells = 0;
        tracer.cells(&mut |_| cells += 1).unwrap();
        let stats = tracer.stats();
        assert_eq!(cells, stats.cells + stats.inner_cells);
        stats
    };
    let moving = scene::<f32>(5, DVec3::splat(0.5), 1.0, 4);
    assert!(built(&moving, "4").bytes > built(&moving, "1").bytes * 2);
    let mut still = MixedSetBuilder::<f32>::default();
    still.sphere(DVec3::ZERO, 1.0).unwrap();
    let still = still.finish();
    assert_eq!(built(&still, "4"), built(&still, "1"));
}

#[test]
fn before_and_after_the_exposure_all_stands_still() {
    let mut set = MixedSetBuilder::<f64>::default();
    set.sphere(DVec3::ZERO, 1.0).unwrap();
    set.last_moves(DVec3::X * 8.0, 0.5).unwrap();
    let set = set.finish();
    let tracer = build(PrimsRef::Mixed(&set), "wide-bvh", "time-segments=8").unwrap();
    for (time, x) in [(-3.0, 0.0), (f64::NAN, 0.0), (0.25, 2.0), (0.5, 4.0), (7.0, 4.0)] {
        let ray = Ray::<f64> { time, ..Ray::new(dvec3(x, 0.0, 5.0), DVec3::NEG_Z) };
        let mut hit = [Hit::NONE];
        tracer.closest_hits(&[ray], &mut hit);
        assert_eq!((hit[0].id, hit[0].t), (0, 4.0), "{time}");
    }
}
