//! Cost of an image from the work of its rays: seconds = a x rays + b x steps + its tests.
//!
//! What a test takes is measured in the scene itself ([`super::test_time`]). The times of a ray
//! (with its shading) and of a step belong to machine and structure; they are found by least
//! squares on the relative errors of measured images of other scenes, neither below 0 (with two
//! unknowns all sets of those above 0 are simply tried; C. Lawson, R. Hanson, "Solving Least
//! Squares Problems", 1974, has the general case).

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CountedWork {
    /// Rays of all kinds.
    pub rays: f64,
    pub steps: f64,
    pub tests: f64,
    /// Seconds that such a test takes.
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

#[cfg(test)]
mod tests {
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
}
