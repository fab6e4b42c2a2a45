//! The normal distribution and Student's, as far as intervals and tests need them.

use std::f64::consts::SQRT_2;

/// Standard deviations of a normal distribution that hold 95% of it.
pub const NORMAL_95: f64 = 1.959_963_985;

/// The probability of more than `x >= 0` standard deviations above the mean.
pub fn upper_tail(x: f64) -> f64 {
    complementary_error(x / SQRT_2) / 2.0
}

/// The quantile of the normal distribution, for a probability of at least one half, absolute error
/// below 4.5e-4 (M. Abramowitz, I. Stegun, "Handbook of Mathematical Functions", 1964, 26.2.23).
pub fn quantile(probability: f64) -> f64 {
    let t = (-2.0 * (1.0 - probability).max(f64::MIN_POSITIVE).ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}

/// The 97.5% quantile of Student's distribution: exact for 1 and 2 degrees, where it has a closed
/// form, found by bisection below 4, else with a relative error below 1% (the expansion in powers
/// of the inverse, Abramowitz and Stegun, 26.7.5).
pub fn student_95(degrees: f64) -> f64 {
    if degrees == 1.0 {
        return (0.475 * std::f64::consts::PI).tan();
    }
    if degrees == 2.0 {
        return 0.95 / (2.0_f64 * 0.975 * 0.025).sqrt();
    }
    if degrees < 4.0 {
        let is_within = |t: f64| student_tails(t, degrees) > 0.05;
        let (mut low, mut high) = (2.0, 1e7);
        while high / low > 1.0 + 1e-6 {
            let middle = f64::sqrt(low * high);
            *(if is_within(middle) { &mut low } else { &mut high }) = middle;
        }
        return low;
    }
    let x = NORMAL_95;
    let first = (x.powi(3) + x) / 4.0;
    let second = (5.0 * x.powi(5) + 16.0 * x.powi(3) + 3.0 * x) / 96.0;
    let third = (3.0 * x.powi(7) + 19.0 * x.powi(5) + 17.0 * x.powi(3) - 15.0 * x) / 384.0;
    x + first / degrees + second / degrees.powi(2) + third / degrees.powi(3)
}

/// The two-sided probability of a value of Student's distribution of at least `t >= 0` on either
/// side, absolute error below 1e-5 from 2 degrees on: the density is a power of a cosine in the
/// angle whose tangent is t over the root of the degrees, summed by Simpson's rule. For infinite
/// degrees that of the normal distribution.
pub fn student_tails(t: f64, degrees: f64) -> f64 {
    const STEPS: usize = 300;
    if degrees > 1e4 {
        return (2.0 * upper_tail(t)).min(1.0);
    }
    let whole = std::f64::consts::FRAC_PI_2;
    let sum = |from: f64| {
        let step = (whole - from) / STEPS as f64;
        let at = |i: usize| (from + step * i as f64).cos().max(0.0).powf(degrees - 1.0);
        let weight = |i: usize| match i {
            0 | STEPS => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        (0..=STEPS).map(|i| weight(i) * at(i)).sum::<f64>() * step / 3.0
    };
    (sum((t / degrees.sqrt()).atan()) / sum(0.0)).min(1.0)
}

/// 1 - erf(x) for x >= 0, relative error below 1.2e-7 (W. Press et al., "Numerical Recipes", 1992,
/// section 6.2: a Chebyshev fit).
fn complementary_error(x: f64) -> f64 {
    const FIT: [f64; 10] = [
        -1.26551223,
        1.00002368,
        0.37409196,
        0.09678418,
        -0.18628806,
        0.27886807,
        -1.13520398,
        1.48851587,
        -0.82215223,
        0.17087277,
    ];
    let t = 1.0 / (1.0 + 0.5 * x);
    let fit = FIT.iter().rev().fold(0.0, |sum, c| sum * t + c);
    t * (-x * x + fit).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_and_tails_are_those_of_the_tables() {
        assert!((quantile(0.975) - NORMAL_95).abs() < 5e-4);
        assert!((quantile(0.875) - 1.150_349).abs() < 5e-4);
        assert!((upper_tail(NORMAL_95) - 0.025).abs() < 1e-6);
        assert!((upper_tail(0.0) - 0.5).abs() < 1e-6);
        for (degrees, expected) in
            [(1.0, 12.706), (2.0, 4.303), (3.0, 3.182), (4.0, 2.776), (8.0, 2.306), (30.0, 2.042)]
        {
            assert!((student_95(degrees) / expected - 1.0).abs() < 0.01, "{degrees}");
            assert!((student_tails(expected, degrees) - 0.05).abs() < 1e-4, "{degrees}");
        }
        assert!((student_95(2.0 + 1e-9) - student_95(2.0)).abs() < 1e-3);
        assert!(student_95(1.5) > student_95(2.0) && student_95(1.5) < student_95(1.0));
        assert_eq!(student_tails(0.0, 3.0), 1.0);
        assert!((student_tails(NORMAL_95, f64::INFINITY) - 0.05).abs() < 1e-6);
    }
}
