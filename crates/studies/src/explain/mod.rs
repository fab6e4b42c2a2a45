//! Explains the difference in time between two rows: the plan of `rtbench explain`.
//!
//! The row, the reference, and both in all their crafts (adapter, kernel, query) are rows of one
//! ordinary [`Plan`], so that they are checked, interleaved and timed as rows of a run are, all on
//! the same rays. Their ratios stand in a table of structure by kernel, and multiply to the whole
//! as factors.

pub mod craft;
pub mod steps;
pub mod table;

use accel_core::structures::Entry;

use crate::explain::craft::{Variant, crafts_of};
use crate::explain::steps::{Step, steps};
use measurement::plan::error::PlanError;
use measurement::plan::rows::Row;
use measurement::plan::{Plan, default_baseline};
use measurement::record::metrics::{kind_ratios, trace_ratios};
use measurement::record::{RowRecord, RunRecord, SceneRecord};
use measurement::scenes::SceneSource;
use measurement::settings::MeasuringSettings;
use statistics::estimate::Estimate;
use statistics::product_of_medians::product_of_series;
use statistics::series::Series;

#[derive(Debug)]
pub struct Explain<'r> {
    pub plan: Plan<'r>,
    /// Variant of each row of the plan, over triangles in f32. The first is the row in question, the
    /// plan's baseline the other.
    pub variants: Vec<Variant>,
}

impl<'r> Explain<'r> {
    /// Of a row, named with its settings if any, and the reference of `measuring`, over scenes,
    /// scene sets or scene files; built and timed in so many fresh processes, as
    /// [`measurement::settings::RunSettings::processes`].
    pub fn new(
        scenes: &[String],
        structure: &str,
        measuring: &MeasuringSettings,
        processes: u32,
        registry: &'r [Entry],
        source: &dyn SceneSource,
    ) -> Result<Self, PlanError> {
        let row = Row::parse(registry, structure)?;
        let reference = match &measuring.reference {
            Some(name) => Row::parse(registry, name)?,
            None => default_baseline(registry)?,
        };
        if row == reference {
            return Err(PlanError::Invalid(format!(
                "{} is also the reference; name another with --structure or --reference",
                row.label()
            )));
        }
        for row in [&row, &reference] {
            // a chosen test goes through code of its own
            if row.params.changed().any(|(name, _)| name.ends_with("-test")) {
                return Err(PlanError::Invalid(format!(
                    "{}: only rows with the default tests of primitives can be explained",
                    row.label()
                )));
            }
        }
        let mut rows = crafts_of(&row)?;
        for other in crafts_of(&reference)? {
            if !rows.contains(&other) {
                rows.push(other);
            }
        }
        let baseline = rows.iter().position(|row| *row == reference).unwrap_or(0);
        let variants = rows.iter().map(Variant::of).collect();
        let scenes = source.resolve(scenes)?;
        let mut plan = Plan::over(scenes, rows, baseline, measuring, registry)?;
        plan.same_rays = true;
        plan.keeps_baseline = true;
        // no image is asked for
        plan.limits.render_pass = 0.0;
        plan.set_processes(processes)?;
        Ok(Self { plan, variants })
    }
}

/// The rays of a column of factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rays<'k> {
    /// Rays of one kind, named as in records.
    Kind(&'k str),
    All,
}

impl Rays<'_> {
    /// In tables and CSV.
    pub fn name(&self) -> &str {
        match self {
            Self::Kind(kind) => kind,
            Self::All => "all",
        }
    }

    /// Times over the reference's, round by round.
    fn ratios(self, row: &RowRecord) -> Series {
        match self {
            Self::Kind(kind) => kind_ratios(row, kind),
            Self::All => trace_ratios(row),
        }
    }

    /// The ratio of a row to the reference.
    pub fn ratio(self, row: &RowRecord) -> Option<Estimate> {
        match self {
            Self::Kind(kind) => row.ratio_by_kind.get(kind).copied(),
            Self::All => row.ratio,
        }
    }
}

#[derive(Debug)]
pub struct Explanation<'a> {
    run: &'a RunRecord,
    pub scene: &'a SceneRecord,
    /// Variant of each row in this scene; `None` for a duplicate of an earlier one.
    pub variants: Vec<Option<Variant>>,
    /// The factors; empty where one of the two rows has no time.
    pub factors: Vec<Step>,
}

