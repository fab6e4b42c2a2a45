//! All scenes together: geometric means of ratios, over the scenes whose ratios are to one row.

use std::collections::BTreeMap;

use crate::record::query::Query;
use crate::record::ratios::{build_ratios, kind_ratios, trace_ratios};
use crate::record::reference;
use crate::record::{RowRecord, SceneRecord, Settings, SummaryRow, Verdict};
use statistics::estimate::geometric_mean_of_medians;

/// One row for each row of the scenes, in their order; a part of a run may have rows in some of its
/// scenes only. Means leave out scenes whose ratios are to another row than
/// [`reference::of_means`]; verdicts are over all.
pub fn summarize(scenes: &[SceneRecord], settings: &Settings) -> Vec<SummaryRow> {
    let mut rows: Vec<&RowRecord> = Vec::new();
    for row in scenes.iter().flat_map(|scene| &scene.rows) {
        if !rows.iter().any(|r| r.is_same(row)) {
            rows.push(row);
        }
    }
    let reference = reference::of_means(scenes, &settings.reference);
    rows.into_iter().map(|row| summarize_row(row, scenes, &reference, settings.seed)).collect()
}

fn summarize_row(
    row: &RowRecord,
    scenes: &[SceneRecord],
    reference: &str,
    seed: u64,
) -> SummaryRow {
    let mut ratios = Vec::new();
    let mut builds = Vec::new();
    let mut kinds: BTreeMap<&str, Vec<Vec<f64>>> = BTreeMap::new();
    let mut batch_scenes = 0;
    let mut verdicts = Vec::new();
    let mut mismatches = 0;
    for scene in scenes {
        let Some(own) = scene.rows.iter().find(|r| r.is_same(row)) else { continue };
        verdicts.push(own.verdict);
        mismatches += own.mismatches;
        let trace = trace_ratios(own);
        if !trace.is_empty() && reference::is_over(scene, reference) {
            builds.push(build_ratios(scene, own));
            ratios.push(trace);
            batch_scenes += u64::from(own.query == Query::Batch);
            for kind in own.rays_by_kind.keys() {
                let of_kind = kind_ratios(own, kind);
                if !of_kind.is_empty() {
                    kinds.entry(kind).or_default().push(of_kind);
                }
            }
        }
    }
    let mean = |groups: &[Vec<f64>]| {
        let groups: Vec<&[f64]> = groups.iter().map(Vec::as_slice).collect();
        if groups.is_empty() { None } else { geometric_mean_of_medians(&groups, seed) }
    };
    let count = |v: Verdict| verdicts.iter().filter(|x| **x == v).count() as u64;
    let (wrong, shipped) = (count(Verdict::Wrong), count(Verdict::WrongAsShipped));
    let panicked = count(Verdict::Panicked);
    let not_built = count(Verdict::NotBuilt) + panicked + count(Verdict::OverLimit);
    SummaryRow {
        structure: row.structure.clone(),
        settings: row.settings.clone(),
        scenes: ratios.len() as u64,
        wrong_scenes: wrong + shipped,
        not_built_scenes: not_built,
        mismatches,
        answers: row.answers,
        ratio: mean(&ratios),
        ratio_by_kind: kinds
            .iter()
            .filter_map(|(kind, groups)| Some(((*kind).to_owned(), mean(groups)?)))
            .collect(),
        batch_scenes,
        build_ratio: mean(&builds),
        verdict: match () {
            () if wrong > 0 => Verdict::Wrong,
            () if panicked > 0 => Verdict::Panicked,
            () if not_built > 0 => Verdict::NotBuilt,
            () if shipped > 0 => Verdict::WrongAsShipped,
            () => Verdict::Ok,
        },
    }
}
