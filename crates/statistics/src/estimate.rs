//! Medians, quantiles, outliers, bootstrap intervals, geometric means; the rest in files of their own.

use serde::{Deserialize, Serialize};

use crate::normal::{student_95, upper_tail};
use crate::random::Random;

pub(crate) const RESAMPLES: usize = if cfg!(fuzzing) { 20 } else { 2000 };

/// A median with its 95% bootstrap percentile interval, expanded by the factor of T. Hesterberg,
/// "What Teachers Should Know About the Bootstrap", The American Statistician 69(4), 2015: the
/// plain percentile interval of few samples is too narrow. Fewer than 6 samples cannot say more
/// than their least and largest, which hold the median in 75% (3 samples) to 94% (5) of all cases.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Estimate {
    /// Median of the samples.
    pub median: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Estimate {
    /// Of a quantity that is known without uncertainty.
    pub fn exactly(x: f64) -> Self {
        Self { median: x, low: x, high: x }
    }

    /// Of a quantity that rises with this one.
    #[must_use]
    pub fn map(&self, of: impl Fn(f64) -> f64) -> Self {
        Self { median: of(self.median), low: of(self.low), high: of(self.high) }
    }

    /// Of one over the quantity.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { median: 1.0 / self.median, low: 1.0 / self.high, high: 1.0 / self.low }
    }

    /// True when the interval contains `value`: the quantity is not significantly different from
    /// it.
    pub fn holds(&self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }
}

/// The middle sample, or the mean of the two in the middle.
pub fn median(samples: &[f64]) -> Option<f64> {
    let mut sorted = samples.to_vec();
    median_of(&mut sorted)
}

pub(crate) fn median_of(samples: &mut [f64]) -> Option<f64> {
    samples.sort_by(f64::total_cmp);
    let n = samples.len();
    match n {
        0 => None,
        _ if n % 2 == 1 => Some(samples[n / 2]),
        _ => Some((samples[n / 2 - 1] + samples[n / 2]) / 2.0),
    }
}

/// The intervals of fewer samples reach to all of them.
const FEW: usize = 6;

/// Median and interval of one quantity; none without samples. Few samples need not be resampled to
/// know their interval.
pub fn estimate(samples: &[f64], seed: u64) -> Option<Estimate> {
    if samples.len() >= FEW {
        return geometric_mean_of_medians(&[samples], seed);
    }
    let mut sorted = samples.to_vec();
    let median = median_of(&mut sorted)?;
    Some(Estimate { median, low: *sorted.first()?, high: *sorted.last()? })
}

/// The ends of the 95% interval of resampled values, each resampled from `samples`.
pub fn interval(resampled: &mut [f64], samples: usize) -> [f64; 2] {
    resampled.sort_by(f64::total_cmp);
    let last = (resampled.len().max(1) - 1) as f64;
    let at = |place: f64| resampled.get(place as usize).copied().unwrap_or(f64::NAN);
    let tail = tail(samples as f64);
    [at((tail * last).floor()), at(((1.0 - tail) * last).ceil())]
}

/// The share of resampled medians outside the interval, on each side.
fn tail(samples: f64) -> f64 {
    if samples < 2.0 {
        return 0.0;
    }
    upper_tail((samples / (samples - 1.0)).sqrt() * student_95(samples - 1.0))
}

/// The geometric mean over groups (scenes) of each group's median, with an interval from
/// resampling within the groups. None when a group is empty or holds what has no logarithm.
///
/// Of a single group it is the median itself, of any sign.
pub fn geometric_mean_of_medians(groups: &[&[f64]], seed: u64) -> Option<Estimate> {
    let of = |medians: &[f64]| match medians {
        [one] => Some(*one),
        _ => geometric_mean(medians),
    };
    let medians = groups.iter().map(|g| median(g)).collect::<Option<Vec<_>>>()?;
    let middle = of(&medians)?;
    let mut random = Random::new(seed, "bootstrap");
    let mut resampled = Vec::with_capacity(RESAMPLES);
    // both are used again: this is most of the time of a report
    let (mut buffer, mut medians) = (Vec::new(), medians);
    for _ in 0..RESAMPLES {
        for (group, median) in groups.iter().zip(&mut medians) {
            buffer.clear();
            buffer.extend(group.iter().map(|_| group[random.below(group.len())]));
            *median = median_of(&mut buffer)?;
        }
        resampled.push(of(&medians)?);
    }
    let fewest = groups.iter().map(|g| g.len()).min().unwrap_or(0);
    let [low, high] = interval(&mut resampled, fewest);
    Some(Estimate { median: middle, low, high })
}

