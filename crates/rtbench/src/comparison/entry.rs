//! One metric of one row in two runs, and its geometric mean over all scenes, judged as rows are.

use crate::comparison::pairing::RowPair;
use measurement::record::metrics::Metric;
use measurement::record::{RowRecord, RunRecord, label};
use regex_lite::Regex;
use serde::Serialize;
use statistics::estimate::{Estimate, geometric_mean};
use statistics::series::Series;
use statistics::verdict::{Change, Rule, Verdict, correct};

/// The probability of one false alarm in a comparison.
pub const SIGNIFICANCE: f64 = 0.05;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ComparisonOutcome {
    Equal,
    /// Exact: less than before.
    Less,
    /// Exact: more than before.
    More,
    /// Measured: certainly within the equivalence margin.
    NoDifference,
    /// Measured: none of the others.
    Inconclusive,
    Faster,
    Slower,
    /// Measured: too few rounds for an interval.
    TooFewRounds,
}

impl ComparisonOutcome {
    pub fn of_exact(old: f64, new: f64) -> Self {
        match new.total_cmp(&old) {
            std::cmp::Ordering::Less => Self::Less,
            std::cmp::Ordering::Equal => Self::Equal,
            std::cmp::Ordering::Greater => Self::More,
        }
    }

    /// Outcome for a measured metric, whose probability is corrected.
    pub fn of_measured(change: &Change, rule: &Rule) -> Self {
        match rule.verdict(change) {
            _ if change.ratio.is_none() => Self::TooFewRounds,
            Verdict::Same => Self::NoDifference,
            Verdict::Unclear => Self::Inconclusive,
            Verdict::Faster => Self::Faster,
            Verdict::Slower => Self::Slower,
        }
    }

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

    pub fn is_exact(self) -> bool {
        matches!(self, Self::Equal | Self::Less | Self::More)
    }

    /// Something changed, as far as can be told.
    pub fn is_change(self) -> bool {
        matches!(self, Self::Less | Self::More | Self::Faster | Self::Slower)
    }
}

/// A metric of a row of a scene, before and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    pub structure: String,
    /// Settings that differ from the defaults.
    pub settings: String,
    pub metric: &'static str,
    pub unit: &'static str,
    /// Values or medians, their ratio (of exact metrics without width), the probability of chance.
    #[serde(flatten)]
    pub change: Change,
    pub outcome: ComparisonOutcome,
}

