//! Cost of an image from the work of its rays: seconds = a x rays + b x steps + its tests.
//!
//! What a test takes is measured in the scene itself: a polygon with 144 corners is not a sphere. Tests
//! are made as the leaves of a structure make them: of primitives drawn by the area of their boxes (the
//! chance that a ray meets them: J. Goldsmith, J. Salmon, "Automatic Creation of Object Hierarchies for
//! Ray Tracing", IEEE CG&A 7(5), 1987), with rays through those boxes.
//!
//! The times of a ray (with its shading) and of a step belong to machine and structure; they are found
//! by least squares on the relative errors of measured images of other scenes, neither below 0 (with
//! two unknowns all sets of those above 0 are simply tried; C. Lawson, R. Hanson, "Solving Least Squares
//! Problems", 1974, has the general case).

use accel_core::primitives::{PrimSet, Primitives, PrimsRef};
use accel_core::{Ray, Vector};
use glam::DVec3;
use measurement::system::clock::Clock;
use statistics::estimate::median;
use statistics::random::Random;

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CountedWork {
    pub rays: f64,
    pub steps: f64,
    pub tests: f64,
    pub seconds_per_test: f64,
}

impl CountedWork {
    /// The same on so many times the pixels.
    pub fn times(self, factor: f64) -> Self {
        let (rays, steps) = (self.rays * factor, self.steps * factor);
        Self { rays, steps, tests: self.tests * factor, ..self }
    }
}

/// Seconds a ray and a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    ray: f64,
    step: f64,
}

impl Model {
    /// The model that fits the measured seconds best; `None` when there is nothing to fit, or a
    /// measurement is not above 0.
    pub fn fitted(measured: &[(CountedWork, f64)]) -> Option<Self> {
        let is_bad = |&(_, seconds): &(CountedWork, f64)| !(seconds.is_finite() && seconds > 0.0);
        if measured.is_empty() || measured.iter().any(is_bad) {
            return None;
        }
        // a row says: ray x rays + step x steps = what the tests leave over, all as parts of 1
        let rows: Vec<[f64; 3]> = measured
            .iter()
            .map(|(work, seconds)| {
                let left = 1.0 - work.tests * work.seconds_per_test / seconds;
                [work.rays / seconds, work.steps / seconds, left]
            })
            .collect();
        let sum = |i: usize, j: usize| -> f64 { rows.iter().map(|row| row[i] * row[j]).sum() };
        let (rr, ss, rs, rl, sl) = (sum(0, 0), sum(1, 1), sum(0, 1), sum(0, 2), sum(1, 2));
        let det = rr * ss - rs * rs;
        let candidates = [
            Self { ray: 0.0, step: 0.0 },
            Self { ray: rl / rr, step: 0.0 },
            Self { ray: 0.0, step: sl / ss },
            Self { ray: (rl * ss - sl * rs) / det, step: (sl * rr - rl * rs) / det },
        ];
        let error = |model: &Self| -> f64 {
            let miss = |[r, s, left]: &[f64; 3]| model.ray * r + model.step * s - left;
            rows.iter().map(|row| miss(row).powi(2)).sum()
        };
        let is_valid = |m: &Self| [m.ray, m.step].iter().all(|x| x.is_finite() && *x >= 0.0);
        candidates.into_iter().filter(is_valid).min_by(|a, b| error(a).total_cmp(&error(b)))
    }

    pub fn seconds(&self, work: CountedWork) -> f64 {
        self.ray * work.rays + self.step * work.steps + work.tests * work.seconds_per_test
    }

    /// Seconds a ray and a step.
    pub fn terms(&self) -> [f64; 2] {
        [self.ray, self.step]
    }
}

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
fn drawn(prims: &dyn Primitives<f32>) -> Vec<(u32, Ray<f32>)> {
    if prims.is_empty() {
        return Vec::new();
    }
    let mut total = 0.0;
    let sum = |id| {
        // flat boxes on an axis still have an area; a point has next to none
        total += prims.bounds(id).half_area().max(f64::MIN_POSITIVE);
        total
    };
    let sums: Vec<f64> = (0..prims.len() as u32).map(sum).collect();
    let reach = prims.scene_bounds().size().to_dvec3().length();
    let mut random = Random::new(1, "test time");
    let mut unit = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let pair = |i: usize| {
        let at = (i as f64 + unit()) / TESTS as f64 * total;
        let id = sums.partition_point(|sum| *sum <= at).min(prims.len() - 1) as u32;
        let bounds = prims.bounds(id);
        let size = bounds.size().to_dvec3();
        let target = bounds.min.to_dvec3() + size * DVec3::new(unit(), unit(), unit());
        let direction = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5);
        let direction = direction.normalize_or(DVec3::X);
        (id, Ray::from_dvec3(target - direction * reach, direction))
    };
    (0..TESTS).map(pair).collect()
}

#[cfg(test)]
mod tests {
    use accel_core::primitives::MixedSetBuilder;
    use glam::dvec3;

    use super::*;

    fn work(rays: f64, steps: f64, tests: f64) -> CountedWork {
        CountedWork { rays, steps, tests, seconds_per_test: 2e-8 }
    }

    fn measured(ray: f64, step: f64) -> Vec<(CountedWork, f64)> {
        let model = Model { ray, step };
        [work(1e4, 9e4, 2e4), work(3e4, 2e5, 9e4), work(2e4, 9e5, 1e5)]
            .map(|work| (work, model.seconds(work)))
            .to_vec()
    }

    #[test]
    fn planted_times_are_found_again() {
        let model = Model::fitted(&measured(2e-7, 1e-8)).unwrap();
        let [ray, step] = model.terms();
        assert!((ray / 2e-7 - 1.0).abs() < 1e-9 && (step / 1e-8 - 1.0).abs() < 1e-9, "{model:?}");
        let other = work(7e4, 5e5, 1e4);
        let expected = 7e4 * 2e-7 + 5e5 * 1e-8 + 1e4 * 2e-8;
        assert!((model.seconds(other) / expected - 1.0).abs() < 1e-9);
        assert_eq!(other.times(2.0), work(14e4, 1e6, 2e4));
    }

    #[test]
    fn fitted_times_are_not_negative_and_bad_measurements_are_refused() {
        // steps that seem to save time: the best model without that
        let model = Model::fitted(&measured(5e-7, -5e-9)).unwrap();
        assert!(model.terms().iter().all(|x| *x >= 0.0), "{model:?}");
        // tests that seem to take longer than everything
        let model = Model::fitted(&[(work(10.0, 10.0, 1e9), 1.0)]).unwrap();
        assert_eq!(model.terms(), [0.0, 0.0]);
        assert_eq!(Model::fitted(&[]), None);
        for planted in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(
                Model::fitted(&[(work(1.0, 1.0, 1.0), 1.0), (work(1.0, 1.0, 1.0), planted)]),
                None
            );
        }
        // one measurement is enough for one time
        let alone = CountedWork { rays: 10.0, ..CountedWork::default() };
        assert!((Model::fitted(&[(alone, 5.0)]).unwrap().seconds(alone) - 5.0).abs() < 1e-9);
    }

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
