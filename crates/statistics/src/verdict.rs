//! Verdict on a quantity that was measured twice: faster, slower, the same, or unclear.
//!
//! One rule for rows, for means over scenes and for programs measured in turns. *The same* is what
//! a test of equivalence says: the whole interval lies within the margin (D. Schuirmann, Journal of
//! Pharmacokinetics and Biopharmaceutics 15(6), 1987; the 95% interval instead of the 90% one
//! errs on the side of *unclear*). *Slower* and *faster* need the whole interval beyond the noise,
//! and a probability, corrected for all that were tested, that says it is no chance. Whatever is
//! neither is *unclear*: noise never makes anything the same.
//!
//! Papers: W. J. Dixon, A. M. Mood, "The Statistical Sign Test", Journal of the American Statistical
//! Association 41(236), 1946: is the median of paired ratios 1? Exact; samples equal to it are left
//! out. It assumes nothing of the distribution, which with times of a busy machine is neither normal
//! nor symmetric. S. Holm, "A Simple Sequentially Rejective Multiple Test Procedure", Scandinavian
//! Journal of Statistics 6(2), 1979, as adjusted probabilities. Deviations: none.

use serde::Serialize;

use crate::estimate::{Estimate, estimate, median};
use crate::ratio_of_medians::binomial_tail;
use crate::series::{Series, geometric_mean_of_ratios_of, p_value, p_value_of_mean, ratio_of};

/// A quantity measured twice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Change {
    pub old: f64,
    pub new: f64,
    /// After over before; none where there are too few samples for an interval.
    pub ratio: Option<Estimate>,
    /// The probability of samples this unlike without a difference; see [`correct`].
    pub p: Option<f64>,
    /// Samples of the side that has fewer.
    pub samples: usize,
}

impl Change {
    /// Compares two series without common rounds; `None` if one is empty.
    pub fn of_series(old: &Series, new: &Series) -> Option<Self> {
        Some(Self {
            old: old.middle()?,
            new: new.middle()?,
            ratio: ratio_of(new, old),
            p: p_value(old, new),
            samples: old.len().min(new.len()),
        })
    }

    /// Compares geometric means over groups (scenes) of such pairs, old and new; one group is
    /// handled by [`Change::of_series`]. `None` without groups.
    pub fn of_mean(groups: &[[&Series; 2]]) -> Option<Self> {
        if let [[old, new]] = groups {
            return Self::of_series(old, new);
        }
        let turned: Vec<(&Series, &Series)> =
            groups.iter().map(|[old, new]| (*new, *old)).collect();
        let ratio = geometric_mean_of_ratios_of(&turned);
        let samples = groups.iter().flatten().map(|series| series.len()).min()?;
        let new = ratio.map_or(f64::NAN, |ratio| ratio.median);
        Some(Self { old: 1.0, new, ratio, p: p_value_of_mean(&turned), samples })
    }

    /// Compares by ratios within pairs of an old and a new value, each with its process: pairs and
    /// sign test for one process, medians of processes for several.
    pub fn of_pairs(pairs: &[(u32, [f64; 2])], seed: u64) -> Option<Self> {
        let side = |i: usize| median(&pairs.iter().map(|(_, pair)| pair[i]).collect::<Vec<_>>());
        let ratios: Series =
            pairs.iter().map(|(process, [old, new])| (*process, new / old)).collect();
        let processes = ratios.by_process().len();
        let (ratio, p, samples) = match processes {
            0 => return None,
            1 => {
                let values = ratios.values();
                (estimate(values, seed), sign_test(values, 1.0), values.len())
            }
            n => (ratios.estimate(seed), ratios.p_value_of_one(), n),
        };
        Some(Self {
            old: side(0)?,
            new: side(1)?,
            ratio: ratio.filter(|_| pairs.len() > 1),
            p,
            samples,
        })
    }
}

/// Replaces the probabilities of changes by those of a false alarm among all of them (Holm).
pub fn correct<'c>(changes: impl Iterator<Item = &'c mut Change>) {
    let mut tested: Vec<&mut f64> = changes.filter_map(|change| change.p.as_mut()).collect();
    let p: Vec<f64> = tested.iter().map(|p| **p).collect();
    for (own, adjusted) in tested.iter_mut().zip(holm_adjusted(&p)) {
        **own = adjusted;
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Faster,
    /// Certainly within the margin.
    Same,
    /// None of the others.
    Unclear,
    Slower,
}

/// Thresholds that a change must exceed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// The share by which a ratio may differ from 1 and be the same.
    pub margin: f64,
    /// The share by which two measurements of one program differ, or more: what is not wholly
    /// beyond is neither faster nor slower.
    pub noise: f64,
    /// The probability of chance from which nothing is certain.
    pub significance: f64,
}