/// The geometric mean; none of no values or of values that are not positive.
pub fn geometric_mean(values: &[f64]) -> Option<f64> {
    if values.is_empty() || values.iter().any(|&v| v.is_nan() || v <= 0.0) {
        return None;
    }
    Some((values.iter().map(|v| v.ln()).sum::<f64>() / values.len() as f64).exp())
}

/// Spearman's rank correlation of pairs, equal values sharing their mean rank; none with fewer
/// than three pairs or where one side is all equal.
pub fn rank_correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    if pairs.len() < 3 {
        return None;
    }
    let (x, y): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
    let (x, y) = (ranks(&x), ranks(&y));
    let mean = (pairs.len() as f64 + 1.0) / 2.0;
    let product =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let spread = (product(&x, &x) * product(&y, &y)).sqrt();
    (spread > 0.0).then(|| product(&x, &y) / spread)
}

/// Ranks from 1; equal values get the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let rank = |v: &f64| {
        let below = values.iter().filter(|o| *o < v).count() as f64;
        let equal = values.iter().filter(|o| *o == v).count() as f64;
        below + (equal + 1.0) / 2.0
    };
    values.iter().map(rank).collect()
}

/// Distance of the fences from the quartiles, in interquartile ranges.
const FENCE: f64 = 1.5;
/// Fewer samples have no quartiles worth the name.
const FEWEST: usize = 4;

/// Samples far from the others, below and above: counted and shown, never dropped.
///
/// Source: J. W. Tukey, "Exploratory Data Analysis", 1977: beyond 1.5 interquartile ranges from the
/// quartiles.
pub fn outliers(samples: &[f64]) -> [usize; 2] {
    if samples.len() < FEWEST {
        return [0; 2];
    }
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (first, third) = (quantile(&sorted, 0.25), quantile(&sorted, 0.75));
    let range = third - first;
    let low = sorted.iter().filter(|&&x| x < first - FENCE * range).count();
    let high = sorted.iter().filter(|&&x| x > third + FENCE * range).count();
    [low, high]
}