impl<'a> Explanation<'a> {
    pub fn of(explain: &Explain<'_>, run: &'a RunRecord, scene: &'a SceneRecord) -> Self {
        let ends = [0, explain.plan.baseline];
        let mut variants: Vec<Option<Variant>> = vec![None; scene.rows.len()];
        for i in ends.into_iter().chain(0..scene.rows.len()) {
            let (Some(row), Some(nominal)) = (scene.rows.get(i), explain.variants.get(i)) else {
                continue;
            };
            let variant = Some(nominal.in_scene(scene, row, &run.settings.precision));
            let is_new = ends.contains(&i) || !variants.contains(&variant);
            if let Some(place) = variants.get_mut(i).filter(|_| is_new) {
                *place = variant;
            }
        }
        let is_timed = |(row, variant): (&RowRecord, &Option<Variant>)| {
            variant.clone().filter(|_| row.verdict.is_timed() && row.ratio.is_some())
        };
        let timed: Vec<Option<Variant>> = scene.rows.iter().zip(&variants).map(is_timed).collect();
        let factors = steps(&timed, explain.plan.baseline, 0);
        Self { run, scene, variants, factors }
    }

    /// A factor over those rays; none where a row has not all rounds.
    pub fn factor(&self, factor: &Step, rays: Rays<'_>) -> Option<Estimate> {
        let rows = factor.powers.iter();
        let of = |(row, power): &(usize, f64)| Some((self.scene.rows.get(*row)?, *power));
        let rows: Vec<(&RowRecord, f64)> = rows.map(of).collect::<Option<_>>()?;
        let rounds = |row: &RowRecord| row.samples.iter().map(|s| s.round).collect::<Vec<_>>();
        let first = rounds(rows.first()?.0);
        if rows.iter().any(|(row, _)| rounds(row) != first) {
            return None;
        }
        let samples: Vec<(Series, f64)> =
            rows.iter().map(|(row, power)| (rays.ratios(row), *power)).collect();
        product_of_series(&samples, self.run.settings.seed)
    }
}

#[cfg(test)]
mod tests {
    use accel_core::structures::REGISTRY;
    use measurement::record::Verdict;
    use measurement::record::made_up::{Rows, run};
    use measurement::scenes::InstalledScenes;

    use super::*;
    use crate::explain::table::rays_of;

