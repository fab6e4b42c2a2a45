//! Geometric means of the ratios over all scenes, judged as rows are.

use serde::Serialize;

use crate::comparison::entry::{ComparisonOutcome, ComparisonSettings, exact_ratio};
use crate::comparison::pairing::RowPair;
use measurement::record::RowRecord;
use measurement::record::metrics::Metric;
use statistics::estimate::{Estimate, geometric_mean};
use statistics::series::Series;
use statistics::verdict::{Change, Rule, correct};

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
