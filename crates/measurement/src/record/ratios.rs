//! Times of a row over those of the reference row, round by round.

use crate::record::{RowRecord, Sample, SceneRecord};
use statistics::series::Series;

/// Trace time over the reference's, round by round.
pub fn trace_ratios(row: &RowRecord) -> Series {
    let ratio = |s: &Sample| Some(s.total_trace_s() / s.reference_trace_s.filter(|r| *r > 0.0)?);
    series(row, ratio)
}

/// What samples say, each with its process; those that say nothing are left out.
pub fn series(row: &RowRecord, of: impl Fn(&Sample) -> Option<f64>) -> Series {
    row.samples.iter().filter_map(|s| Some((s.process, of(s)?))).collect()
}

/// Trace time of the rays of a kind over the reference's, round by round; none in records from
/// before samples had them.
pub fn kind_ratios(row: &RowRecord, kind: &str) -> Series {
    let ratio = |s: &Sample| {
        let reference = s.reference_by_kind.get(kind).copied().filter(|r| *r > 0.0)?;
        Some(s.trace_s.get(kind)? / reference)
    };
    series(row, ratio)
}

/// Build time over the reference's of the scene, round by round.
pub fn build_ratios(scene: &SceneRecord, row: &RowRecord) -> Series {
    if row.samples.iter().all(|s| s.reference_build_s.is_some()) {
        return ratios_of_builds(row, &[]);
    }
    let references = scene.rows.iter().filter(|r| r.is_reference);
    ratios_of_builds(row, &references.flat_map(builds_by_round).collect::<Vec<_>>())
}

/// `reference` has the build times for records from before samples had them.
pub(crate) fn ratios_of_builds(row: &RowRecord, reference: &[(u32, f64)]) -> Series {
    let ratio = |s: &Sample| {
        let seconds = s.reference_build_s.or_else(|| seconds_of(s.round, reference))?;
        (seconds > 0.0).then(|| s.build_s / seconds)
    };
    series(row, ratio)
}

/// Rounds and the seconds that building took in them.
pub(crate) fn builds_by_round(row: &RowRecord) -> impl Iterator<Item = (u32, f64)> {
    row.samples.iter().map(|s| (s.round, s.build_s))
}

/// The seconds of a round.
pub(crate) fn seconds_of(round: u32, seconds: &[(u32, f64)]) -> Option<f64> {
    seconds.iter().find(|(r, _)| *r == round).map(|(_, seconds)| *seconds)
}
