//! Metrics that can be compared between runs: one registry line each; and a row's times over those
//! of the reference row, round by round.
//!
//! Exact metrics are the same on every machine and in every run of the same program; measured ones
//! have one sample per round.

use crate::plan::error::PlanError;
use crate::record::{Outliers, RowRecord, Sample, SceneRecord, StatsRecord, WorkRecord};
use statistics::series::{Series, two_levels};

/// A metric of a row.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// As in CSV files and on the command line.
    pub name: &'static str,
    /// Unit of its values; empty for counts and ratios.
    pub unit: &'static str,
    /// Description for help and glossaries.
    pub summary: &'static str,
    /// More of it is worse. False of what is no cost in itself, only a share of another metric.
    pub is_cost: bool,
    /// Source of its values in a row.
    pub reading: Reading,
}

/// Source of a metric in a row.
#[derive(Debug, Clone, Copy)]
pub enum Reading {
    /// Derived from build statistics; independent of the machine.
    Stats(fn(&StatsRecord) -> u64),
    /// Derived from counted work, per ray; independent of the machine.
    Work(fn(&WorkRecord) -> u64),
    /// Build times of a row of a scene, one sample per round.
    Build(fn(&SceneRecord, &RowRecord) -> Series),
    /// Trace times, one sample per round.
    Trace(fn(&RowRecord) -> Series),
    /// Trace times of a kind and order as ratios to the reference, one sample per round.
    RatioOf(&'static str),
}

/// Scope of a difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DifferenceScope {
    /// No figure can be compared.
    Everything,
    /// No times in seconds.
    Seconds,
    /// No ratios to the reference.
    Ratios,
    /// All figures can be compared; the difference may be why they differ.
    Nothing,
}

impl Metric {
    /// The same in every run of the same program.
    pub fn is_exact(&self) -> bool {
        matches!(self.reading, Reading::Stats(_) | Reading::Work(_))
    }

    /// It is taken to the reference of the same run.
    pub fn is_to_reference(&self) -> bool {
        // what is measured is seconds, or a ratio of them
        !self.is_exact() && self.unit.is_empty()
    }

    /// Returns whether a difference of that kind between two runs keeps it from being compared.
    pub fn is_concerned(&self, by: DifferenceScope) -> bool {
        match by {
            DifferenceScope::Everything => true,
            DifferenceScope::Seconds => self.unit == "s",
            DifferenceScope::Ratios => self.is_to_reference(),
            DifferenceScope::Nothing => false,
        }
    }

    /// Number of rays that its values cover; `None` if they do not concern rays. A slow row is
    /// timed on a sample, whose size is found by timing.
    pub fn rays(&self, row: &RowRecord) -> Option<u64> {
        match self.reading {
            Reading::Trace(_) => Some(row.rays),
            Reading::Work(_) => Some(row.work.as_ref()?.rays),
            Reading::RatioOf(kind) => row.rays_by_kind.get(kind).copied(),
            Reading::Stats(_) | Reading::Build(_) => None,
        }
    }

    /// Its value, where it is exact and the row has one.
    pub fn exact(&self, row: &RowRecord) -> Option<f64> {
        match self.reading {
            Reading::Stats(read) => Some(read(row.stats.as_ref()?) as f64),
            Reading::Work(read) => {
                let work = row.work.as_ref()?;
                Some(read(work) as f64 / work.rays.max(1) as f64)
            }
            Reading::Build(_) | Reading::Trace(_) | Reading::RatioOf(_) => None,
        }
    }

    /// Its values in a row of a scene: none, one, or one per round.
    pub fn values(&self, scene: &SceneRecord, row: &RowRecord) -> Series {
        match self.reading {
            Reading::Stats(_) | Reading::Work(_) => {
                self.exact(row).into_iter().collect::<Vec<_>>().into()
            }
            Reading::Build(read) => read(scene, row),
            Reading::Trace(read) => read(row),
            Reading::RatioOf(kind) => kind_ratios(row, kind),
        }
    }
}

pub fn named(name: &str) -> Result<&'static Metric, PlanError> {
    let names = || METRICS.iter().map(|m| m.name);
    let found = METRICS.iter().find(|m| m.name == name);
    found.ok_or_else(|| PlanError::unknown("metric", name, names()))
}