/// Samples that are asked for at most: beyond that the ratio lies too near a limit.
const MOST_SAMPLES: f64 = 1e4;

impl Rule {
    /// Verdict on a change whose probability is corrected.
    pub fn verdict(&self, change: &Change) -> Verdict {
        let Some(Estimate { low, high, .. }) = change.ratio else { return Verdict::Unclear };
        let is_significant = change.p.is_some_and(|p| p < self.significance);
        if high <= 1.0 + self.margin && low >= 1.0 / (1.0 + self.margin) {
            Verdict::Same
        } else if low > 1.0 + self.noise && is_significant {
            Verdict::Slower
        } else if high < 1.0 / (1.0 + self.noise) && is_significant {
            Verdict::Faster
        } else {
            Verdict::Unclear
        }
    }

    /// What would decide an unclear change: a number of `units` (rounds, processes), or a quieter
    /// machine.
    pub fn missing(&self, change: &Change, units: &str) -> String {
        let Some(Estimate { median, low, high }) = change.ratio else {
            return format!("{} {units} have no interval", change.samples);
        };
        if low > 1.0 + self.noise || high < 1.0 / (1.0 + self.noise) {
            return format!(
                "p is {:.2} among all tests; more {units}, or fewer rows",
                change.p.unwrap_or(1.0)
            );
        }
        let size = median.ln().abs();
        let reach = (high / low).ln() / 2.0;
        let to_same = self.margin.ln_1p() - size;
        let needed = to_same.max(size - self.noise.ln_1p());
        let percent = |log: f64| 100.0 * log.exp_m1();
        let samples = change.samples as f64 * (reach / needed).powi(2);
        if needed <= 0.0 || samples > MOST_SAMPLES {
            return format!("too near a limit to be told (known to {:.1}%)", percent(reach));
        }
        format!(
            "known to {:.1}%, {:.1}% would decide: about {samples:.0} {units}, or a quieter machine",
            percent(reach),
            percent(needed)
        )
    }
}

/// The two-sided probability of samples at least as one-sided if their median is `median`, in
/// (0, 1]; none without samples, or with one that is NaN.
fn sign_test(samples: &[f64], median: f64) -> Option<f64> {
    if samples.is_empty() || samples.iter().any(|x| x.is_nan()) {
        return None;
    }
    let above = samples.iter().filter(|&&x| x > median).count();
    let below = samples.iter().filter(|&&x| x < median).count();
    Some((2.0 * binomial_tail(above + below, above.min(below))).min(1.0))
}

