//! Change points of a series: E-divisive.
//!
//! Papers: D. S. Matteson, N. A. James, "A Nonparametric Approach for Multiple Change Point
//! Analysis of Multivariate Data", Journal of the American Statistical Association 109(505), 2014:
//! the divergence of two samples by the distances of their members (with exponent 1), hierarchical
//! bisection, and a permutation test that says when to end. D. Daly, W. Brown, H. Ingo, J. O'Leary,
//! D. Bradford, "The Use of Change Point Detection to Identify Software Performance Regressions in
//! a Continuous Integration System", ICPE 2020: the same for the results of benchmarks, commit by
//! commit.
//!
//! Deviations: the sample behind a candidate reaches to the end of its segment, where Matteson and
//! James look for its best end, too; Daly et al. do as we. A permutation test ends as soon as its
//! verdict is certain (J. Besag, P. Clifford, "Sequential Monte Carlo p-values", Biometrika 78(2),
//! 1991): most series have no change, and need few permutations to say so. Ratios go in as their
//! logarithms.

use crate::random::Random;

/// Thresholds of change detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// The probability that values without any change are said to have one, in each test.
    pub significance: f64,
    /// Permutations of a test, at most.
    pub permutations: u32,
    /// Values on each side of a change, at least.
    pub shortest: usize,
}

impl Default for Sensitivity {
    /// One of a thousand series without a change is reported to have one.
    fn default() -> Self {
        Self { significance: 0.001, permutations: 1999, shortest: 3 }
    }
}

/// The places of the first values of all segments but the first, in rising order.
///
/// All values must be finite.
pub fn change_points(values: &[f64], sensitivity: &Sensitivity, seed: u64) -> Vec<usize> {
    let mut random = Random::new(seed, "change points");
    let mut found = Vec::new();
    let mut open = vec![(0, values.len())];
    while let Some((from, to)) = open.pop() {
        let Some(segment) = values.get(from..to) else { continue };
        let Some((place, divergence)) = best_split(segment, sensitivity.shortest) else { continue };
        if is_significant(segment, divergence, sensitivity, &mut random) {
            found.push(from + place);
            open.extend([(from, from + place), (from + place, to)]);
        }
    }
    found.sort_unstable();
    found
}

/// The place that divides the values into the two most different samples, and their divergence.
fn best_split(values: &[f64], shortest: usize) -> Option<(usize, f64)> {
    let n = values.len();
    let shortest = shortest.max(2);
    let last = n.checked_sub(shortest).filter(|last| *last >= shortest)?;
    let distances = |to: f64, of: &[f64]| of.iter().map(|x| (x - to).abs()).sum::<f64>();
    // sums of distances: within the left sample, within the right one, between both
    let (mut left, mut between) = (0.0, 0.0);
    let mut right: f64 =
        values.iter().enumerate().map(|(i, x)| distances(*x, &values[i + 1..])).sum();
    let mut best: Option<(usize, f64)> = None;
    for place in 1..=last {
        // the value before the place goes from right to left
        let moved = values[place - 1];
        let (to_left, to_right) =
            (distances(moved, &values[..place - 1]), distances(moved, &values[place..]));
        left += to_left;
        right -= to_right;
        between += to_right - to_left;
        if place < shortest {
            continue;
        }
        let (a, b) = (place as f64, (n - place) as f64);
        let pairs = |n: f64| n * (n - 1.0) / 2.0;
        let energy = 2.0 * between / (a * b) - left / pairs(a) - right / pairs(b);
        let divergence = a * b / (a + b) * energy;
        if best.is_none_or(|(_, most)| divergence > most) {
            best = Some((place, divergence));
        }
    }
    best
}

