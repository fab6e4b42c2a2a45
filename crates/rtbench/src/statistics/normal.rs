//! The normal distribution and Student's, as far as intervals and tests need them.

use std::f64::consts::SQRT_2;

use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::function::erf::{erfc, erfc_inv};

/// Standard deviations of a normal distribution that hold 95% of it.
pub const NORMAL_95: f64 = 1.959_963_985;

/// The probability of more than `x` standard deviations above the mean.
pub fn upper_tail(x: f64) -> f64 {
    erfc(x / SQRT_2) / 2.0
}

/// The quantile of the normal distribution, standard deviations from the mean.
pub fn quantile(probability: f64) -> f64 {
    -SQRT_2 * erfc_inv(2.0 * probability)
}

/// The 97.5% quantile of Student's distribution; infinite without a degree of freedom.
pub fn student_95(degrees: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_and_tails_are_those_of_the_tables() {
        assert!((quantile(0.975) - NORMAL_95).abs() < 1e-9);
        assert!((quantile(0.875) - 1.150_349_380_4).abs() < 1e-9);
        assert_eq!(quantile(0.5), 0.0);
        assert!((upper_tail(NORMAL_95) - 0.025).abs() < 1e-10);
        assert!((upper_tail(0.0) - 0.5).abs() < 1e-15);
        for (degrees, expected) in [
            (1.0, 12.706_204_736),
            (2.0, 4.302_652_730),
            (3.0, 3.182_446_305),
            (4.0, 2.776_445_105),
            (8.0, 2.306_004_135),
            (30.0, 2.042_272_456),
        ] {
            let error = (student_95(degrees) / expected - 1.0).abs();
            assert!(error < 1e-7, "{degrees}: {error:e}");
        }
        assert_eq!(student_95(0.0), f64::INFINITY);
    }
}
