//! The figures of a row: what its samples, of one process or of several, say together.

use crate::record::ratios::{kind_ratios, ratios_of_builds, series, trace_ratios};
use crate::record::{Outliers, RowRecord, Sample};
use statistics::series::two_levels;

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