/// Returns whether so large a divergence is rare among permutations of the values.
fn is_significant(
    values: &[f64],
    divergence: f64,
    sensitivity: &Sensitivity,
    random: &mut Random,
) -> bool {
    if divergence <= 0.0 {
        return false;
    }
    // the observed order is one of all: (as large + 1) / (permutations + 1) is the probability
    let most = sensitivity.significance * (f64::from(sensitivity.permutations) + 1.0) - 1.0;
    let mut as_large = 0.0;
    let mut permuted = values.to_vec();
    for _ in 0..sensitivity.permutations {
        if as_large > most {
            break;
        }
        random.shuffle(&mut permuted);
        let chance = best_split(&permuted, sensitivity.shortest);
        // rounding of sums must not make an equal one less
        if chance.is_some_and(|(_, chance)| chance >= divergence * (1.0 - 1e-9)) {
            as_large += 1.0;
        }
    }
    as_large <= most
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values around 0 with that spread, about normal: the mean of twelve uniform ones.
    fn noise(n: usize, spread: f64, seed: u64) -> Vec<f64> {
        let mut random = Random::new(seed, "noise");
        let mut uniform = || random.next_u64() as f64 / u64::MAX as f64;
        (0..n).map(|_| ((0..12).map(|_| uniform()).sum::<f64>() - 6.0) * spread).collect()
    }

    fn found(values: &[f64], seed: u64) -> Vec<usize> {
        change_points(values, &Sensitivity::default(), seed)
    }

    #[test]
    fn planted_steps_are_found_at_their_places() {
        // 5% up after a while, noise of 1%: twenty runs of a nightly job
        let exact = (0..50).filter(|seed| {
            let mut values = noise(20, 0.01, *seed);
            values[12..].iter_mut().for_each(|v| *v += 0.05);
            found(&values, *seed) == [12]
        });
        assert!(exact.count() >= 48);
        // up, and back; and with an outlier, which is no change
        let mut values = noise(60, 0.01, 7);
        values[20..40].iter_mut().for_each(|v| *v += 0.08);
        values[50] += 0.3;
        assert_eq!(found(&values, 1), [20, 40]);
        // a step without noise, as counters have it
        let exact: Vec<f64> = [vec![1.0; 10], vec![1.5; 10]].concat();
        assert_eq!(found(&exact, 1), [10]);
    }

    #[test]
    fn noise_has_no_more_false_changes_than_stated() {
        let count = |sensitivity: Sensitivity, series: u64, n: usize| {
            let has_some = |seed: &u64| {
                !change_points(&noise(n, 0.02, *seed + 1000), &sensitivity, *seed).is_empty()
            };
            (0..series).filter(has_some).count()
        };
        // 5% of 400 series are 20; more than 33 have a probability of about 0.002
        let loose = Sensitivity { significance: 0.05, permutations: 99, shortest: 3 };
        let false_alarms = count(loose, 400, 20);
        assert!((5..=33).contains(&false_alarms), "{false_alarms} of 400");
        // the default: 0.1% of 1000 series is 1; more than 5 have a probability of 0.0006
        let false_alarms = count(Sensitivity::default(), 1000, 20);
        assert!(false_alarms <= 5, "{false_alarms} of 1000");
    }

    #[test]
    fn the_divergence_is_that_of_its_definition() {
        let values = [1.0, 4.0, 2.0, 8.0, 9.0, 7.0, 7.5];
        let (place, divergence) = best_split(&values, 2).unwrap();
        let mean = |a: &[f64], b: &[f64]| {
            let pairs = a.iter().flat_map(|x| b.iter().map(move |y| (x - y).abs()));
            pairs.sum::<f64>() / (a.len() * b.len()) as f64
        };
        let own = |a: &[f64]| mean(a, a) * a.len() as f64 / (a.len() as f64 - 1.0);
        let (a, b) = values.split_at(place);
        let scale = (a.len() * b.len()) as f64 / values.len() as f64;
        let defined = scale * (2.0 * mean(a, b) - own(a) - own(b));
        assert_eq!(place, 3);
        assert!((divergence - defined).abs() < 1e-12, "{divergence} {defined}");
    }

    #[test]
    fn short_and_constant_series_have_no_change_points() {
        for n in 0..6 {
            assert_eq!(found(&noise(n, 1.0, 1), 1), [0; 0]);
        }
        assert_eq!(found(&[1.0; 30], 1), [0; 0]);
        let values = noise(40, 0.01, 3);
        assert_eq!(found(&values, 5), found(&values, 5), "a seed, one answer");
    }
}
