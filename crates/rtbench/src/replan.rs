//! The plan that an earlier record was made by: its scenes, rows, rays, seed and arithmetic, or a
//! part of them.

use std::time::Duration;

use measurement::plan::Plan;
use measurement::plan::error::PlanError;
use measurement::plan::measured_row::select;
use measurement::plan::strides::FixedStrides;
use measurement::rays::order::Orders;
use measurement::record::{RunRecord, SceneRecord};
use measurement::settings::choice::Choice;
use measurement::settings::{Lights, MeasuringSettings, Precision, RunSettings, choice};

use crate::args::overrides_in;
use crate::context::Context;

#[derive(Debug, thiserror::Error)]
pub enum ReplanError {
    #[error("the baseline has no {what} '{name}'{hint}; it has: {valid}")]
    Unknown {
        /// `scene` or `row`.
        what: &'static str,
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    #[error("no scene could be measured: there is nothing to compare")]
    NothingMeasured,
    #[error("the baseline has no finished scene: there is nothing to compare with it")]
    Empty,
    #[error("row {row} belongs to the plugin {file}; give its file with --plugin")]
    NoPlugin { row: String, file: String },
    #[error("this program does not support the settings of the baseline: {0}")]
    Settings(String),
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// The record of these scenes, and of these structures or labels of rows, alone; none means all. The
/// reference always stays, and so do in all scenes the rows that took its place in any: the order of
/// rows says which of them does.
pub fn restrict(
    record: &RunRecord,
    wanted: &[String],
    structures: &[String],
) -> Result<RunRecord, ReplanError> {
    let mut record = record.clone();
    let names: Vec<&str> = record.scenes.iter().map(|s| &*s.name).collect();
    if names.is_empty() {
        return Err(ReplanError::Empty);
    }
    for name in wanted {
        if !names.contains(&&**name) {
            return Err(unknown("scene", name, names));
        }
    }
    let is_wanted = |s: &SceneRecord| wanted.is_empty() || wanted.contains(&s.name);
    record.scenes.retain(is_wanted);
    record.planned.clear();
    let asked: Vec<String> = structures.iter().map(|s| s.replace(':', " ")).collect();
    let rows = || record.scenes.iter().flat_map(|s| &s.rows);
    for name in &asked {
        if !rows().any(|r| r.structure == *name || r.label() == *name) {
            let labels = labels_of(&record);
            return Err(unknown("row", name, labels.iter().map(|l| &**l).collect()));
        }
    }
    let mut references = vec![record.settings.reference.clone()];
    references.extend(rows().filter(|r| r.is_reference).map(|r| r.label()));
    for scene in &mut record.scenes {
        scene.rows.retain(|row| {
            let is_asked = asked.contains(&row.structure) || asked.contains(&row.label());
            asked.is_empty() || is_asked || references.contains(&row.label())
        });
    }
    Ok(record)
}

fn unknown(what: &'static str, name: &str, valid: Vec<&str>) -> ReplanError {
    ReplanError::Unknown {
        what,
        name: name.to_owned(),
        hint: choice::hint(name, valid.iter().copied()),
        valid: valid.join(", "),
    }
}

/// The plan that measures a record's scenes and rows anew, on the same rays.
pub fn plan<'r>(
    record: &RunRecord,
    rounds: Option<u32>,
    time_budget: Option<Duration>,
    context: &Context<'r>,
) -> Result<Plan<'r>, ReplanError> {
    let is_there = |name: &str| context.registry.iter().any(|entry| entry.info.name == name);
    for row in record.scenes.iter().flat_map(|scene| &scene.rows) {
        if let Some(plugin) = row.plugin.as_ref().filter(|_| !is_there(&row.structure)) {
            let (row, file) = (row.structure.clone(), plugin.file.clone());
            return Err(ReplanError::NoPlugin { row, file });
        }
    }
    let mut settings = settings_of(record)?;
    (settings.measuring.rounds, settings.measuring.time_budget) = (rounds, time_budget);
    let mut plan = Plan::of_run(&settings, context.registry, context.occluders, context.scenes)
        .or_else(|error| by_source(error, record, settings, context))?;
    context.plugins.judge_nothing(&mut plan);
    plan.strides = FixedStrides::of(record, 1);
    plan.set_view(&record.settings.view);
    Ok(plan)
}

