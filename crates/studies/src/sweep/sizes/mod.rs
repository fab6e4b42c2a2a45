//! One scene in several sizes: the plan of `rtbench sweep --sizes`.
//!
//! Every size is a scene of an ordinary [`Plan`], so that rows are checked, interleaved and timed
//! as those of a run are. What is asked is the same at each size: the primary rays of one image,
//! and the shadow rays of what they hit. Before a size is loaded, a [`measurement::rounds::trial`]
//! builds each row in a separate process, which finds its peak memory and keeps the time and
//! memory limits, there and at all smaller sizes.

pub mod quantities;
pub mod table;

use std::time::Duration;

use accel_core::occluders;
use accel_core::structures::Entry;
use measurement::plan::error::PlanError;
use measurement::plan::measured_row::MeasuredRow;
use measurement::plan::{Plan, time_within};
use measurement::record::scale::{ScaleRecord, SizeRecord};
use measurement::record::{RowRecord, RunRecord, SceneRecord, Verdict};
use measurement::rounds::scene_run::SceneInput;
use measurement::rounds::trial::{BuildLimits, TrialBuild, TrialOutcome};
use measurement::scenes::SceneSource;
use measurement::settings::{MeasuringSettings, RunSettings, quantity};

use crate::sweep::values::Range;

/// Width and height of the image.
const SIZE: u32 = 256;

/// The rays asked for when none are named.
const RAYS: [&str; 2] = ["primary", "shadow"];

/// From this ratio on a size is no answer to what was asked for: half a decade.
const FAR: f64 = 3.163;

/// Most memory of a trial build, in place of none.
const MAX_MEMORY: u64 = 8 << 30;

#[derive(Debug, Clone)]
pub struct SizeSettings {
    /// A generated scene, without a size.
    pub scene: String,
    /// Numbers of primitives; the nearest size of the scene stands for each.
    pub sizes: Sizes,
    /// Structures and occluders, each with its settings if any; none means each at its defaults.
    pub structures: Vec<String>,
    /// How to measure; `max_memory` is that of the process that loads the scene and builds.
    pub measuring: MeasuringSettings,
    /// Longest build, without loading.
    pub time_limit: Duration,
}

/// A validated run over the sizes of a scene.
#[derive(Debug)]
pub struct SizeSweep<'r> {
    /// The sizes as scenes, the rows, and how they are measured.
    pub plan: Plan<'r>,
    /// The sizes, as in the record.
    pub record: ScaleRecord,
}

impl<'r> SizeSweep<'r> {
    pub fn new(
        args: &SizeSettings,
        registry: &'r [Entry],
        occluders: &'r [occluders::Entry],
        scenes: &dyn SceneSource,
    ) -> Result<Self, PlanError> {
        time_within("time-limit", Some(args.time_limit))?;
        let sizes = sizes_of(args, scenes)?;
        let measuring = measuring(&args.measuring);
        let mut structures = args.structures.clone();
        if structures.is_empty() {
            // each at its defaults: variants are for `run`
            structures.extend(registry.iter().map(|e| e.info.name.to_owned()));
            if measuring.rays.iter().any(|kind| kind == "shadow") {
                structures.extend(occluders.iter().map(|e| e.info.name.to_owned()));
            }
        }
        let of_run = RunSettings {
            scenes: sizes.iter().map(|size| size.name.clone()).collect(),
            by_kind: false,
            structures,
            overrides: Vec::new(),
            measuring,
            shard: None,
            processes: 1,
        };
        let mut plan = Plan::new(&of_run, registry, occluders, scenes)?;
        // whole images are not compared
        plan.limits.render_pass = 0.0;
        let bytes = args.measuring.max_memory.unwrap_or(MAX_MEMORY);
        let limits = BuildLimits { seconds: args.time_limit.as_secs_f64(), bytes };
        plan.build_limits = Some(limits);
        let record = ScaleRecord {
            scene: args.scene.clone(),
            sizes,
            time_limit_s: limits.seconds,
            max_memory_bytes: limits.bytes,
            slopes: Vec::new(),
        };
        Ok(Self { plan, record })
    }
}

/// The nearest size to each number of primitives asked for.
fn sizes_of(args: &SizeSettings, scenes: &dyn SceneSource) -> Result<Vec<SizeRecord>, PlanError> {
    let sizes = scenes.catalogue()?.sizes(&args.scene)?;
    let mut found: Vec<SizeRecord> = Vec::new();
    for asked in args.sizes.0.iter().copied() {
        let (name, primitives) = sizes.nearest(asked);
        let off = primitives.max(1) as f64 / asked as f64;
        if off.max(off.recip()) > FAR {
            let [least, most] = sizes.ends();
            return Err(PlanError::Invalid(format!(
                "--sizes {asked}: the nearest size of {} has {primitives} primitives; its sizes go \
                 from {least} to {most}",
                args.scene
            )));
        }
        match found.last_mut().filter(|last| last.name == name) {
            Some(last) => last.asked.push(asked),
            None => found.push(SizeRecord { asked: vec![asked], name, primitives }),
        }
    }
    Ok(found)
}

