//! Times of a row over those of the reference row, round by round.

use crate::record::{Outliers, RowRecord, Sample, SceneRecord};
use statistics::series::{Series, two_levels};

/// Trace time over the reference's, round by round.
pub fn trace_ratios(row: &RowRecord) -> Series {
    let ratio = |s: &Sample| Some(s.total_trace_s() / s.reference_trace_s.filter(|r| *r > 0.0)?);
    series(row, ratio)
}

/// Values of samples with their processes; samples without a value are left out.
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

impl RowRecord {
    /// Makes all medians, intervals, rates and ratios anew from the samples.
    pub fn figure(&mut self, seed: u64) {
        let of = |read: fn(&Sample) -> f64| series(self, |s| Some(read(s))).estimate(seed);
        let build_s = of(|s| s.build_s);
        // an occluder in a scene without shadow rays has nothing to trace
        let trace_s = of(Sample::total_trace_s).filter(|_| !self.rays_by_kind.is_empty());
        let rate = |(kind, rays): (&String, &u64)| {
            let seconds = series(self, |s| s.trace_s.get(kind).copied()).middle();
            Some((kind.clone(), *rays as f64 / seconds.filter(|s| *s > 0.0)? / 1e6))
        };
        let mrays = self.rays_by_kind.iter().filter_map(rate).collect();
        let ratio = |kind: &String| Some((kind.clone(), kind_ratios(self, kind).estimate(seed)?));
        let ratio_by_kind = self.rays_by_kind.keys().filter_map(ratio).collect();
        let ratio = trace_ratios(self).estimate(seed);
        let build_ratio = ratios_of_builds(self, &[]).estimate(seed);
        (self.build_s, self.trace_s, self.mrays) = (build_s, trace_s, mrays);
        (self.ratio, self.ratio_by_kind, self.build_ratio) = (ratio, ratio_by_kind, build_ratio);
        self.levels = two_levels(&if self.is_reference {
            series(self, |s| Some(s.total_trace_s()))
        } else {
            trace_ratios(self)
        });
        self.outliers = Outliers::of(&self.samples);
    }
}
