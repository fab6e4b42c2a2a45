//! All scenes together: geometric means of ratios, over the scenes whose ratios are to one row.

use std::collections::{BTreeMap, BTreeSet};

use crate::record::metrics::{build_ratios, kind_ratios, trace_ratios};
use crate::record::query::Query;
use crate::record::{RowRecord, SceneRecord, Settings, SummaryRow, Verdict, reference};
use statistics::series::{Series, geometric_mean_of};

/// One row for each row of the scenes, in their order; a part of a run may have rows in some of its
/// scenes only. Means leave out scenes whose ratios are to another row than
/// [`reference::of_means`]; verdicts are over all.
pub fn summarize(scenes: &[SceneRecord], settings: &Settings) -> Vec<SummaryRow> {
    let reference = reference::of_means(scenes, &settings.reference);
    // the first row of each setting, and all that are the same, one per scene
    let mut groups: Vec<(&RowRecord, Vec<RowInScene<'_>>)> = Vec::new();
    let mut places: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for scene in scenes {
        let is_over = reference::is_over(scene, &reference);
        let mut seen = BTreeSet::new();
        for row in &scene.rows {
            let key = (&*row.structure, &*row.settings);
            let place = *places.entry(key).or_insert_with(|| {
                groups.push((row, Vec::new()));
                groups.len() - 1
            });
            if seen.insert(key)
                && let Some((_, rows)) = groups.get_mut(place)
            {
                rows.push(RowInScene { scene, row, is_over });
            }
        }
    }
    groups.into_iter().map(|(row, rows)| summarize_row(row, &rows, settings.seed)).collect()
}

/// A row in one of its scenes.
struct RowInScene<'a> {
    scene: &'a SceneRecord,
    row: &'a RowRecord,
    /// The scene's ratios count.
    is_over: bool,
}

fn summarize_row(row: &RowRecord, rows: &[RowInScene<'_>], seed: u64) -> SummaryRow {
    let mut ratios = Vec::new();
    let mut builds = Vec::new();
    let mut kinds: BTreeMap<&str, Vec<Series>> = BTreeMap::new();
    let mut batch_scenes = 0;
    let mut verdicts = Vec::new();
    let mut mismatches = 0;
    for &RowInScene { scene, row: own, is_over } in rows {
        verdicts.push(own.verdict);
        mismatches += own.mismatches;
        let trace = trace_ratios(own);
        if !trace.is_empty() && is_over {
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
    let mean = |groups: &[Series]| geometric_mean_of(groups, seed);
    let of_kind = |(kind, groups): (&&str, &Vec<_>)| Some(((*kind).to_owned(), mean(groups)?));
    let count = |v: Verdict| verdicts.iter().filter(|x| **x == v).count() as u64;
    let (wrong, shipped) = (count(Verdict::Wrong), count(Verdict::WrongAsShipped));
    let (panicked, memory) = (count(Verdict::Panicked), count(Verdict::OutOfMemory));
    let not_built = verdicts.iter().filter(|v| !v.is_judged()).count() as u64;
    SummaryRow {
        structure: row.structure.clone(),
        settings: row.settings.clone(),
        scenes: ratios.len() as u64,
        wrong_scenes: wrong + shipped,
        not_built_scenes: not_built,
        mismatches,
        answers: row.answers,
        ratio: mean(&ratios),
        ratio_by_kind: kinds.iter().filter_map(of_kind).collect(),
        batch_scenes,
        build_ratio: mean(&builds),
        verdict: if wrong > 0 {
            Verdict::Wrong
        } else if panicked > 0 {
            Verdict::Panicked
        } else if not_built > 0 && memory == not_built {
            Verdict::OutOfMemory
        } else if not_built > 0 {
            Verdict::NotBuilt
        } else if shipped > 0 {
            Verdict::WrongAsShipped
        } else {
            Verdict::Ok
        },
    }
}
