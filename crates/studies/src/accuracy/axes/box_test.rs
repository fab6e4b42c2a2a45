//! The slab test of boxes: as it stands, with exits two ulps later, in f64.
//!
//! The rays that are judged aim at corners, edges and faces of tight boxes around primitives. An
//! error-free comparison of the products that the slab test divides says whether the exact ray
//! meets the exact box; a test that says no is wrong.

use accel_core::geometry::box_test::BoxTest;
use accel_core::primitives::Primitives;
use accel_core::{Aabb, Ray};
use glam::Vec3;
use renderer::RayKind;
use statistics::random::Random;

use crate::accuracy::axis::*;
use crate::verify::draw::{point, unit};

pub static AXIS: Axis = Axis {
    name: "box-test",
    summary: "slab test of tight boxes: plain, exits two ulps later, in f64",
    paper: "Ize 2013",
    metric: "boxes per 10^6 that a ray meets exactly and the test misses",
    reference: "error-free products",
    scenes: &["teapot", "balls:3", "pavilion"],
    setting: "bounding-volumes.box-test",
    measure: Measure::Whole(measure),
};

/// Values of the setting, and the test each is.
const TESTS: [(&str, BoxTest); 3] =
    [("plain", BoxTest::Plain), ("padded", BoxTest::Padded), ("f64", BoxTest::Double)];

/// Rays through a list of boxes are dear: one of so many is timed.
const SHARE: usize = 40;

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let settings =
        TESTS.map(|(name, _)| (name, format!("bounding-volumes:group=4:box-test={name}")));
    let most = (stage.limits.timed_rays / SHARE).max(50);
    let batches = stage.batches(most, |kind| kind != RayKind::Shadow);
    let aims = aims(stage, stage.prepared.geometry.prims().primitives());
    let said = SceneOutcome::new(
        "of the scene through a list of boxes of 4 primitives",
        format!("{} rays at corners, edges and faces of boxes", aims.len()),
    );
    timed_settings(stage, &settings, "f64", &batches, said, |i, built, _| {
        let steps = counted(&*built.tracer, &batches).elementary_steps;
        let (mut lost, mut found) = (TrialCounts::default(), 0_u64);
        for SurfaceRay { bounds, ray, is_met } in &aims {
            let says = TESTS[i].1.entry(bounds, ray, 0.0, f32::INFINITY).is_some();
            if *is_met {
                lost.add(!says);
            } else {
                found += u64::from(says);
            }
        }
        let figures = vec![
            ("boxes found that are not met", found as f64),
            ("boxes met per ray", steps as f64 / count(&batches).max(1) as f64),
        ];
        Ok((lost.error(), figures))
    })
}

/// A box and a ray at a point of its surface.
struct SurfaceRay {
    bounds: Aabb<f32>,
    ray: Ray<f32>,
    is_met: bool,
}

fn aims(stage: &Stage<'_>, set: &dyn Primitives<f32>) -> Vec<SurfaceRay> {
    let mut random = stage.random("boxes");
    let scene = set.scene_bounds();
    let mut found = Vec::with_capacity(stage.trials());
    for _ in 0..stage.trials() {
        let bounds = set.bounds(random.below(set.len()) as u32);
        let from = scene.min + scene.size() * (point(&mut random).as_vec3() * 1.5 + 0.5);
        let target = on_surface(&bounds, &mut random);
        let ray = Ray::<f32>::new(from, target - from);
        if ray.is_traceable() {
            found.push(SurfaceRay { is_met: is_met(&bounds, &ray), bounds, ray });
        }
    }
    found
}

/// A corner, a point of an edge or of a face.
fn on_surface(b: &Aabb<f32>, random: &mut Random) -> Vec3 {
    let fixed = random.below(3) + 1;
    let first = random.below(3);
    let mut at = Vec3::ZERO;
    for step in 0..3 {
        let k = (first + step) % 3;
        let part = if step < fixed { random.below(2) as f32 } else { unit(random) as f32 };
        at[k] = if part == 1.0 { b.max[k] } else { b.min[k] + (b.max[k] - b.min[k]) * part };
    }
    at
}

/// Returns whether the exact ray, from parameter 0 on, meets the exact box: every way in is no
/// later than every way out. Parameters are fractions (plane - origin) / direction; differences of
/// single precision are exact in f64 for coordinates within 2^29 of each other, and fractions are
/// compared by the signs of error-free products.
fn is_met(b: &Aabb<f32>, ray: &Ray<f32>) -> bool {
    let mut ways_in = vec![(0.0, 1.0)];
    let mut ways_out = Vec::new();
    for k in 0..3 {
        let [lo, hi, o, d] = [b.min[k], b.max[k], ray.origin[k], ray.direction[k]].map(f64::from);
        if d == 0.0 {
            if o < lo || o > hi {
                return false;
            }
            continue;
        }
        // positive denominators
        let [near, far] = if d > 0.0 { [lo, hi] } else { [hi, lo] };
        ways_in.push(((near - o) * d.signum(), d.abs()));
        ways_out.push(((far - o) * d.signum(), d.abs()));
    }
    ways_in.iter().all(|i| ways_out.iter().all(|o| is_no_later(*i, *o)))
}

/// a.0 / a.1 <= b.0 / b.1 for positive denominators, exactly.
fn is_no_later(a: (f64, f64), b: (f64, f64)) -> bool {
    let (left, right) = (a.0 * b.1, b.0 * a.1);
    if left != right {
        // rounding keeps the order of products
        return left < right;
    }
    a.0.mul_add(b.1, -left) <= b.0.mul_add(a.1, -right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oracle_distinguishes_an_ulp_beside_an_edge() {
        let b = Aabb::<f32> { min: Vec3::ZERO, max: Vec3::splat(3.0) };
        let at = |y: f32| {
            is_met(&b, &Ray::<f32>::new(glam::vec3(-1.0, y, 1.0), glam::vec3(1.0, 1.0, 0.0)))
        };
        // meets the edge x = 0, y = 3
        assert!(at(2.0) && at(2.0_f32.next_down()) && !at(2.0_f32.next_up()));
        // ends before: the box lies behind
        assert!(!is_met(&b, &Ray::<f32>::new(glam::vec3(-1.0, 1.0, 1.0), Vec3::NEG_X)));
    }
}
