//! Scenes and rays for differential tests. The tests in `tests/` have them, too.

use glam::DVec3;

use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::{Cone, MixedSet, MixedSetBuilder, Primitives};
use crate::query::tracer::Tracer;

/// A small generator of test numbers.
pub(crate) struct Random(pub u64);

impl Random {
    /// Random number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }

    pub(crate) fn point(&mut self, size: [f64; 3]) -> DVec3 {
        DVec3::new(self.unit() * size[0], self.unit() * size[1], self.unit() * size[2])
    }
}

/// What `f` makes on that many threads.
pub(crate) fn on_threads<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(f)
}

/// `n` primitives of all kinds in a box of that size; every tenth is transmissive, every sixth
/// repeats the place of another.
pub(crate) fn mixed_scene<S: Scalar>(n: u32, seed: u64, size: [f64; 3]) -> MixedSet<S> {
    let mut random = Random(seed);
    let mut set = MixedSetBuilder::<S>::default();
    let mut at = DVec3::ZERO;
    for i in 0..n {
        if i % 6 != 5 {
            at = random.point(size);
        }
        let small = size.map(|s| s * 0.2);
        let half = DVec3::from(small) * 0.5;
        match i % 4 {
            0 => set.triangle([at, at + random.point(small) - half, at + random.point(small)]),
            1 => {
                // a quadrilateral in the plane z = constant, often exactly in a cell's plane
                let z = (at.z * 8.0).round() / 8.0;
                let (w, h) = (small[0].max(1e-3), small[1].max(1e-3));
                let corner = |x: f64, y: f64| DVec3::new(at.x + x * w, at.y + y * h, z);
                set.polygon(&[corner(0., 0.), corner(1., 0.), corner(1., 1.), corner(0., 1.)])
            }
            2 => set.sphere(at, 0.05 * random.unit() + 0.01),
            _ => set.cone(Cone::new(at, 0.04, at + random.point(small) + DVec3::Z * 0.01, 0.02)),
        }
        .unwrap();
        if i % 10 == 3 {
            set.last_is_transmissive();
        }
    }
    set.finish()
}

/// 10,000 times the same triangle, and one more behind it.
pub(crate) fn duplicates<S: Scalar>() -> MixedSet<S> {
    let mut set = MixedSetBuilder::<S>::default();
    for i in 0..10_001 {
        let z = if i == 0 { 2.0 } else { 1.0 };
        set.triangle([DVec3::new(0.0, 0.0, z), DVec3::new(1.0, 0.0, z), DVec3::new(0.0, 1.0, z)])
            .unwrap();
    }
    set.finish()
}

/// Random rays at the set, axis-parallel ones, ones in eighth-planes, ones between primitives.
pub(crate) fn rays<S: Scalar>(set: &MixedSet<S>, n: usize, seed: u64) -> Vec<Ray<S>> {
    let mut random = Random(seed);
    let bounds = set.scene_bounds();
    let (lo, size) = (bounds.min.to_dvec3(), bounds.size().to_dvec3());
    let mut out = Vec::new();
    for i in 0..n {
        let inside = |random: &mut Random| lo + random.point([1.0; 3]) * size;
        let mut from = inside(&mut random);
        let to = inside(&mut random);
        let mut direction = to - from;
        match i % 6 {
            0 => from -= direction * 3.0,
            1 => {
                direction = [DVec3::X, DVec3::Y, DVec3::Z][i / 6 % 3];
                if i / 18 % 2 == 0 {
                    direction = -direction;
                }
                from -= direction * size.max_element();
            }
            2 => {
                // in planes of eighths of the box, where cells often end
                from =
                    lo + ((from - lo) / size.max(DVec3::splat(1e-30)) * 8.0).round() / 8.0 * size;
                direction[i / 6 % 3] = -0.0;
            }
            3 => {
                let b = set.bounds((i % set.len()) as u32);
                direction = b.min.to_dvec3().lerp(b.max.to_dvec3(), 0.5) - from;
            }
            _ => {}
        }
        let mut ray = Ray::<S>::from_dvec3(from, direction);
        if i % 5 == 4 {
            (ray.t_min, ray.t_max) = (S::from_f64(0.1), S::from_f64(0.8));
        }
        out.push(ray);
    }
    out
}

/// Returns which rays are blocked.
pub(crate) fn occlusions<S: Scalar>(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> Vec<bool> {
    written(rays.len(), |blocked| tracer.occlusions(rays, blocked))
}

/// `n` answers that are the same whatever stood there before: all of them are written.
pub(crate) fn written(n: usize, mut ask: impl FnMut(&mut [bool])) -> Vec<bool> {
    let [free, blocked] = [false, true].map(|preset| {
        let mut answers = vec![preset; n];
        ask(&mut answers);
        answers
    });
    assert!(free == blocked, "answers are left out");
    free
}

/// Scenes that are hard for grids, by name.
pub(crate) fn hard_scenes<S: Scalar>() -> Vec<(&'static str, MixedSet<S>)> {
    vec![
        ("cube", mixed_scene(300, 1, [1.0; 3])),
        ("flat", mixed_scene(200, 2, [1.0, 1.0, 0.0])),
        ("stretched", mixed_scene(200, 3, [300.0, 1.0, 1.0])),
        ("one", mixed_scene(1, 4, [1.0; 3])),
        ("duplicates", duplicates()),
    ]
}

#[test]
#[should_panic(expected = "answers are left out")]
fn a_planted_answer_that_is_left_out_is_noticed() {
    written(3, |answers| answers[..2].fill(true));
}
