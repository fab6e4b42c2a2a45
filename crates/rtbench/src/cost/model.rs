//! What a ray costs, from what it does: seconds = a x rays + b x tests + c x steps.
//!
//! The three times belong to machine and structure. They are found by least squares on the
//! relative errors of measured images of other scenes, none of them below 0 (C. Lawson,
//! R. Hanson, "Solving Least Squares Problems", 1974; with three unknowns all seven sets of those
//! above 0 are simply tried).

/// What an image took.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Rays of all kinds.
    pub rays: f64,
    /// Ray-primitive intersection tests.
    pub tests: f64,
    /// Traversal steps.
    pub steps: f64,
}

impl Work {
    fn terms(self) -> [f64; 3] {
        [self.rays, self.tests, self.steps]
    }

    /// The same on so many times the pixels.
    pub fn times(self, factor: f64) -> Self {
        let [rays, tests, steps] = self.terms().map(|x| x * factor);
        Self { rays, tests, steps }
    }
}

/// Seconds a ray, a test and a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    seconds: [f64; 3],
}

impl Model {
    /// The model that fits the measured seconds best; `None` when there is nothing to fit, or a
    /// measurement is not above 0.
    pub fn fitted(measured: &[(Work, f64)]) -> Option<Self> {
        if measured.iter().any(|(_, seconds)| !(seconds.is_finite() && *seconds > 0.0)) {
            return None;
        }
        let rows: Vec<[f64; 3]> =
            measured.iter().map(|(work, seconds)| work.terms().map(|x| x / seconds)).collect();
        let error = |s: &[f64; 3]| -> f64 { rows.iter().map(|r| (dot(r, s) - 1.0).powi(2)).sum() };
        (1..8_u8)
            .filter_map(|used| solved(&rows, used))
            .filter(|s| s.iter().all(|x| *x >= 0.0))
            .min_by(|a, b| error(a).total_cmp(&error(b)))
            .map(|seconds| Self { seconds })
    }

    /// Predicted seconds.
    pub fn seconds(&self, work: Work) -> f64 {
        dot(&work.terms(), &self.seconds)
    }

    /// Seconds a ray, a test, a step.
    pub fn terms(&self) -> [f64; 3] {
        self.seconds
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Least squares of `rows . x = 1` where only the unknowns whose bits are set may differ from 0:
/// the normal equations, by Gauss-Jordan elimination.
fn solved(rows: &[[f64; 3]], used: u8) -> Option<[f64; 3]> {
    let unknowns: Vec<usize> = (0..3).filter(|k| used >> k & 1 == 1).collect();
    let n = unknowns.len();
    let mut m = vec![vec![0.0; n + 1]; n];
    for row in rows {
        for (i, &u) in unknowns.iter().enumerate() {
            for (j, &v) in unknowns.iter().enumerate() {
                m[i][j] += row[u] * row[v];
            }
            m[i][n] += row[u];
        }
    }
    // unknowns of different size: scale each equation by its diagonal
    for i in 0..n {
        let pivot = m[i][i];
        let largest = m[i][..n].iter().fold(0.0_f64, |a, x| a.max(x.abs()));
        if !(pivot.abs() > largest * 1e-12) {
            return None;
        }
        m[i].iter_mut().for_each(|x| *x /= pivot);
        for k in (0..n).filter(|&k| k != i) {
            let factor = m[k][i];
            for j in 0..=n {
                m[k][j] -= factor * m[i][j];
            }
        }
    }
    let mut x = [0.0; 3];
    for (equation, &unknown) in m.iter().zip(&unknowns) {
        x[unknown] = equation[n];
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work(rays: f64, tests: f64, steps: f64) -> Work {
        Work { rays, tests, steps }
    }

    fn measured(truth: [f64; 3], works: &[Work]) -> Vec<(Work, f64)> {
        let model = Model { seconds: truth };
        works.iter().map(|&work| (work, model.seconds(work))).collect()
    }

    const WORKS: [Work; 4] = [
        Work { rays: 1e4, tests: 2e4, steps: 9e4 },
        Work { rays: 3e4, tests: 9e4, steps: 2e5 },
        Work { rays: 2e4, tests: 1e5, steps: 9e5 },
        Work { rays: 5e4, tests: 3e4, steps: 1e5 },
    ];

    #[test]
    fn planted_times_are_found_again() {
        let truth = [2e-7, 3e-8, 1e-8];
        let model = Model::fitted(&measured(truth, &WORKS)).unwrap();
        for (found, planted) in model.terms().iter().zip(truth) {
            assert!((found / planted - 1.0).abs() < 1e-6, "{model:?}");
        }
        let other = work(7e4, 1e4, 5e5);
        let expected = 7e4 * 2e-7 + 1e4 * 3e-8 + 5e5 * 1e-8;
        assert!((model.seconds(other) / expected - 1.0).abs() < 1e-6);
        assert_eq!(other.times(2.0), work(14e4, 2e4, 1e6));
    }

    #[test]
    fn no_time_is_below_0_and_bad_measurements_are_refused() {
        // steps that seem to save time: the best model without that
        let model = Model::fitted(&measured([5e-7, 3e-8, -5e-9], &WORKS)).unwrap();
        assert!(model.terms().iter().all(|x| *x >= 0.0), "{model:?}");
        assert!(model.seconds(WORKS[0]) > 0.0);
        assert_eq!(Model::fitted(&[]), None);
        for planted in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Model::fitted(&[(WORKS[0], 1.0), (WORKS[1], planted)]), None);
        }
    }

    #[test]
    fn one_measurement_is_enough_for_one_time() {
        let model = Model::fitted(&[(work(10.0, 0.0, 0.0), 5.0)]).unwrap();
        assert!((model.seconds(work(20.0, 0.0, 0.0)) - 10.0).abs() < 1e-9);
    }
}
