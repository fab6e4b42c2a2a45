//! Recommends a row: by frames per second, and by rays per frame.

use presentation::numbers;
use statistics::estimate::Estimate;

use crate::animate::record::{AnimationRecord, LaneRecord, RankedLane, Totals};
use crate::run::costs::{Cost, envelope};

/// A row that is right, and what it takes.
type TimedLane<'a> = (&'a LaneRecord, &'a Totals);

/// In words, a line each, for a number of threads and its rows, the one with the most frames per
/// second first.
pub fn lines(run: &AnimationRecord, lanes: &[RankedLane<'_>], threads: usize) -> Vec<String> {
    let is_right = |of: &&RankedLane<'_>| of.lane.mismatches == 0 && of.totals.is_some();
    let right = || lanes.iter().filter(is_right);
    let rows: Vec<TimedLane<'_>> =
        right().filter_map(|of| Some((of.lane, of.totals.as_ref()?))).collect();
    let best = right().next().and_then(|of| of.rate);
    let (Some(best), Some(rate)) = (rows.first(), best) else { return Vec::new() };
    let threads_of = if threads == 1 { "1 thread".into() } else { format!("{threads} threads") };
    let mut lines = vec![format!(
        "With {threads_of}, {} has the most frames per second: {} at {} rays per frame.",
        best.0.label(),
        numbers::interval(&rate),
        best.1.rays.round()
    )];
    lines.extend(by_rays(&rows));
    lines.extend(grid_and_bvh(run, &rows));
    lines
}

/// Rays a frame that are looked at: from few to those of a large image with many bounces.
const RAYS: [f64; 2] = [1.0, 1e9];

/// Fastest rows by number of rays per frame. Rows that defer a part of their build to the first
/// rays are left out: their time per ray does not apply to fewer rays.
fn by_rays(rows: &[TimedLane<'_>]) -> Option<String> {
    let is_line = |(lane, _): &&TimedLane<'_>| !lane.settings.contains("build=lazy");
    let rows: Vec<&TimedLane<'_>> = rows.iter().filter(is_line).collect();
    let cost = |(_, totals): &&TimedLane<'_>| {
        let build_s = totals.seconds_of(0.0);
        Cost { build_s, ray_s: totals.seconds_of(1.0) - build_s }
    };
    let mut segments = envelope(&rows.iter().map(cost).collect::<Vec<_>>());
    segments.retain(|segment| segment.from < RAYS[1]);
    let first = segments.iter().rposition(|segment| segment.from <= RAYS[0])?;
    let from: Vec<f64> = segments.iter().skip(first).map(|segment| segment.from).collect();
    let rows = segments.iter().skip(first).filter_map(|segment| rows.get(segment.index));
    let ends = from.iter().skip(1).map(Some).chain([None]);
    let parts = rows.zip(ends).map(|((lane, _), end)| match end {
        Some(end) => format!("{} up to {}", lane.label(), numbers::short(*end)),
        None if from.len() == 1 => format!("{} for any number", lane.label()),
        None => format!("{} beyond", lane.label()),
    });
    let parts: Vec<String> = parts.collect();
    Some(format!("The fastest by rays per frame: {}.", parts.join(", ")))
}

/// Break-even point of a rebuilt grid and a refitted BVH, each the one with the most frames per
/// second.
fn grid_and_bvh(run: &AnimationRecord, rows: &[TimedLane<'_>]) -> Option<String> {
    let best = |is: &dyn Fn(&LaneRecord) -> bool| {
        let own = rows.iter().filter(|(lane, _)| is(lane));
        own.min_by(|a, b| a.1.seconds_of(a.1.rays).total_cmp(&b.1.seconds_of(b.1.rays)))
    };
    let grid =
        best(&|lane| lane.structure.ends_with("grid") && !lane.settings.contains("update="))?;
    let bvh = best(&|lane| lane.settings.contains("update=refit"))?;
    let (grid_label, bvh_label) = (grid.0.label(), bvh.0.label());
    let pair = |at: &Estimate, first: &str, then: &str| {
        format!(
            "Between building {grid_label} anew and refitting ({bvh_label}), {first} is faster up to {} rays a \
             frame, then {then}.",
            numbers::interval(at)
        )
    };
    Some(if let Some(at) = bvh.1.break_even(grid.1, run.seed) {
        pair(&at, &grid_label, &bvh_label)
    } else if let Some(at) = grid.1.break_even(bvh.1, run.seed) {
        pair(&at, &bvh_label, &grid_label)
    } else {
        let is_bvh = bvh.1.seconds_of(bvh.1.rays) < grid.1.seconds_of(grid.1.rays);
        let [(faster, first), (_, other)] = if is_bvh {
            [(&bvh_label, bvh.1), (&grid_label, grid.1)]
        } else {
            [(&grid_label, grid.1), (&bvh_label, bvh.1)]
        };
        let ends = [0.0, RAYS[1]];
        let is_always = ends.iter().all(|&n| first.seconds_of(n) <= other.seconds_of(n));
        let for_what = if is_always {
            "for any number of rays"
        } else {
            "here; the rounds do not agree on a number of rays from which on it is not"
        };
        format!(
            "Between building {grid_label} anew and refitting ({bvh_label}), {faster} is faster {for_what}."
        )
    })
}