impl Entry {
    /// Compares; none where one of the rows has no such metric. Of measured ones the outcome is
    /// known when all are there, see [`Entry::decide`].
    pub fn of(metric: &Metric, pair: &RowPair<'_>) -> Option<Self> {
        let [before, after] = [0, 1].map(|i| metric.values(pair.scenes[i], pair.rows[i]));
        let (change, outcome) = if metric.is_exact() {
            let (old, new) = (before.middle()?, after.middle()?);
            let change = Change { old, new, ratio: exact_ratio(old, new), p: None, samples: 1 };
            (change, ComparisonOutcome::of_exact(old, new))
        } else {
            (Change::of_series(&before, &after)?, ComparisonOutcome::Inconclusive)
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

    /// Returns whether it has rounds, and no exact value.
    pub fn is_measured(&self) -> bool {
        !self.outcome.is_exact()
    }

    /// Decides a measured metric, whose probability is corrected.
    pub fn decide(&mut self, rule: &Rule) {
        if self.is_measured() {
            self.outcome = ComparisonOutcome::of_measured(&self.change, rule);
        }
    }

    pub fn label(&self) -> String {
        label(&self.structure, &self.settings)
    }
}

/// A metric of a row over all scenes: the geometric mean of the ratios.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mean {
    pub structure: String,
    /// Settings that differ from the defaults.
    pub settings: String,
    pub metric: &'static str,
    pub scenes: u64,
    pub ratio: Option<Estimate>,
    /// The probability of chance, corrected for all means; none of exact metrics.
    pub p: Option<f64>,
    pub outcome: ComparisonOutcome,
}

/// Geometric means over the scenes, by row and metric, of what is compared.
pub fn means(
    compared: &[(&'static Metric, RowPair<'_>)],
    metrics: &[&'static Metric],
    choice: &ComparisonSettings,
    rule: &Rule,
) -> Vec<Mean> {
    let mut rows: Vec<&RowRecord> = Vec::new();
    for (_, RowPair { rows: [_, row], .. }) in compared {
        if !rows.iter().any(|r| r.is_same(row)) {
            rows.push(row);
        }
    }
    // exact ones are decided at once, changes when all are there
    let mut found: Vec<(Mean, Option<Change>)> = Vec::new();
    for row in rows {
        let of_row: Vec<_> =
            compared.iter().filter(|(_, pair)| pair.rows[1].is_same(row)).collect();
        for metric in metrics {
            let own = of_row.iter().filter(|(own, _)| own.name == metric.name);
            found.extend(mean(metric, row, own.map(|(_, pair)| pair)));
        }
    }
    correct(found.iter_mut().filter_map(|(_, change)| change.as_mut()));
    let decided = found.into_iter().map(|(mean, change)| match change {
        None => mean,
        Some(change) => Mean {
            outcome: ComparisonOutcome::of_measured(&change, rule),
            ratio: change.ratio,
            p: change.p,
            ..mean
        },
    });
    decided.filter(|mean| choice.shows(mean.ratio, mean.outcome)).collect()
}

/// The geometric mean of a row's ratios; none where no scene has one.
fn mean<'p, 'r: 'p>(
    metric: &Metric,
    row: &RowRecord,
    pairs: impl Iterator<Item = &'p RowPair<'r>>,
) -> Option<(Mean, Option<Change>)> {
    let values: Vec<[Series; 2]> = pairs
        .map(|RowPair { scenes, rows }| [0, 1].map(|i| metric.values(scenes[i], rows[i])))
        .filter(|sides| sides.iter().all(|values| !values.is_empty()))
        .collect();
    let mean = |ratio, outcome| Mean {
        structure: row.structure.clone(),
        settings: row.settings.clone(),
        metric: metric.name,
        scenes: values.len() as u64,
        ratio,
        p: None,
        outcome,
    };
    if values.is_empty() {
        return None;
    }
    if !metric.is_exact() {
        let groups: Vec<[&Series; 2]> = values.iter().map(|[old, new]| [old, new]).collect();
        let mean = mean(None, ComparisonOutcome::Inconclusive);
        return Some((mean, Some(Change::of_mean(&groups)?)));
    }
    let first = |side: &Series| side.values().first().copied();
    let all: Option<Vec<(f64, f64)>> =
        values.iter().map(|[old, new]| Some((first(old)?, first(new)?))).collect();
    let all = all?;
    let ratios = all.iter().map(|&(old, new)| Some(exact_ratio(old, new)?.median));
    let ratio = ratios.collect::<Option<Vec<f64>>>().and_then(|ratios| geometric_mean(&ratios));
    let outcome = match ratio {
        _ if all.iter().all(|(old, new)| old == new) => ComparisonOutcome::Equal,
        Some(ratio) => ComparisonOutcome::of_exact(1.0, ratio),
        None => return None,
    };
    Some((mean(ratio.and_then(|ratio| exact_ratio(1.0, ratio)), outcome), None))
}

/// A change beyond that share of the smaller value; what rose from nothing is beyond any.
pub fn exceeds(ratio: Option<Estimate>, outcome: ComparisonOutcome, share: f64) -> bool {
    let size = ratio.map_or(f64::INFINITY, |r| r.median.max(1.0 / r.median) - 1.0);
    outcome.is_change() && size > share
}

/// The ratio of two exact values, an interval without width; none where it has no meaning.
pub fn exact_ratio(old: f64, new: f64) -> Option<Estimate> {
    let ratio = if old == new { 1.0 } else { new / old };
    ratio.is_finite().then(|| Estimate::exactly(ratio))
}

/// Records to compare, and the parts to show.
#[derive(Debug)]
pub struct ComparisonSettings {
    pub metrics: Vec<&'static Metric>,
    /// Exact metrics that are equal are shown, not only counted.
    pub shows_equal: bool,
    pub filter: Option<Regex>,
    /// The share by which a ratio may differ from 1 and be called no difference.
    pub margin: f64,
    /// The share of change that is shown from.
    pub threshold: Option<f64>,
    pub is_forced: bool,
}

impl ComparisonSettings {
    /// Returns whether the filter, if there is one, finds a metric of a row.
    pub fn finds(&self, scene: &str, label: &str, metric: &str) -> bool {
        let found = |filter: &Regex| filter.is_match(&format!("{scene}/{label}/{metric}"));
        self.filter.as_ref().is_none_or(found)
    }

    /// Returns whether what came of a comparison is shown.
    pub fn shows(&self, ratio: Option<Estimate>, outcome: ComparisonOutcome) -> bool {
        (outcome != ComparisonOutcome::Equal || self.shows_equal)
            && self.threshold.is_none_or(|share| exceeds(ratio, outcome, share))
    }
}

/// A run with the name it is given in tables.
#[derive(Debug, Clone, Copy)]
pub struct NamedRun<'r> {
    /// `A`, `B`, ...
    pub letter: &'r str,
    pub path: &'r str,
    pub run: &'r RunRecord,
}

#[cfg(test)]
mod tests {
    use super::ComparisonOutcome::*;
    use super::*;

    #[test]
    fn exact_metrics_have_no_tolerance() {
        assert_eq!(ComparisonOutcome::of_exact(2.0, 1.0), Less);
        assert_eq!(ComparisonOutcome::of_exact(1.0, 2.0), More);
        assert_eq!(ComparisonOutcome::of_exact(1.0, 1.0), Equal);
    }

    #[test]
    fn thresholds_hold_in_both_directions() {
        let by = |ratio: f64, outcome| exceeds(exact_ratio(1.0, ratio), outcome, 0.05);
        assert!(by(1.06, Slower) && !by(1.04, Slower));
        assert!(by(0.94, Faster) && !by(0.96, Faster));
        assert!(!by(1.5, NoDifference) && !by(1.5, TooFewRounds));
        assert!(exceeds(exact_ratio(0.0, 3.0), More, 1e9));
        assert_eq!(exact_ratio(0.0, 0.0).map(|r| r.median), Some(1.0));
    }
}