/// A quantile of sorted samples, of which there is one at least, linear between them.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    let place = part * (sorted.len() - 1) as f64;
    let (i, share) = (place.floor() as usize, place.fract());
    let next = sorted[(i + 1).min(sorted.len() - 1)];
    sorted[i] + (next - sorted[i]) * share
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[9.0, 1.0, 5.0]), Some(5.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }

    #[test]
    fn geometric_means() {
        assert_eq!(geometric_mean(&[]), None);
        assert_eq!(geometric_mean(&[1.0, 0.0]), None);
        assert_eq!(geometric_mean(&[1.0, f64::NAN]), None);
        assert!((geometric_mean(&[1.0, 4.0, 16.0]).unwrap() - 4.0).abs() < 1e-12);
        assert!((geometric_mean(&[0.5, 2.0]).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn equal_samples_have_an_interval_of_no_width() {
        let e = estimate(&[2.0; 5], 1).unwrap();
        assert_eq!(e, Estimate { median: 2.0, low: 2.0, high: 2.0 });
        assert!(e.holds(2.0) && !e.holds(2.1));
        assert_eq!(estimate(&[], 1), None);
        assert_eq!(geometric_mean_of_medians(&[&[1.0], &[]], 1), None);
    }

    #[test]
    fn the_bootstrap_interval_of_three_samples_is_known() {
        // The median of 3 draws from {1, 2, 3} is 1 with probability 7/27, 3 likewise: both are
        // more than 2.5%, so the interval must reach from the smallest to the largest.
        let e = geometric_mean_of_medians(&[&[1.0, 2.0, 3.0]], 1).unwrap();
        assert_eq!(e, Estimate { median: 2.0, low: 1.0, high: 3.0 });
    }

    #[test]
    fn intervals_of_few_samples_reach_to_the_least_and_the_largest() {
        for n in 1..FEW {
            for largest in [0.9, 1.0, 1.1] {
                let mut samples: Vec<f64> = (1..n).map(|i| 0.5 + 0.05 * i as f64).collect();
                samples.push(largest);
                let interval = estimate(&samples, 1).unwrap();
                assert_eq!((interval.low, interval.high), (samples[0], largest), "{n}");
                assert_eq!(geometric_mean_of_medians(&[&samples], 1), Some(interval), "{n}");
            }
        }
    }

    #[test]
    fn the_bootstrap_interval_of_many_samples_is_known() {
        // 0, 1, ..., 100: the median's standard error is about 101 * 0.5 / sqrt(101) = 5.02, so
        // the 95% interval is near 50 +- 9.85.
        let samples: Vec<f64> = (0..=100).map(f64::from).collect();
        let e = estimate(&samples, 42).unwrap();
        assert_eq!(e.median, 50.0);
        assert!((38.0..=43.0).contains(&e.low) && (57.0..=62.0).contains(&e.high), "{e:?}");
    }

    #[test]
    fn the_interval_is_seeded() {
        let samples: Vec<f64> = (0..40).map(|i| f64::from(i * i % 37)).collect();
        assert_eq!(estimate(&samples, 5), estimate(&samples, 5));
    }

    #[test]
    fn groups_are_joined_by_the_geometric_mean() {
        let e = geometric_mean_of_medians(&[&[1.0, 1.0], &[4.0, 4.0]], 1).unwrap();
        assert!((e.median - 2.0).abs() < 1e-12 && (e.low - 2.0).abs() < 1e-12);
    }

    #[test]
    fn rank_correlations() {
        let of =
            |y: [f64; 4]| rank_correlation(&[(1.0, y[0]), (2.0, y[1]), (3.0, y[2]), (4.0, y[3])]);
        assert_eq!(of([1.0, 20.0, 21.0, 500.0]), Some(1.0));
        assert_eq!(of([4.0, 3.0, 2.0, 1.0]), Some(-1.0));
        assert!((of([1.0, 1.0, 3.0, 2.0]).unwrap() - 0.737_864_8).abs() < 1e-6);
        assert_eq!(of([1.0; 4]), None);
        assert_eq!(rank_correlation(&[(1.0, 1.0), (2.0, 2.0)]), None);
    }

    /// Log-normal with the median 1.
    pub(crate) fn log_normal(random: &mut Random, spread: f64) -> f64 {
        let mut unit = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        // Box and Muller
        let (u, v) = (1.0 - unit(), unit());
        (spread * (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()).exp()
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        // 2,000 trials of 31 rounds: of medians, and of ratios paired by round, both sides of
        // which share what disturbs the round; the truth is 1 and 1.2
        let mut random = Random::new(9, "coverage");
        let mut held = [0; 2];
        for trial in 0..2000 {
            let samples: Vec<f64> = (0..31).map(|_| log_normal(&mut random, 0.2)).collect();
            let ratios: Vec<f64> = (0..31)
                .map(|_| {
                    let round = log_normal(&mut random, 0.3);
                    let mut side = |s| s * round * log_normal(&mut random, 0.05);
                    side(1.2) / side(1.0)
                })
                .collect();
            held[0] += u32::from(estimate(&samples, trial).unwrap().holds(1.0));
            held[1] += u32::from(estimate(&ratios, trial).unwrap().holds(1.2));
        }
        assert!(held.iter().all(|h| (1860..=1940).contains(h)), "{held:?} of 2000");
    }

    #[test]
    fn values_beyond_the_fences_are_counted() {
        let mut samples = vec![10.0, 11.0, 12.0, 13.0, 14.0];
        assert_eq!(outliers(&samples), [0, 0]);
        samples.push(40.0);
        assert_eq!(outliers(&samples), [0, 1]);
        samples.push(-20.0);
        assert_eq!(outliers(&samples), [1, 1]);
        assert_eq!(outliers(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.5]), [0, 1]);
        assert_eq!(outliers(&[1.0, 99.0, 1.0]), [0, 0]);
    }
}
