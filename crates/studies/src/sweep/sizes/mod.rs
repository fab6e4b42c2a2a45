//! One scene in several sizes: the plan of `rtbench sweep --sizes`.
//!
//! Every size is a scene of an ordinary [`Plan`], so that rows are checked, interleaved and timed
//! as those of a run are. What is asked is the same at each size: the primary rays of one image,
//! and the shadow rays of what they hit. Before a size is loaded, a [`measurement::rounds::trial`]
//! builds each row in a separate process, which finds its peak memory and keeps the time and
//! memory limits.

pub mod admission;
pub mod quantities;
pub mod table;
pub mod targets;

use std::time::Duration;

use accel_core::occluders;
use accel_core::structures::Entry;

use crate::sweep::sizes::targets::Sizes;
use measurement::plan::error::PlanError;
use measurement::plan::{Plan, time_within};
use measurement::record::scale::{ScaleRecord, SizeRecord};
use measurement::rounds::trial::BuildLimits;
use measurement::scenes::SceneSource;
use measurement::settings::{MeasuringSettings, RunSettings};

/// Width and height of the image.
const SIZE: u32 = 256;

/// The rays asked for when none are named.
const RAYS: [&str; 2] = ["primary", "shadow"];

/// From this ratio on a size is no answer to what was asked for: half a decade.
const FAR: f64 = 3.163;

/// Most memory of a trial build, in place of none.
const MAX_MEMORY: u64 = 8 << 30;

/// Settings of a sweep over sizes.
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
        let mut structures = args.structures.clone();
        if structures.is_empty() {
            // each at its defaults: variants are for `run`
            structures.extend(registry.iter().map(|e| e.info.name.to_owned()));
            if rays_of(&args.measuring).iter().any(|kind| kind == "shadow") {
                structures.extend(occluders.iter().map(|e| e.info.name.to_owned()));
            }
        }
        let of_run = RunSettings {
            scenes: sizes.iter().map(|size| size.name.clone()).collect(),
            by_kind: false,
            structures,
            overrides: Vec::new(),
            measuring: measuring(&args.measuring),
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
    let sizes = scenes.sizes(&args.scene)?;
    let mut found: Vec<SizeRecord> = Vec::new();
    for asked in args.sizes.targets() {
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

/// The kinds of rays named, or those that are asked for when none are.
fn rays_of(args: &MeasuringSettings) -> Vec<String> {
    if args.rays.is_empty() { RAYS.map(str::to_owned).into() } else { args.rays.clone() }
}

/// The options that all commands have which measure, with this one's defaults.
fn measuring(args: &MeasuringSettings) -> MeasuringSettings {
    let mut args = MeasuringSettings { rays: rays_of(args), max_memory: None, ..args.clone() };
    if !args.quick {
        args.size.get_or_insert(SIZE);
    }
    args
}
