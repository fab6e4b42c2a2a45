//! One metric of one row in two runs.

use serde::Serialize;

use crate::comparison::pairing::RowPair;
use measurement::record::label;
use measurement::record::metrics::Metric;
use statistics::estimate::Estimate;
use statistics::verdict::{Change, Rule, Verdict};

/// The probability of one false alarm in a comparison.
pub const SIGNIFICANCE: f64 = 0.05;

/// The equivalence margin where none is asked for. Smaller differences are those of where code and memory
/// happen to lie, and what `check` lets pass.
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
    /// Measured: certainly within the equivalence margin.
    NoDifference,
    /// Measured: none of the others.
    Inconclusive,
    /// Measured: certainly less.
    Faster,
    /// Measured: certainly more.
    Slower,
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

    /// Of a measured one, whose probability is corrected.
    pub fn of_measured(change: &Change, rule: &Rule) -> Self {
        match rule.verdict(change) {
            _ if change.ratio.is_none() => Self::TooFewRounds,
            Verdict::Same => Self::NoDifference,
            Verdict::Unclear => Self::Inconclusive,
            Verdict::Faster => Self::Faster,
            Verdict::Slower => Self::Slower,
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
    /// Values or medians, their ratio (of exact metrics without width), the probability of chance.
    #[serde(flatten)]
    pub change: Change,
    /// What comes of it.
    pub outcome: Outcome,
}

impl Entry {
    /// Compares; none where one of the rows has no such metric. Of measured ones the outcome is known when
    /// all are there, see [`Entry::decide`].
    pub fn of(metric: &Metric, pair: &RowPair<'_>) -> Option<Self> {
        let [before, after] = [0, 1].map(|i| metric.values(pair.scenes[i], pair.rows[i]));
        let (change, outcome) = if metric.is_exact() {
            let (old, new) = (before.middle()?, after.middle()?);
            let change = Change { old, new, ratio: exact_ratio(old, new), p: None, samples: 1 };
            (change, Outcome::of_exact(old, new))
        } else {
            (Change::of_series(&before, &after)?, Outcome::Inconclusive)
        };
        let [_, row] = pair.rows;
        Some(Self {
            structure: row.structure.clone(),
            settings: row.settings.clone(),
            metric: metric.name,
            unit: metric.unit,
            change,
            outcome,
        })
    }

    /// Whether it has rounds, and no exact value.
    pub fn is_measured(&self) -> bool {
        !matches!(self.outcome, Outcome::Equal | Outcome::Less | Outcome::More)
    }

    /// Decides a measured metric, whose probability is corrected.
    pub fn decide(&mut self, rule: &Rule) {
        if self.is_measured() {
            self.outcome = Outcome::of_measured(&self.change, rule);
        }
    }

    /// Structure and settings.
    pub fn label(&self) -> String {
        label(&self.structure, &self.settings)
    }
}

/// By how much the larger of both is more than the smaller, as a share; of what rose from nothing
/// infinite.
pub fn size_of(ratio: Option<Estimate>) -> f64 {
    ratio.map_or(f64::INFINITY, |r| r.median.max(1.0 / r.median) - 1.0)
}

/// A change beyond that share.
pub fn exceeds(ratio: Option<Estimate>, outcome: Outcome, share: f64) -> bool {
    outcome.is_change() && size_of(ratio) > share
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
    fn exact_metrics_have_no_tolerance() {
        assert_eq!(Outcome::of_exact(2.0, 1.0), Outcome::Less);
        assert_eq!(Outcome::of_exact(1.0, 2.0), Outcome::More);
        assert_eq!(Outcome::of_exact(1.0, 1.0), Outcome::Equal);
    }

    #[test]
    fn a_threshold_holds_in_both_directions() {
        let by = |ratio: f64, outcome| exceeds(exact_ratio(1.0, ratio), outcome, 0.05);
        assert!(by(1.06, Outcome::Slower) && !by(1.04, Outcome::Slower));
        assert!(by(0.94, Outcome::Faster) && !by(0.96, Outcome::Faster));
        assert!(!by(1.5, Outcome::NoDifference) && !by(1.5, Outcome::TooFewRounds));
        assert!(exceeds(exact_ratio(0.0, 3.0), Outcome::More, 1e9));
        assert_eq!(exact_ratio(0.0, 0.0).map(|r| r.median), Some(1.0));
    }
}