/// The record without the rows that this program does not know; rows of plugins stay. A reference
/// that is not known is another one.
pub fn restrict_to_known_rows(record: &RunRecord, context: &Context<'_>) -> RunRecord {
    let mut record = record.clone();
    let is_known =
        |label: &str| select(context.registry, context.occluders, &[label.to_owned()], &[]).is_ok();
    record.retain_rows(|_, row| row.plugin.is_some() || is_known(&row.label()));
    if !is_known(&record.settings.reference) {
        record.settings.reference.clear();
    }
    record
}

/// Scenes that came from files are known by the names of these; their paths are their sources.
fn by_source<'r>(
    error: PlanError,
    record: &RunRecord,
    mut settings: RunSettings,
    context: &Context<'r>,
) -> Result<Plan<'r>, PlanError> {
    if !matches!(error, PlanError::Scene(_)) {
        return Err(error);
    }
    for (name, scene) in settings.scenes.iter_mut().zip(&record.scenes) {
        if context.scenes.resolve(std::slice::from_ref(name)).is_err() {
            name.clone_from(&scene.source);
        }
    }
    // the name says more than the path
    let found = Plan::of_run(&settings, context.registry, context.occluders, context.scenes);
    found.map_err(|_| error)
}

/// The labels of all rows, each once.
fn labels_of(record: &RunRecord) -> Vec<String> {
    let mut labels: Vec<String> = Vec::new();
    for row in record.scenes.iter().flat_map(|s| &s.rows) {
        if !labels.contains(&row.label()) {
            labels.push(row.label());
        }
    }
    labels
}

/// Settings of a run that measures the record's scenes and rows.
fn settings_of(record: &RunRecord) -> Result<RunSettings, ReplanError> {
    let of = &record.settings;
    let [width, height] = of.resolution;
    if width != height {
        return Err(ReplanError::Settings(format!("an image of {width} x {height} pixels")));
    }
    let measuring = MeasuringSettings {
        rays: of.rays.clone(),
        order: choice::<Orders>("order", &of.order)?,
        lights: choice::<Lights>("lights", &of.lights)?,
        quick: of.quick,
        threads: within("threads", of.threads as u64, MeasuringSettings::MOST_THREADS.into())?,
        seed: of.seed,
        reference: Some(of.reference.clone()).filter(|reference| !reference.is_empty()),
        precision: choice::<Precision>("precision", &of.precision)?,
        size: Some(within("size", width.into(), MeasuringSettings::LARGEST_SIZE.into())?),
        ..MeasuringSettings::default()
    };
    Ok(RunSettings {
        scenes: record.scenes.iter().map(|scene| scene.name.clone()).collect(),
        structures: labels_of(record),
        // the record's settings do not say what was set of its rays
        overrides: overrides_in(&record.command_line)
            .into_iter()
            .filter(|text| text.starts_with("rays."))
            .collect(),
        measuring,
        processes: of.processes,
        ..RunSettings::default()
    })
}

/// The value of a setting as the record has it.
fn choice<T: Choice>(name: &str, text: &str) -> Result<T, ReplanError> {
    T::typed(text).ok_or_else(|| {
        let valid: Vec<&str> = T::ALL.iter().map(|(_, name, _)| *name).collect();
        ReplanError::Settings(format!("{name} {text}; valid: {}", valid.join(", ")))
    })
}

/// A number of the record, from 1 to `most`.
fn within<T: TryFrom<u64>>(name: &str, number: u64, most: u64) -> Result<T, ReplanError> {
    let is_valid = (1..=most).contains(&number);
    let number_in_range = T::try_from(number).ok().filter(|_| is_valid);
    number_in_range
        .ok_or_else(|| ReplanError::Settings(format!("{name} {number}; expected 1 to {most}")))
}