    /// The default rows with their times; the reference is named by the fourth.
    const ROWS: Rows<'_> = &[
        ("uniform-grid", &[2.0, 2.2, 1.8]),
        ("uniform-grid kernel=scalar", &[3.0, 3.1, 2.9]),
        ("uniform-grid query=batch", &[1.5, 1.4, 1.6]),
        ("obvhs-cwbvh", &[1.0, 1.1, 0.9]),
        ("obvhs-cwbvh adapter=robust kernel=scalar", &[1.2, 1.3, 1.2]),
        ("obvhs-cwbvh adapter=robust", &[1.1, 1.1, 1.0]),
    ];

    fn explain(row: &str, reference: Option<&str>) -> Result<Explain<'static>, String> {
        let measuring = MeasuringSettings {
            reference: reference.map(str::to_owned),
            threads: 1,
            ..MeasuringSettings::default()
        };
        let scenes = ["tetra:2".to_owned()];
        Explain::new(&scenes, row, &measuring, 1, REGISTRY, &InstalledScenes)
            .map_err(|e| e.to_string())
    }

    /// Their record, with ratios to the row of [`Explain`]'s baseline.
    fn record() -> RunRecord {
        let mut record = run(&[("tetra:2", ROWS)]);
        let reference: Vec<f64> = ROWS[3].1.to_vec();
        for row in &mut record.scenes[0].rows {
            for (sample, seconds) in row.samples.iter_mut().zip(&reference) {
                sample.reference_trace_s = Some(*seconds);
                sample.reference_by_kind = [("primary".to_owned(), *seconds)].into();
            }
            row.ratio = trace_ratios(row).estimate(1);
            row.ratio_by_kind =
                [("primary".to_owned(), kind_ratios(row, "primary").estimate(1).unwrap())].into();
        }
        record
    }

    /// Names and medians of the factors.
    fn factors(explanation: &Explanation<'_>) -> Vec<(String, f64)> {
        let of = |factor: &Step| {
            let [kind, all] = [Rays::Kind("primary"), Rays::All]
                .map(|rays| explanation.factor(factor, rays).unwrap().median);
            assert!((kind - all).abs() < 1e-12);
            (factor.name.clone(), kind)
        };
        explanation.factors.iter().map(of).collect()
    }

    #[test]
    fn all_code_variants_of_both_rows_are_in_one_plan() {
        let explain = explain("uniform-grid", None).unwrap();
        let labels: Vec<String> = explain.plan.rows.iter().map(|row| row.label()).collect();
        assert_eq!(labels, ROWS.iter().map(|(label, _)| *label).collect::<Vec<_>>());
        assert_eq!(explain.plan.baseline, 3);
        assert!(explain.plan.same_rays && explain.plan.keeps_baseline);
        let same = self::explain("obvhs-cwbvh:adapter=robust", Some("obvhs-cwbvh")).unwrap();
        assert_eq!((same.plan.rows.len(), same.plan.baseline), (3, 1));
    }

    #[test]
    fn factors_are_what_was_measured_and_multiply_to_the_whole() {
        let (explain, record) = (explain("uniform-grid", None).unwrap(), record());
        let explanation = Explanation::of(&explain, &record, &record.scenes[0]);
        let found = factors(&explanation);
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names[..2], ["adapter: direct to robust", "kernel: scalar to block"]);
        assert_eq!(names[2..], ["structure: obvhs-cwbvh to uniform-grid"]);
        // medians of ratios to the reference
        let [grid, grid_scalar, bvh_scalar, bvh]: [f64; 4] = [2.0, 3.0, 1.2, 1.1];
        let kernel = (bvh / bvh_scalar * grid / grid_scalar).sqrt();
        let structure = (grid_scalar / bvh_scalar * grid / bvh).sqrt();
        for ((_, found), expected) in found.iter().zip([bvh_scalar, kernel, structure]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        let product: f64 = found.iter().map(|(_, median)| median).product();
        let whole = Rays::All.ratio(&record.scenes[0].rows[0]).unwrap().median;
        assert!((product - whole).abs() < 1e-12);
        assert_eq!(rays_of(&record, &record.scenes[0]), [Rays::Kind("primary"), Rays::All]);
    }

    #[test]
    fn a_planted_slower_kernel_is_separated_from_the_structure() {
        let explain = explain("uniform-grid", None).unwrap();
        let before = record();
        let mut after = before.clone();
        // both with blocks, half as fast
        for row in [0, 5].map(|row| after.scenes[0].rows[row].clone()) {
            let place = after.scenes[0].rows.iter().position(|r| r.is_same(&row)).unwrap();
            let row = &mut after.scenes[0].rows[place];
            row.samples.iter_mut().for_each(|s| {
                s.trace_s.values_mut().for_each(|seconds| *seconds *= 2.0);
            });
        }
        let of =
            |record: &RunRecord| factors(&Explanation::of(&explain, record, &record.scenes[0]));
        for ((name, before), (_, after)) in of(&before).into_iter().zip(of(&after)) {
            let times = if name.starts_with("kernel") { 2.0 } else { 1.0 };
            assert!((after / before - times).abs() < 1e-9, "{name}");
        }
    }

    #[test]
    fn wrong_and_missing_rows_are_in_no_factor() {
        let explain = explain("uniform-grid", None).unwrap();
        let names = |record: &RunRecord| {
            let explanation = Explanation::of(&explain, record, &record.scenes[0]);
            explanation.factors.iter().map(|f| f.name.clone()).collect::<Vec<_>>()
        };
        let with = |row: usize, verdict: Verdict| {
            let mut record = record();
            record.scenes[0].rows[row].verdict = verdict;
            record
        };
        // a row on the way: the other way is left
        let mut record = with(1, Verdict::Wrong);
        assert_eq!(names(&record).len(), 3);
        // no way: what is changed together stays together
        record.scenes[0].rows[5].verdict = Verdict::Panicked;
        let together = "kernel: scalar to block; structure: obvhs-cwbvh to uniform-grid";
        assert_eq!(names(&record), ["adapter: direct to robust", together]);
        // an end
        assert!(names(&with(0, Verdict::Wrong)).is_empty());
        assert!(names(&with(3, Verdict::NotBuilt)).is_empty());
        // rounds of which one is missing cannot be paired
        let mut record = self::record();
        record.scenes[0].rows[4].samples.remove(1);
        let explanation = Explanation::of(&explain, &record, &record.scenes[0]);
        assert_eq!(explanation.factor(&explanation.factors[0], Rays::All), None);
    }

    #[test]
    fn without_triangles_there_is_one_kernel_and_no_direct_adapter() {
        let (explain, mut record) = (explain("uniform-grid", None).unwrap(), record());
        record.scenes[0].only_triangles = Some(false);
        let explanation = Explanation::of(&explain, &record, &record.scenes[0]);
        let there: Vec<bool> = explanation.variants.iter().map(Option::is_some).collect();
        assert_eq!(there, [true, false, false, true, true, false]);
        let names: Vec<&str> = explanation.factors.iter().map(|f| &*f.name).collect();
        let adapter = "adapter: as-shipped to robust";
        assert_eq!(names, [adapter, "structure: obvhs-cwbvh to uniform-grid"]);
    }

    #[test]
    fn errors_say_what_can_be_explained() {
        let said = |row, reference| explain(row, reference).unwrap_err();
        assert!(said("obvhs-cwbvh", None).contains("is also the reference"));
        assert!(said("uniform-grid:triangle-test=pluecker", None).contains("default tests"));
        assert!(said("kd-tre", None).contains("did you mean 'kd-tree'?"));
        assert!(said("kd-tree", Some("octre")).contains("did you mean 'octree'?"));
    }
}
