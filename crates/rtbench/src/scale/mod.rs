//! One scene in several sizes: the plan of `rtbench scale`.
//!
//! Every size is a scene of an ordinary [`Plan`], so that rows are checked, interleaved, timed, kept
//! and resumed as those of a run are. What is asked is the same at each size: the primary rays of
//! one image, and the shadow rays of what they hit. Before a size is loaded, [`trial`] builds each
//! row in a process of its own, which finds its peak memory and keeps the time and memory limits.

pub mod admission;
pub mod quantities;
pub mod record;
pub mod sizes;
pub mod trial;

use accel_core::occluders;
use accel_core::structures::Entry;

use crate::args::{ExportArgs, MeasuringArgs, RunArgs, ScaleArgs};
use crate::plan::{Plan, PlanError};
use crate::scale::record::{ScaleRecord, SizeRecord};
use crate::scale::trial::BuildLimits;
use crate::scene_source::SceneSource;

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
    /// Validates the command line.
    ///
    /// # Errors
    /// [`PlanError`] naming what is valid.
    pub fn new(
        args: &ScaleArgs,
        registry: &'r [Entry],
        occluders: &'r [occluders::Entry],
        scenes: &dyn SceneSource,
    ) -> Result<Self, PlanError> {
        let sizes = sizes_of(args, scenes)?;
        let mut structures = args.structures.clone();
        if structures.is_empty() {
            // each at its defaults: variants are for `run`
            structures.extend(registry.iter().map(|e| e.info.name.to_owned()));
            if rays_of(&args.measuring).iter().any(|kind| kind == "shadow") {
                structures.extend(occluders.iter().map(|e| e.info.name.to_owned()));
            }
        }
        let of_run = RunArgs {
            scenes: sizes.iter().map(|size| size.name.clone()).collect(),
            as_set: None,
            by_kind: false,
            structures,
            overrides: args.overrides.clone(),
            measuring: measuring(&args.measuring),
            shard: None,
            exports: ExportArgs::default(),
            resume: None,
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
fn sizes_of(args: &ScaleArgs, scenes: &dyn SceneSource) -> Result<Vec<SizeRecord>, PlanError> {
    let sizes = scenes.sizes(&args.scene)?;
    let mut found: Vec<SizeRecord> = Vec::new();
    for asked in args.sizes.targets(args.per_decade) {
        let (name, primitives) = sizes.nearest(asked);
        let off = primitives.max(1) as f64 / asked as f64;
        if off.max(off.recip()) > FAR {
            let [least, most] = sizes.ends();
            let scene = args.scene.clone();
            let error = ScaleError::NoneNear { scene, asked, nearest: primitives, least, most };
            return Err(error.into());
        }
        match found.last_mut().filter(|last| last.name == name) {
            Some(last) => last.asked.push(asked),
            None => found.push(SizeRecord { asked: vec![asked], name, primitives }),
        }
    }
    Ok(found)
}

/// The kinds of rays named, or those that are asked for when none are.
fn rays_of(args: &MeasuringArgs) -> Vec<String> {
    if args.rays.is_empty() { RAYS.map(str::to_owned).into() } else { args.rays.clone() }
}

/// The options that all commands have which measure, with this one's defaults.
fn measuring(args: &MeasuringArgs) -> MeasuringArgs {
    let mut args = MeasuringArgs { rays: rays_of(args), ..args.clone() };
    if !args.quick {
        args.size.get_or_insert(SIZE);
    }
    args
}

#[cfg(test)]
mod tests {
    use accel_core::structures::REGISTRY;
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Command};
    use crate::scene_source::Installed;

    fn scale(arguments: &str) -> Result<Scale<'static>, String> {
        let words = ["rtbench", "scale"].into_iter().chain(arguments.split(' '));
        let cli = Cli::try_parse_from(words).map_err(|e| e.to_string())?;
        let Command::Scale(args) = cli.command else { return Err("another command".into()) };
        Scale::new(&args, REGISTRY, occluders::REGISTRY, &Installed).map_err(|e| e.to_string())
    }

    #[test]
    fn sizes_are_the_nearest_ones_each_once() {
        let s = scale("balls-tess --sizes 1e3..1e7 -s uniform-grid").unwrap();
        let names: Vec<&str> = s.plan.scenes.iter().map(|scene| scene.name()).collect();
        let expected = [1, 2, 3, 4, 5].map(|n| format!("balls-tess:{n}"));
        assert_eq!(names, expected);
        assert_eq!(s.record.sizes[3].primitives, 1_417_154);
        let s = scale("balls --sizes 1e3..1e4 --per-decade 4 -s uniform-grid").unwrap();
        let asked: Vec<usize> = s.record.sizes.iter().map(|size| size.asked.len()).collect();
        assert_eq!((s.record.sizes[0].name.as_str(), asked), ("balls:3", vec![2, 3]));
        assert_eq!(s.plan.kinds.iter().map(|k| k.name()).collect::<Vec<_>>(), RAYS);
        assert_eq!(s.plan.settings.resolution, [256, 256]);
    }

    #[test]
    fn all_structures_are_measured_at_their_defaults() {
        let s = scale("tetra --sizes 64..1024 --quick").unwrap();
        let labels: Vec<String> = s.plan.rows.iter().map(|row| row.label()).collect();
        assert_eq!(labels.len(), REGISTRY.len() + occluders::REGISTRY.len());
        assert!(REGISTRY.iter().all(|e| labels.iter().any(|l| l == e.info.name)), "{labels:?}");
        let s = scale("tetra --sizes 64 --set uniform-grid.density=4 --rays primary").unwrap();
        assert!(s.plan.rows.iter().any(|row| row.label() == "uniform-grid density=4"));
        assert_eq!(s.plan.rows.len(), REGISTRY.len(), "no shadow rays, no occluder");
    }

    #[test]
    fn limits_are_read() {
        let s = scale("tetra --sizes 64 --time-limit 2m --max-memory 1.5GiB").unwrap();
        let limits = s.plan.build_limits.unwrap();
        assert_eq!((limits.seconds, limits.bytes), (120.0, 3 << 29));
    }

    #[test]
    fn what_cannot_be_scaled_says_why() {
        for (arguments, said) in [
            ("kitchen", "does not come in sizes; those that do: balls"),
            ("kitchn", "unknown scene"),
            ("hare --sizes 1e3..1e9", "its sizes go from 8 to 19996488"),
            ("balls --sizes 1", "the nearest size of balls has 11 primitives"),
            ("hare --sizes 1e6..1e3", "is not below"),
            ("hare --per-decade 0", "per-decade"),
            ("hare --max-memory 8", "8GiB"),
            ("hare -s unifrom-grid", "did you mean 'uniform-grid'?"),
        ] {
            let error = scale(arguments).unwrap_err();
            assert!(error.contains(said), "{arguments}: {error}");
        }
    }
}
