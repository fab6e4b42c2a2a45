//! The sign test: is the median of paired ratios a given one?
//!
//! Paper: W. J. Dixon, A. M. Mood, "The Statistical Sign Test", Journal of the American Statistical
//! Association 41(236), 1946. Exact; samples equal to the median tested are left out. It assumes
//! nothing of the distribution, which with times of a busy machine is neither normal nor symmetric.

use crate::ratio_of_medians::binomial_tail;

/// The two-sided probability of samples at least as one-sided if their median is `median`, in
/// (0, 1]; none without samples, or with one that is NaN.
pub fn p_value(samples: &[f64], median: f64) -> Option<f64> {
    if samples.is_empty() || samples.iter().any(|x| x.is_nan()) {
        return None;
    }
    let above = samples.iter().filter(|&&x| x > median).count();
    let below = samples.iter().filter(|&&x| x < median).count();
    Some((2.0 * binomial_tail(above + below, above.min(below))).min(1.0))
}

/// Pairs from which one of so many tests can be significant.
pub fn pairs_needed(tests: usize, significance: f64) -> usize {
    let least = |n: usize| 2.0 * 0.5_f64.powi(n as i32);
    (1..1000).find(|&n| least(n) * (tests.max(1) as f64) < significance).unwrap_or(1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_known() {
        let p = |x: &[f64]| p_value(x, 1.0).unwrap();
        assert!((p(&[1.1; 6]) - 2.0 / 64.0).abs() < 1e-12);
        assert!((p(&[1.1, 1.2, 1.3, 1.4, 0.9]) - 12.0 / 32.0).abs() < 1e-12);
        assert_eq!(p(&[1.1, 0.9]), 1.0);
        assert_eq!(p(&[1.0; 4]), 1.0);
        assert_eq!(p_value(&[], 1.0), None);
        // 2 / 64 of six pairs
        assert_eq!([pairs_needed(1, 0.05), pairs_needed(2, 0.05)], [6, 7]);
        assert_eq!(p_value(&[f64::NAN], 1.0), None);
    }
}
