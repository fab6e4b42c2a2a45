//! One scene in several sizes: the plan of `rtbench scale`.
//!
//! Every size is a scene of an ordinary [`Plan`], so that rows are checked, interleaved, timed, kept
//! and resumed as those of a run are. What is asked is the same at each size: the primary rays of
//! one image, and the shadow rays of what they hit. Before a size is loaded, a [`measurement::rounds::trial`]
//! builds each row in a process of its own, which finds its peak memory and keeps the time and memory limits.

pub mod admission;
pub mod columns;
pub mod csv;
pub mod plot;
pub mod quantities;
pub mod sizes;
pub mod table;

use accel_core::occluders;
use accel_core::structures::Entry;

use crate::scale::sizes::targets;
use measurement::plan::error::PlanError;
use measurement::plan::{Plan, time_within, within};
use measurement::record::scale::{ScaleRecord, SizeRecord};
use measurement::rounds::trial::BuildLimits;
use measurement::scenes::{LoadError, SceneSource};
use measurement::settings::scale::ScaleSettings;
use measurement::settings::{MeasuringSettings, RunSettings};

/// Width and height of the image.
const SIZE: u32 = 256;

/// The rays asked for when none are named.
const RAYS: [&str; 2] = ["primary", "shadow"];

/// From this ratio on a size is no answer to what was asked for: half a decade.
const FAR: f64 = 3.163;

/// What cannot be scaled.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScaleError {
    /// No size of the scene is near.
    #[error(
        "--sizes {asked}: the nearest size of {scene} has {nearest} primitives; its sizes go from \
         {least} to {most}"
    )]
    NoneNear {
        /// Scene.
        scene: String,
        /// Primitives asked for.
        asked: u64,
        /// Those of the nearest size.
        nearest: u64,
        /// Of the smallest size.
        least: u64,
        /// Of the largest size.
        most: u64,
    },
    /// What is no plan either.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// No such scene.
    #[error(transparent)]
    Scene(#[from] LoadError),
}

/// A validated run over the sizes of a scene.
#[derive(Debug)]
pub struct Scale<'r> {
    /// The sizes as scenes, the rows, and how they are measured.
    pub plan: Plan<'r>,
    /// What the record says of the sizes.
    pub record: ScaleRecord,
}

impl<'r> Scale<'r> {
    /// Validates what is asked for.
    ///
    /// # Errors
    /// [`ScaleError`] naming what is valid.
    pub fn new(
        args: &ScaleSettings,
        registry: &'r [Entry],
        occluders: &'r [occluders::Entry],
        scenes: &dyn SceneSource,
    ) -> Result<Self, ScaleError> {
        within("per-decade", args.per_decade.into(), ScaleSettings::MOST_PER_DECADE.into())?;
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
            overrides: args.overrides.clone(),
            measuring: measuring(&args.measuring),
            shard: None,
            processes: 1,
        };
        let mut plan = Plan::new(&of_run, registry, occluders, scenes)?;
        // whole images are not compared
        plan.limits.render_pass = 0.0;
        let limits = BuildLimits { seconds: args.time_limit.as_secs_f64(), bytes: args.max_memory };
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
fn sizes_of(args: &ScaleSettings, scenes: &dyn SceneSource) -> Result<Vec<SizeRecord>, ScaleError> {
    let sizes = scenes.sizes(&args.scene)?;
    let mut found: Vec<SizeRecord> = Vec::new();
    for asked in targets(&args.sizes, args.per_decade) {
        let (name, primitives) = sizes.nearest(asked);
        let off = primitives.max(1) as f64 / asked as f64;
        if off.max(off.recip()) > FAR {
            let [least, most] = sizes.ends();
            let scene = args.scene.clone();
            let error = ScaleError::NoneNear { scene, asked, nearest: primitives, least, most };
            return Err(error);
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
    let mut args = MeasuringSettings { rays: rays_of(args), ..args.clone() };
    if !args.quick {
        args.size.get_or_insert(SIZE);
    }
    args
}