/// The options that all commands have which measure, with this one's defaults.
fn measuring(args: &MeasuringSettings) -> MeasuringSettings {
    let mut args = MeasuringSettings { max_memory: None, ..args.clone() };
    if args.rays.is_empty() {
        args.rays = RAYS.map(str::to_owned).into();
    }
    if !args.quick {
        args.size.get_or_insert(SIZE);
    }
    args
}

const EXPECTED: &str = "expected FROM..TO, like 1e3..1e7, or counts with commas: 1k,20k,1M";

/// Numbers of primitives that sizes are asked for with, ascending, each once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sizes(Vec<u64>);

impl Sizes {
    /// Counts with commas; or a range with one for each factor of ten, or as near to that as equal
    /// ratios between its ends allow.
    pub fn parse(text: &str) -> Result<Self, String> {
        let count = |text: &str| {
            let count = quantity::parse(text.trim()).filter(|n| *n > 0);
            count.ok_or_else(|| format!("'{text}' is not a count above 0; {EXPECTED}"))
        };
        if let Some((from, to)) = text.split_once("..") {
            let (from, to) = (count(from)?, count(to)?);
            if from >= to {
                return Err(format!("{from} is not below {to}; {EXPECTED}"));
            }
            let (from, to) = (from as f64, to as f64);
            let steps = (to / from).log10().round().max(1.0) as usize + 1;
            let texts = Range { from, to, steps }.whole_numbers();
            return Ok(Self(texts.iter().filter_map(|n| n.parse().ok()).collect()));
        }
        let mut list = text.split(',').map(count).collect::<Result<Vec<u64>, _>>()?;
        list.sort_unstable();
        list.dedup();
        Ok(Self(list))
    }
}

/// The outcome of each row's trial on a scene; empty where the plan has no limits.
pub fn trials(
    plan: &Plan<'_>,
    finished: &[SceneRecord],
    scene: &str,
    equipment: &SceneInput<'_>,
) -> Vec<TrialOutcome> {
    let outcome = |row: &MeasuredRow<'_>| {
        let trial = TrialBuild {
            scene: scene.to_owned(),
            view: plan.scenes.first().map(|scene| scene.known().view.clone()).unwrap_or_default(),
            row: row.label(),
            threads: plan.threads,
            precision: plan.precision,
            limits: plan.build_limits?,
        };
        equipment.progress.message(format!("{scene}: trial build of {}", trial.row));
        Some(match earlier(finished, &trial.row) {
            Some(reason) => TrialOutcome::OverLimit(reason),
            None => (equipment.world.trial_build)(&trial),
        })
    };
    plan.rows.iter().filter_map(outcome).collect()
}

/// Why a row is not tried again: it was over a limit at a smaller size.
fn earlier(finished: &[SceneRecord], label: &str) -> Option<String> {
    finished.iter().find_map(|scene| {
        let over = |row: &&RowRecord| row.verdict == Verdict::OverLimit && row.label() == label;
        let reason = scene.rows.iter().find(over)?.error.as_deref().unwrap_or_default();
        Some(format!("not tried: over a limit at {} already: {reason}", scene.name))
    })
}

/// The record of a size where no row is left to measure: it is not even loaded.
pub fn without_rows(
    plan: &Plan<'_>,
    run: &RunRecord,
    scene: &str,
    trials: &[TrialOutcome],
) -> Option<SceneRecord> {
    let reasons = trials.iter().map(|outcome| match outcome {
        TrialOutcome::OverLimit(reason) => Some(reason.clone()),
        TrialOutcome::Ended { .. } | TrialOutcome::Died(_) => None,
    });
    let reasons: Vec<String> = reasons.collect::<Option<_>>()?;
    if reasons.is_empty() {
        return None;
    }
    let size = run.scale.as_ref().and_then(|scale| scale.size(scene));
    let rows = plan.rows.iter().zip(reasons).enumerate().map(|(i, (row, reason))| RowRecord {
        is_reference: i == plan.baseline,
        ..row.unmeasured(Verdict::OverLimit, Some(reason))
    });
    Some(SceneRecord {
        name: scene.to_owned(),
        source: "not loaded: every row is over a limit".into(),
        primitives: size.map_or(0, |size| size.primitives),
        rows: rows.collect(),
        ..SceneRecord::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_lists() {
        let targets = |text| Sizes::parse(text).unwrap().0;
        assert_eq!(targets("1e3..1e6"), [1000, 10_000, 100_000, 1_000_000]);
        assert_eq!(targets("1k..50k"), [1000, 7071, 50_000], "equal ratios");
        assert_eq!(targets("1000..2k"), [1000, 2000], "both ends at least");
        assert_eq!(targets("10M,1k,1e3"), [1000, 10_000_000]);
        assert_eq!(targets("64"), [64]);
    }

    #[test]
    fn invalid_sizes_are_errors_that_show_valid_ones() {
        for bad in ["", "..", "1e3..", "1e6..1e3", "5..5", "0,1", "-1", "1.5", "1k;2k", "x..1e3"] {
            let error = Sizes::parse(bad).unwrap_err();
            assert!(error.contains("1e3..1e7"), "{bad}: {error}");
        }
    }
}
