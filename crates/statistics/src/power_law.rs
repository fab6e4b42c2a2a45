//! How a quantity grows with another: the exponent of the power law that fits best.
//!
//! The line of least squares through the logarithms, and the interval of its slope by Student's
//! distribution, from how far the points lie off the line (N. Draper, H. Smith, "Applied Regression
//! Analysis", 3rd edition, 1998, section 1.4). What lies off it is noise, and that no power law is
//! exact: n log n has an exponent a little above 1, which falls as n grows.

use crate::normal::student_95;

/// y = c x^exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerLaw {
    /// The exponent: the slope of the line on logarithmic axes.
    pub exponent: f64,
    /// Its 95% interval; none of two points, which always lie on a line.
    pub interval: Option<[f64; 2]>,
    /// Points that it was fitted to.
    pub points: usize,
}

/// The power law through points (x, y), those left out that have no logarithm; none with fewer
/// than two of different x.
pub fn power_law(points: &[(f64, f64)]) -> Option<PowerLaw> {
    let logarithms: Vec<(f64, f64)> = points
        .iter()
        .map(|&(x, y)| (x.ln(), y.ln()))
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    let n = logarithms.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logarithms.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        logarithms.iter().map(|p| of(p.0 - x, p.1 - y)).sum()
    };
    let spread = sum(&|dx, _| dx * dx);
    if logarithms.len() < 2 || spread <= f64::EPSILON {
        return None;
    }
    let exponent = sum(&|dx, dy| dx * dy) / spread;
    let off = sum(&|dx, dy| (dy - exponent * dx).powi(2));
    let degrees = n - 2.0;
    let interval = (degrees > 0.0).then(|| {
        let half = student_95(degrees) * (off / degrees / spread).sqrt();
        [exponent - half, exponent + half]
    });
    Some(PowerLaw { exponent, interval, points: logarithms.len() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::tests::log_normal;
    use crate::random::Random;

    const SIZES: [f64; 5] = [1e3, 1e4, 1e5, 1e6, 1e7];

    fn of(y: impl Fn(f64) -> f64) -> PowerLaw {
        power_law(&SIZES.map(|x| (x, y(x)))).unwrap()
    }

    #[test]
    fn powers_have_their_exponents() {
        for power in [0.0, 0.5, 1.0, 2.0, -1.0] {
            let law = of(|x| 3e-9 * x.powf(power));
            let [low, high] = law.interval.unwrap();
            assert!((law.exponent - power).abs() < 1e-12, "{law:?}");
            assert!(high - low < 1e-6 && law.points == 5, "{law:?}");
        }
    }

    #[test]
    fn n_log_n_is_a_little_above_one() {
        let law = of(|x| x * x.ln());
        assert!((1.05..1.15).contains(&law.exponent), "{law:?}");
    }

    #[test]
    fn a_known_fit_has_its_known_interval() {
        // logarithms (0, 0), (1, 2), (2, 1): slope 1/2; off the line by sqrt(1.5), one degree
        let e = std::f64::consts::E;
        let law = power_law(&[(1.0, 1.0), (e, e * e), (e * e, e)]).unwrap();
        let half = 12.7062 * (1.5_f64 / 2.0).sqrt();
        let [low, high] = law.interval.unwrap();
        assert!((law.exponent - 0.5).abs() < 1e-12);
        assert!((low - 0.5 + half).abs() < 1e-3 && (high - 0.5 - half).abs() < 1e-3, "{law:?}");
    }

    #[test]
    fn values_without_a_logarithm_are_left_out() {
        let law = power_law(&[(1.0, 0.0), (10.0, 10.0), (100.0, 100.0), (5.0, f64::NAN)]).unwrap();
        assert_eq!((law.points, law.interval), (2, None));
        assert!((law.exponent - 1.0).abs() < 1e-12);
        assert_eq!(power_law(&[(10.0, 1.0)]), None);
        assert_eq!(power_law(&[(10.0, 1.0), (10.0, 2.0)]), None, "one size, however often");
        assert_eq!(power_law(&[]), None);
    }

    #[test]
    fn the_interval_holds_the_truth_as_often_as_it_says() {
        // quadratic times, 10% of noise: the planted slope is 2
        let mut random = Random::new(4, "slopes");
        let (mut held, mut of_another) = (0, 0);
        for _ in 0..2000 {
            let noisy: Vec<(f64, f64)> =
                SIZES.iter().map(|&x| (x, x * x * log_normal(&mut random, 0.1))).collect();
            let [low, high] = power_law(&noisy).unwrap().interval.unwrap();
            held += u32::from(low <= 2.0 && 2.0 <= high);
            of_another += u32::from(low <= 1.7 && 1.7 <= high);
        }
        assert!((1860..=1940).contains(&held), "{held} of 2000");
        assert!(of_another < 20, "a slope of 1.7 is refused: {of_another}");
    }
}
