//! Geometric means of the ratios over all scenes.

use serde::Serialize;

use crate::comparison::choice::{Choice, Pair};
use crate::comparison::differences::other_reference;
use crate::comparison::entry::{Outcome, exact_ratio, exceeds};
use measurement::record::RowRecord;
use measurement::record::metrics::Metric;
use statistics::estimate::{Estimate, geometric_mean};
use statistics::series::{Series, geometric_mean_of_ratios_of};

/// A metric of a row over all scenes: the geometric mean of the ratios.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mean {
    /// Structure.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// The metric's name.
    pub metric: &'static str,
    /// Scenes it is over.
    pub scenes: u64,
    /// After over before.
    pub ratio: Option<Estimate>,
    /// What comes of it.
    pub outcome: Outcome,
}

/// Geometric means over the scenes, by row and metric.
pub fn means(pairs: &[Pair<'_>], metrics: &[&'static Metric], choice: &Choice) -> Vec<Mean> {
    let mut shown = Vec::new();
    let mut rows: Vec<&RowRecord> = Vec::new();
    for (_, [_, row]) in pairs {
        if !rows.iter().any(|r| r.is_same(row)) {
            rows.push(row);
        }
    }
    for row in rows {
        for metric in metrics {
            let of_row = pairs.iter().filter(|(scenes, rows)| {
                let [old, new] = rows;
                let is_own = metric.is_to_reference() && old.is_reference && new.is_reference;
                let has_ratios = choice.is_forced || other_reference(*scenes).is_none();
                new.is_same(row)
                    && !is_own
                    && (has_ratios || !metric.is_to_reference())
                    && (choice.is_forced || metric.rays(old) == metric.rays(new))
                    && choice.finds(&scenes[0].name, &row.label(), metric.name)
            });
            let Some(mean) = mean(metric, row, of_row, choice.margin) else { continue };
            let is_hidden = (mean.outcome == Outcome::Equal && !choice.shows_equal)
                || choice.threshold.is_some_and(|t| !exceeds(mean.ratio, mean.outcome, t));
            if !is_hidden {
                shown.push(mean);
            }
        }
    }
    shown
}

/// The geometric mean of a row's ratios; none where no scene has one.
fn mean<'p, 'r: 'p>(
    metric: &Metric,
    row: &RowRecord,
    pairs: impl Iterator<Item = &'p Pair<'r>>,
    margin: f64,
) -> Option<Mean> {
    let values: Vec<[Series; 2]> = pairs
        .map(|(scenes, rows)| [0, 1].map(|i| metric.values(scenes[i], rows[i])))
        .filter(|sides| sides.iter().all(|values| !values.is_empty()))
        .collect();
    let scenes = values.len() as u64;
    let (ratio, outcome) = if metric.is_exact() {
        let first = |side: &Series| side.values().first().copied();
        let all = values.iter().map(|[old, new]| Some((first(old)?, first(new)?)));
        let all: Vec<(f64, f64)> = all.collect::<Option<_>>()?;
        let ratios = all.iter().map(|&(old, new)| Some(exact_ratio(old, new)?.median));
        let ratios: Option<Vec<f64>> = ratios.collect();
        let mean = ratios.and_then(|ratios| geometric_mean(&ratios));
        let is_equal = all.iter().all(|(old, new)| old == new);
        let outcome = match mean {
            _ if is_equal => Outcome::Equal,
            Some(mean) => Outcome::of_exact(1.0, mean),
            None => return None,
        };
        (mean.and_then(|mean| exact_ratio(1.0, mean)), outcome)
    } else {
        let groups: Vec<(&Series, &Series)> = values.iter().map(|[old, new]| (new, old)).collect();
        let ratio = geometric_mean_of_ratios_of(&groups);
        (ratio, Outcome::of_measured(ratio, None, margin))
    };
    let (structure, settings) = (row.structure.clone(), row.settings.clone());
    (scenes > 0).then_some(Mean {
        structure,
        settings,
        metric: metric.name,
        scenes,
        ratio,
        outcome,
    })
}
