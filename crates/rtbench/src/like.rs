//! The plan that an earlier record was made by: its scenes, rows, rays, seed and arithmetic, or a
//! part of them.
//!
//! It goes through the command line of `rtbench run`, so that whatever holds there holds here.

use std::time::Duration;

use clap::Parser;

use crate::args::{BaselineAction, Cli, Command, RunArgs};
use crate::context::Context;
use crate::error::Error;
use crate::gate::GateError;
use crate::plan::{Plan, PlanError};
use crate::record::{RunRecord, SceneRecord};
use crate::strides::FixedStrides;
use crate::suggest;

/// Why a record gives no plan.
#[derive(Debug, thiserror::Error)]
pub enum LikeError {
    /// A scene or row that the record lacks.
    #[error("the baseline has no {what} '{name}'{hint}; it has: {valid}")]
    Unknown {
        /// `scene` or `row`.
        what: &'static str,
        /// As typed.
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        /// What it has.
        valid: String,
    },
    /// Nothing was finished in it.
    #[error("the baseline has no finished scene: there is nothing to hold against it")]
    Empty,
    /// The settings do not make a command line of this program.
    #[error("the settings of the baseline are none of this program: {0}")]
    Settings(String),
}

/// What to measure of a record, and how long.
#[derive(Debug, Clone, Copy, Default)]
pub struct Narrowed<'a> {
    /// Scenes; none means all.
    pub scenes: &'a [String],
    /// Structures, or labels of rows; none means all.
    pub structures: &'a [String],
    /// Rounds.
    pub rounds: Option<u32>,
    /// Time for all rounds.
    pub time_budget: Option<Duration>,
}

/// The record without the scenes and rows that are not wanted. The reference always stays.
///
/// # Errors
/// [`LikeError`] for a name that it lacks, and where nothing is left.
pub fn narrowed(record: &RunRecord, wanted: &Narrowed<'_>) -> Result<RunRecord, LikeError> {
    let mut record = record.clone();
    let names: Vec<&str> = record.scenes.iter().map(|s| &*s.name).collect();
    if names.is_empty() {
        return Err(LikeError::Empty);
    }
    for name in wanted.scenes {
        if !names.contains(&&**name) {
            return Err(unknown("scene", name, names));
        }
    }
    let is_wanted = |s: &SceneRecord| wanted.scenes.is_empty() || wanted.scenes.contains(&s.name);
    record.scenes.retain(is_wanted);
    record.planned.clear();
    let asked: Vec<String> = wanted.structures.iter().map(|s| s.replace(':', " ")).collect();
    let rows = || record.scenes.iter().flat_map(|s| &s.rows);
    for name in &asked {
        if !rows().any(|r| r.structure == *name || r.label() == *name) {
            let mut labels: Vec<String> = rows().map(|r| r.label()).collect();
            labels.dedup();
            return Err(unknown("row", name, labels.iter().map(|l| &**l).collect()));
        }
    }
    for scene in &mut record.scenes {
        scene.rows.retain(|row| {
            let is_asked = asked.contains(&row.structure) || asked.contains(&row.label());
            asked.is_empty() || is_asked || row.is_reference
        });
    }
    Ok(record)
}

fn unknown(what: &'static str, name: &str, valid: Vec<&str>) -> LikeError {
    LikeError::Unknown {
        what,
        name: name.to_owned(),
        hint: suggest::hint(name, valid.iter().copied()),
        valid: valid.join(", "),
    }
}

/// The plan that measures a record's scenes and rows anew, on the same rays.
///
/// # Errors
/// [`LikeError`] for settings that this program does not have, [`PlanError`] for scenes and
/// structures that it lacks.
pub fn plan<'r>(
    record: &RunRecord,
    wanted: &Narrowed<'_>,
    context: &Context<'r>,
) -> Result<Plan<'r>, Error> {
    let args = arguments(record, wanted).map_err(GateError::from)?;
    let mut plan = Plan::new(&args, context.registry, context.occluders, context.scenes)
        .or_else(|error| by_source(error, record, args, context))?;
    plan.strides = FixedStrides::of(record, 1);
    Ok(plan)
}

/// Scenes that came from files are known by the names of these; their paths are their sources.
fn by_source<'r>(
    error: PlanError,
    record: &RunRecord,
    mut args: RunArgs,
    context: &Context<'r>,
) -> Result<Plan<'r>, PlanError> {
    if !matches!(error, PlanError::Scene(_)) {
        return Err(error);
    }
    for (name, scene) in args.scenes.iter_mut().zip(&record.scenes) {
        if context.scenes.resolve(std::slice::from_ref(name)).is_err() {
            name.clone_from(&scene.source);
        }
    }
    // the name says more than the path
    let found = Plan::new(&args, context.registry, context.occluders, context.scenes);
    found.map_err(|_| error)
}

/// The command line of `run` that would measure the record's scenes and rows.
fn arguments(record: &RunRecord, wanted: &Narrowed<'_>) -> Result<RunArgs, LikeError> {
    let settings = &record.settings;
    let mut words: Vec<String> = ["rtbench", "run"].map(str::to_owned).into();
    let mut option = |name: &str, value: String| words.push(format!("--{name}={value}"));
    let mut labels: Vec<String> = Vec::new();
    for row in record.scenes.iter().flat_map(|s| &s.rows) {
        if !labels.contains(&row.label()) {
            labels.push(row.label());
        }
    }
    labels.into_iter().for_each(|label| option("structures", label));
    option("rays", settings.rays.join(","));
    option("order", settings.order.clone());
    option("lights", settings.lights.clone());
    option("threads", settings.threads.to_string());
    option("seed", settings.seed.to_string());
    option("reference", settings.reference.clone());
    option("precision", settings.precision.clone());
    let [width, height] = settings.resolution;
    if width != height {
        return Err(LikeError::Settings(format!("an image of {width} x {height} pixels")));
    }
    option("size", width.to_string());
    if let Some(rounds) = wanted.rounds {
        option("rounds", rounds.to_string());
    }
    if let Some(time) = wanted.time_budget {
        option("time-budget", format!("{}s", time.as_secs_f64()));
    }
    for setting in overrides_of_rays(record) {
        option("set", setting);
    }
    if settings.quick {
        words.push("--quick".into());
    }
    words.push("--".into());
    words.extend(record.scenes.iter().map(|scene| scene.name.clone()));
    run_arguments(words)
}

/// What `rtbench run` takes, from the words of a command line.
///
/// # Errors
/// [`LikeError::Settings`] where they are none of it.
pub fn run_arguments(words: Vec<String>) -> Result<RunArgs, LikeError> {
    match Cli::try_parse_from(words).map(|cli| cli.command) {
        Ok(Command::Run(args)) => Ok(args),
        Ok(_) => Err(LikeError::Settings("expected those of `run`".into())),
        Err(error) => Err(LikeError::Settings(error.to_string())),
    }
}

/// What the command line of a record sets of its rays: its settings do not say.
fn overrides_of_rays(record: &RunRecord) -> Vec<String> {
    let parsed = Cli::try_parse_from(&record.command_line).map(|cli| cli.command);
    let overrides = match parsed {
        Ok(Command::Run(args)) => args.overrides,
        Ok(Command::Baseline(args)) => match args.action {
            BaselineAction::Save(args) => args.run.overrides,
            _ => Vec::new(),
        },
        _ => Vec::new(),
    };
    overrides.into_iter().filter(|text| text.starts_with("rays.")).collect()
}
