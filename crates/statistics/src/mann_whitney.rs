//! The Mann-Whitney U test: do two sets of samples come from one distribution?
//!
//! Paper: H. B. Mann, D. R. Whitney, "On a Test of Whether One of Two Random Variables Is
//! Stochastically Larger than the Other", Annals of Mathematical Statistics 18(1), 1947.
//! Exact for up to `EXACT` samples per side without ties (the counts of the paper's recurrence);
//! else the normal approximation with corrections for ties and continuity.

use crate::normal::upper_tail;

/// Largest side that is counted exactly.
const EXACT: usize = 20;

/// The two-sided probability of samples at least as unlike as these if there is no difference, in
/// (0, 1]; none when a side is empty or a sample is NaN.
pub fn p_value(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.is_empty() || b.is_empty() || a.iter().chain(b).any(|x| x.is_nan()) {
        return None;
    }
    // pairs in which a is larger; a tie counts half, so twice the number is whole
    let mut twice_u = 0u64;
    let mut has_ties = false;
    for x in a {
        for y in b {
            twice_u += if x > y { 2 } else { u64::from(x == y) };
            has_ties |= x == y;
        }
    }
    let pairs = (a.len() * b.len()) as u64;
    let u = twice_u.min(2 * pairs - twice_u);
    if !has_ties && a.len() <= EXACT && b.len() <= EXACT {
        return Some(exact(a.len(), b.len(), (u / 2) as usize));
    }
    Some(approximate(a, b, u as f64 / 2.0))
}

/// The least probability that samples of such sizes can have.
pub fn least_p(n: usize, m: usize) -> f64 {
    let orders = (1..=n).fold(1.0, |all, i| all * (m + i) as f64 / i as f64);
    (2.0 / orders).min(1.0)
}

/// Samples a side from which one of so many tests can be significant.
pub fn samples_needed(tests: usize, significance: f64) -> usize {
    let is_enough = |n: &usize| least_p(*n, *n) * (tests.max(1) as f64) < significance;
    (crate::ratio_of_medians::FEWEST..1000).find(is_enough).unwrap_or(1000)
}

/// Twice the part of all orders of `n` and `m` samples that have at most `u` inversions.
fn exact(n: usize, m: usize, u: usize) -> f64 {
    // counts[k][v]: orders of k samples of one side among j of the other with v inversions, by
    // f(k, j, v) = f(k - 1, j, v - j) + f(k, j - 1, v); in f64, as there are up to C(40, 20)
    let mut counts = vec![vec![0.0; n * m + 1]; n + 1];
    for row in &mut counts {
        row[0] = 1.0;
    }
    for j in 1..=m {
        for k in 1..=n {
            let (fewer, rest) = counts.split_at_mut(k);
            for v in j..=n * m {
                rest[0][v] += fewer[k - 1][v - j];
            }
        }
    }
    let all: f64 = counts[n].iter().sum();
    let tail: f64 = counts[n][..=u].iter().sum();
    (2.0 * tail / all).min(1.0)
}

/// The normal approximation, `u` the lesser of both statistics.
fn approximate(a: &[f64], b: &[f64], u: f64) -> f64 {
    let (n, m) = (a.len() as f64, b.len() as f64);
    let mut all: Vec<f64> = a.iter().chain(b).copied().collect();
    all.sort_by(f64::total_cmp);
    let ties: f64 = all
        .chunk_by(|x, y| x == y)
        .map(|run| {
            let t = run.len() as f64;
            t * t * t - t
        })
        .sum();
    let total = n + m;
    let variance = n * m / 12.0 * (total + 1.0 - ties / (total * (total - 1.0)));
    if variance <= 0.0 {
        // all samples are equal
        return 1.0;
    }
    let z = ((n * m / 2.0 - u - 0.5) / variance.sqrt()).max(0.0);
    (2.0 * upper_tail(z)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn small_samples_have_the_probabilities_of_the_papers_table() {
        // U = 0 with 3 and 3: 1 of 20 orders a side
        assert!((p_value(&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0]).unwrap() - 0.1).abs() < 1e-12);
        // n = m = 5, U = 4: 12 of 252 orders have at most 4 inversions a side
        let (a, b) = ([1.0, 2.0, 3.0, 4.0, 9.0], [5.0, 6.0, 7.0, 8.0, 10.0]);
        assert!((p_value(&a, &b).unwrap() - 24.0 / 252.0).abs() < 1e-12);
        assert_eq!(p_value(&a, &b), p_value(&b, &a));
        assert_eq!(p_value(&a, &[]), None);
        assert_eq!(p_value(&[f64::NAN], &b), None);
        assert_eq!(p_value(&[2.0; 5], &[2.0; 5]), Some(1.0));
    }

    #[test]
    fn the_least_probability_is_that_of_samples_wholly_apart() {
        for (n, m) in [(3, 3), (5, 5), (15, 3)] {
            let low: Vec<f64> = (0..n).map(f64::from).collect();
            let high: Vec<f64> = (0..m).map(|x| 100.0 + f64::from(x)).collect();
            let least = least_p(n as usize, m as usize);
            assert!((p_value(&low, &high).unwrap() / least - 1.0).abs() < 1e-9, "{n} {m}");
        }
        // 2 / 252 of five a side; 2 / 924 of six
        assert_eq!([samples_needed(1, 0.05), samples_needed(7, 0.05)], [4, 6]);
    }

    #[test]
    fn the_approximation_matches_the_exact_counts() {
        for u in [127, 150, 180] {
            let exact = exact(20, 20, u);
            let a: Vec<f64> = (0..20).map(f64::from).collect();
            let b: Vec<f64> = (0..20).map(|x| f64::from(x) + 0.5).collect();
            let near = approximate(&a, &b, u as f64);
            assert!((near / exact - 1.0).abs() < 0.03, "{u}: {near} {exact}");
        }
    }

    #[test]
    fn the_test_keeps_its_error_rate_and_finds_shifts() {
        let mut random = Random::new(5, "mann-whitney");
        let mut unit = || random.next_u64() as f64 / u64::MAX as f64;
        let mut found = [0; 2];
        for _ in 0..2000 {
            let a: Vec<f64> = (0..9).map(|_| unit()).collect();
            let same: Vec<f64> = (0..9).map(|_| unit()).collect();
            let shifted: Vec<f64> = (0..9).map(|_| unit() + 0.8).collect();
            found[0] += u32::from(p_value(&a, &same).unwrap() < 0.05);
            found[1] += u32::from(p_value(&a, &shifted).unwrap() < 0.05);
        }
        assert!(found[0] < 130, "false alarms: {} of 2000", found[0]);
        assert!(found[1] > 1900, "found: {} of 2000", found[1]);
    }
}