/// All metrics, exact ones first.
#[rustfmt::skip]
pub static METRICS: &[Metric] = &[
    cost("n_in", "", "inner cells", Reading::Stats(|stats| stats.n_in)),
    cost("n_v", "", "elementary cells", Reading::Stats(|stats| stats.n_v)),
    // what it cost is in n_v and memory
    share("n_ev", "empty elementary cells", Reading::Stats(|stats| stats.n_ev)),
    cost("n_oiv", "", "references in cells", Reading::Stats(|stats| stats.n_oiv)),
    cost("memory", "bytes", "bytes of the structure", Reading::Stats(|stats| stats.memory_bytes)),
    cost("n_it", "", "intersection tests per ray", Reading::Work(|work| work.intersection_tests)),
    cost("n_ts", "", "traversal steps per ray", Reading::Work(|work| work.traversal_steps)),
    cost("n_ets", "", "elementary steps per ray", Reading::Work(|work| work.elementary_steps)),
    // what it cost is in n_ets
    share("n_eets", "empty elementary steps per ray", Reading::Work(|work| work.empty_elementary_steps)),
    // what it cost is in n_it
    share("saved", "tests per ray that a mailbox saved", Reading::Work(|work| work.tests_saved)),
    cost("build", "s", "build time", Reading::Build(|_, row| series(row, |s| Some(s.build_s)))),
    cost("trace", "s", "trace time of all rays", Reading::Trace(|row| series(row, |s| Some(s.total_trace_s())))),
    cost("build-ratio", "", "build time over the reference's of the same round", Reading::Build(build_ratios)),
    cost("ratio", "", "trace time over the reference's of the same round", Reading::Trace(trace_ratios)),
    cost("ratio-primary", "", "the same of primary rays", Reading::RatioOf("primary")),
    cost("ratio-shadow", "", "the same of shadow rays", Reading::RatioOf("shadow")),
    cost("ratio-reflected", "", "the same of reflected rays", Reading::RatioOf("reflected")),
    cost("ratio-refracted", "", "the same of refracted rays", Reading::RatioOf("refracted")),
    cost("ratio-diffuse", "", "the same of diffuse rays", Reading::RatioOf("diffuse")),
    cost("ratio-primary-shuffled", "", "the same of primary rays in shuffled order", Reading::RatioOf("primary-shuffled")),
    cost("ratio-shadow-shuffled", "", "the same of shadow rays in shuffled order", Reading::RatioOf("shadow-shuffled")),
    cost("ratio-reflected-shuffled", "", "the same of reflected rays in shuffled order", Reading::RatioOf("reflected-shuffled")),
    cost("ratio-refracted-shuffled", "", "the same of refracted rays in shuffled order", Reading::RatioOf("refracted-shuffled")),
    cost("ratio-diffuse-shuffled", "", "the same of diffuse rays in shuffled order", Reading::RatioOf("diffuse-shuffled")),
];

const fn cost(
    name: &'static str,
    unit: &'static str,
    summary: &'static str,
    reading: Reading,
) -> Metric {
    Metric { name, unit, summary, is_cost: true, reading }
}

const fn share(name: &'static str, summary: &'static str, reading: Reading) -> Metric {
    Metric { is_cost: false, ..cost(name, "", summary, reading) }
}

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

#[cfg(test)]
mod tests {
    use renderer::RayKind;

    use super::*;
    use crate::rays::order::{Orders, batch_name};

    #[test]
    fn metrics_are_found_by_name() {
        for name in ["n_it", "n_ts", "n_ets", "n_eets", "saved", "trace", "ratio"] {
            let reading = named(name).unwrap().reading;
            assert!(matches!(reading, Reading::Work(_) | Reading::Trace(_)), "{name}: over rays");
        }
        let to_reference = METRICS.iter().filter(|m| m.is_to_reference()).map(|m| m.name);
        let to_reference: Vec<_> = to_reference.collect();
        assert_eq!(to_reference[..2], ["build-ratio", "ratio"]);
        // every kind of ray in both orders
        for kind in RayKind::ALL {
            for &order in Orders::Both.orders() {
                let name = batch_name(kind.name(), order);
                let metric = named(&format!("ratio-{name}")).unwrap();
                assert!(to_reference.contains(&metric.name));
                assert!(matches!(metric.reading, Reading::RatioOf(read) if read == name));
            }
        }
        let error = named("n_its").unwrap_err().to_string();
        assert!(
            error.contains("unknown metric 'n_its' (did you mean 'n_it'?); valid: n_in, "),
            "{error}"
        );
    }
}