/// The probabilities of tests, adjusted: those below a level may be called significant, all of
/// them together with no more than that probability of a false alarm. In the order given.
fn holm_adjusted(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut adjusted = vec![1.0; p.len()];
    let mut largest = 0.0_f64;
    for (rank, &i) in order.iter().enumerate() {
        largest = largest.max(p[i] * (p.len() - rank) as f64).min(1.0);
        adjusted[i] = largest;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: Rule = Rule { margin: 0.05, noise: 0.0, significance: 0.05 };

    fn of(low: f64, high: f64, p: f64) -> Change {
        let ratio = Some(Estimate { median: (low * high).sqrt(), low, high });
        Change { old: 1.0, new: 1.0, ratio, p: Some(p), samples: 15 }
    }

    #[test]
    fn verdicts_follow_the_interval() {
        let verdict = |low, high| RULE.verdict(&of(low, high, 0.01));
        assert_eq!(verdict(0.96, 1.05), Verdict::Same);
        // certainly different, and certainly by less than the margin
        assert_eq!(verdict(1.01, 1.04), Verdict::Same);
        assert_eq!(verdict(1.01, 1.1), Verdict::Slower);
        assert_eq!(verdict(0.8, 0.99), Verdict::Faster);
        assert_eq!(verdict(0.9, 1.04), Verdict::Unclear);
        // planted: noise that allows 40% more is not the same
        assert_eq!(verdict(0.995, 1.4), Verdict::Unclear);
        assert_eq!(RULE.verdict(&of(1.2, 1.3, 0.06)), Verdict::Unclear);
        let noisy = Rule { noise: 0.32, ..RULE };
        assert_eq!(noisy.verdict(&of(1.2, 1.4, 0.001)), Verdict::Unclear);
        assert_eq!(noisy.verdict(&of(1.33, 1.4, 0.001)), Verdict::Slower);
        assert_eq!(noisy.verdict(&of(0.96, 1.05, 0.001)), Verdict::Same);
        let none = Change { ratio: None, ..of(1.0, 1.0, 1.0) };
        assert_eq!(RULE.verdict(&none), Verdict::Unclear);
    }

    #[test]
    fn inconclusive_results_name_the_rounds_needed() {
        let missing = |low, high, p| RULE.missing(&of(low, high, p), "rounds");
        // 10% either way is twice what tells the same from not: four times the rounds
        let text = missing(1.0 / 1.1, 1.1, 0.5);
        assert!(text.contains("10.0%, 5.0% would decide: about 57 rounds"), "{text}");
        assert!(missing(1.2, 1.3, 0.2).contains("p is 0.20"), "{}", missing(1.2, 1.3, 0.2));
        let near = Rule { noise: 0.05, ..RULE }.missing(&of(1.04, 1.06, 0.2), "rounds");
        assert!(near.contains("too near a limit"), "{near}");
    }

    #[test]
    fn probabilities_are_corrected_for_all_that_are_tested() {
        let mut all = [of(1.2, 1.3, 0.04), of(1.0, 1.1, 0.5), of(1.2, 1.3, 0.001)];
        correct(all.iter_mut());
        assert_eq!(all.map(|change| change.p.unwrap()), [0.08, 0.5, 0.003]);
    }

    #[test]
    fn the_mean_of_one_scene_is_judged_like_its_row() {
        let series = |values: &[f64]| Series::from(values.to_vec());
        let (old, new) = (series(&[1.0, 1.1, 0.9, 1.0]), series(&[1.3, 1.2, 1.4, 1.3]));
        let row = Change::of_series(&old, &new);
        assert_eq!(Change::of_mean(&[[&old, &new]]), row);
        let both = Change::of_mean(&[[&old, &new], [&old, &new]]).unwrap();
        assert!(both.ratio.unwrap().low > row.unwrap().ratio.unwrap().low);
        assert!(both.p.unwrap() < 0.01);
        assert_eq!(Change::of_mean(&[]), None);
    }

    #[test]
    fn pairs_of_several_processes_are_judged_by_their_medians() {
        let pairs = |process: u32, factor: f64| {
            [0.5, 1.0, 2.0].map(move |load| (process, [load, load * factor])).into_iter()
        };
        let one: Vec<_> = pairs(0, 1.1).collect();
        let alone = Change::of_pairs(&one, 1).unwrap();
        assert!((alone.ratio.unwrap().median - 1.1).abs() < 1e-9 && alone.samples == 3);
        let three: Vec<_> = pairs(0, 1.1).chain(pairs(1, 1.2)).chain(pairs(2, 1.0)).collect();
        let change = Change::of_pairs(&three, 1).unwrap();
        assert!(change.samples == 3 && change.ratio.unwrap().holds(1.0), "{change:?}");
        assert!(change.p.unwrap() > 0.1);
        assert_eq!(Change::of_pairs(&[], 1), None);
    }

    #[test]
    fn probabilities_of_signs_are_known() {
        let p = |x: &[f64]| sign_test(x, 1.0).unwrap();
        assert!((p(&[1.1; 6]) - 2.0 / 64.0).abs() < 1e-12);
        assert!((p(&[1.1, 1.2, 1.3, 1.4, 0.9]) - 12.0 / 32.0).abs() < 1e-12);
        assert_eq!(p(&[1.1, 0.9]), 1.0);
        assert_eq!(p(&[1.0; 4]), 1.0);
        assert_eq!(sign_test(&[], 1.0), None);
        assert_eq!(sign_test(&[f64::NAN], 1.0), None);
    }

    #[test]
    fn adjusted_probabilities_are_known() {
        assert_eq!(holm_adjusted(&[]), Vec::<f64>::new());
        assert_eq!(holm_adjusted(&[0.04]), [0.04]);
        // 0.01 * 3; 0.02 * 2 = 0.04; 0.03 * 1 = 0.03, but no less than the one before
        assert_eq!(holm_adjusted(&[0.03, 0.01, 0.02]), [0.04, 0.03, 0.04]);
        assert_eq!(holm_adjusted(&[0.9, 0.8]), [1.0, 1.0]);
    }
}
