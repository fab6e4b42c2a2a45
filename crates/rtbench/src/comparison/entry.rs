//! One metric of one row in two runs.

use serde::Serialize;

use measurement::record::metrics::Metric;
use measurement::record::{RowRecord, SceneRecord, label};
use statistics::estimate::Estimate;
use statistics::series::{p_value, ratio_of};

/// Probability of chance from which a difference is not called one.
const SIGNIFICANT: f64 = 0.05;

/// The equivalence margin where none is asked for: a ratio is called no difference where its whole interval
/// lies within 1 / 1.05 to 1.05. Smaller differences are those of where code and memory happen to lie, and
/// what `check` lets pass. The 95% interval in the place of the 90% one of two one-sided tests (D. Schuirmann,
/// Journal of Pharmacokinetics and Biopharmaceutics 15(6), 1987) errs on the side of `inconclusive`.
pub const MARGIN: f64 = 0.05;

/// What comes of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Exact: the same.
    Equal,
    /// Exact: less than before.
    Less,
    /// Exact: more than before.
    More,
    /// Measured: the interval of the ratio contains 1 and lies within the equivalence margin.
    NoDifference,
    /// Measured: the interval contains 1, and differences beyond the margin.
    Inconclusive,
    /// Measured: the whole interval is below 1.
    Faster,
    /// Measured: the whole interval is above 1.
    Slower,
    /// Measured: the interval leaves out 1, but the test does not reject chance. So it is of rounds
    /// that lie in two heaps, as beside other programs, and of fewer than four, which reject nothing.
    Unclear,
    /// Measured: too few rounds for an interval.
    TooFewRounds,
}

impl Outcome {
    /// Of an exact metric.
    pub fn of_exact(old: f64, new: f64) -> Self {
        match new.total_cmp(&old) {
            std::cmp::Ordering::Less => Self::Less,
            std::cmp::Ordering::Equal => Self::Equal,
            std::cmp::Ordering::Greater => Self::More,
        }
    }

    /// Of a measured one, with the probability of chance where it was tested, and the share by which
    /// a ratio may differ from 1 and be none the less called no difference.
    pub fn of_measured(ratio: Option<Estimate>, p: Option<f64>, margin: f64) -> Self {
        let is_within = |r: Estimate| r.high <= 1.0 + margin && r.low >= 1.0 / (1.0 + margin);
        match ratio {
            None => Self::TooFewRounds,
            Some(ratio) if ratio.holds(1.0) && is_within(ratio) => Self::NoDifference,
            Some(ratio) if ratio.holds(1.0) => Self::Inconclusive,
            Some(_) if p.is_some_and(|p| p >= SIGNIFICANT) => Self::Unclear,
            Some(ratio) if ratio.median < 1.0 => Self::Faster,
            Some(_) => Self::Slower,
        }
    }

    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Less => "less",
            Self::More => "more",
            Self::NoDifference => "no difference",
            Self::Inconclusive => "inconclusive",
            Self::Faster => "faster",
            Self::Slower => "slower",
            Self::Unclear => "unclear",
            Self::TooFewRounds => "too few rounds",
        }
    }

    /// Something changed, as far as can be told.
    pub fn is_change(self) -> bool {
        matches!(self, Self::Less | Self::More | Self::Faster | Self::Slower)
    }
}

/// A metric of a row of a scene, before and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// Structure.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// The metric's name.
    pub metric: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The value, or the median of the rounds, before.
    pub old: f64,
    /// The same after.
    pub new: f64,
    /// After over before; of exact metrics without width, none where the old one is 0.
    pub ratio: Option<Estimate>,
    /// The probability of samples this unlike by chance, see [`p_value`]; none of exact metrics.
    pub p: Option<f64>,
    /// What comes of it.
    pub outcome: Outcome,
}

impl Entry {
    /// Compares; none where one of the rows has no such metric.
    pub fn of(
        metric: &Metric,
        [old_scene, new_scene]: [&SceneRecord; 2],
        [old_row, new_row]: [&RowRecord; 2],
        margin: f64,
    ) -> Option<Self> {
        let before = metric.values(old_scene, old_row);
        let after = metric.values(new_scene, new_row);
        let (old, new) = (before.middle()?, after.middle()?);
        let (ratio, p, outcome) = if metric.is_exact() {
            (exact_ratio(old, new), None, Outcome::of_exact(old, new))
        } else {
            let ratio = ratio_of(&after, &before);
            let p = p_value(&before, &after);
            (ratio, p, Outcome::of_measured(ratio, p, margin))
        };
        Some(Self {
            structure: new_row.structure.clone(),
            settings: new_row.settings.clone(),
            metric: metric.name,
            unit: metric.unit,
            old,
            new,
            ratio,
            p,
            outcome,
        })
    }

    /// Structure and settings.
    pub fn label(&self) -> String {
        label(&self.structure, &self.settings)
    }

    /// It changed by more than this many percent: the larger of both is that much more than the
    /// smaller one.
    pub fn changed_by_more(&self, percent: f64) -> bool {
        exceeds(self.ratio, self.outcome, percent)
    }
}

/// A change beyond that many percent; what rose from nothing is beyond all.
pub fn exceeds(ratio: Option<Estimate>, outcome: Outcome, percent: f64) -> bool {
    let factor = ratio.map_or(f64::INFINITY, |r| r.median.max(1.0 / r.median));
    outcome.is_change() && factor - 1.0 > percent / 100.0
}

/// The ratio of two exact values, an interval without width; none where it has no meaning.
pub fn exact_ratio(old: f64, new: f64) -> Option<Estimate> {
    let ratio = if old == new { 1.0 } else { new / old };
    (ratio.is_finite()).then_some(Estimate { median: ratio, low: ratio, high: ratio })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outcomes_say_what_the_interval_says() {
        let of = |low, high| {
            let ratio = Estimate { median: f64::midpoint(low, high), low, high };
            let untested = Outcome::of_measured(Some(ratio), None, MARGIN);
            assert_eq!(untested, Outcome::of_measured(Some(ratio), Some(0.04), MARGIN));
            let unclear = Outcome::of_measured(Some(ratio), Some(0.06), MARGIN);
            assert_eq!(unclear == Outcome::Unclear, !ratio.holds(1.0));
            untested
        };
        assert_eq!(of(0.96, 1.04), Outcome::NoDifference);
        assert_eq!(of(1.0, 1.05), Outcome::NoDifference);
        assert_eq!(of(0.9, 1.04), Outcome::Inconclusive);
        assert_eq!(of(0.995, 24.4), Outcome::Inconclusive);
        assert_eq!(of(1.01, 1.1), Outcome::Slower);
        assert_eq!(of(0.8, 0.99), Outcome::Faster);
        assert_eq!(Outcome::of_measured(None, None, MARGIN), Outcome::TooFewRounds);
        assert_eq!(Outcome::of_exact(2.0, 1.0), Outcome::Less);
        assert_eq!(Outcome::of_exact(1.0, 2.0), Outcome::More);
        assert_eq!(Outcome::of_exact(1.0, 1.0), Outcome::Equal);
    }

    #[test]
    fn a_threshold_holds_in_both_directions() {
        let by = |ratio: f64, outcome| exceeds(exact_ratio(1.0, ratio), outcome, 5.0);
        assert!(by(1.06, Outcome::Slower) && !by(1.04, Outcome::Slower));
        assert!(by(0.94, Outcome::Faster) && !by(0.96, Outcome::Faster));
        assert!(!by(1.5, Outcome::NoDifference) && !by(1.5, Outcome::TooFewRounds));
        assert!(exceeds(exact_ratio(0.0, 3.0), Outcome::More, 1e9));
        assert_eq!(exact_ratio(0.0, 0.0).map(|r| r.median), Some(1.0));
    }
}
