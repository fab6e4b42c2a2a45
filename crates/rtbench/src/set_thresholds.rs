//! Thresholds that a set file has for rows and kinds of rays (`check` in `scenes/sets/*.json`).

use crate::args::percent;
use crate::context::Context;
use crate::gate::thresholds::{RowThreshold, quantity_named};
use crate::set_options::without;
use measurement::plan::error::PlanError;
use measurement::plan::measured_row::select;
use measurement::scenes::SetThreshold;

/// The thresholds of the set that a check names: by `--as`, or as its only scene.
pub fn of_check(
    context: &Context<'_>,
    as_set: Option<&str>,
    scenes: &[String],
) -> Result<Vec<RowThreshold>, PlanError> {
    let set = match (as_set, scenes) {
        (Some(set), _) => set,
        (None, [only]) => only,
        _ => return Ok(Vec::new()),
    };
    let entries = context.scenes.check_thresholds(set)?;
    if entries.is_empty() && as_set.is_some() {
        let has = |set: &str| Ok(!context.scenes.check_thresholds(set)?.is_empty());
        return Err(without("set with thresholds of its own", set, context.scenes, has)?);
    }
    let read = |(entry, own): (usize, &SetThreshold)| {
        let place = format!("scenes/sets/{set}.json: check, entry {entry}");
        threshold(context, own).map_err(|why| PlanError::Invalid(format!("{place}: {why}")))
    };
    (1..).zip(&entries).map(read).collect()
}

/// Reads an entry, or describes its fault.
fn threshold(context: &Context<'_>, entry: &SetThreshold) -> Result<RowThreshold, String> {
    let row = entry.row.as_deref().map(|text| row(context, text)).transpose()?;
    let of = entry.of.as_deref().map(quantity_named).transpose()?;
    let read = |name: &str, text: &Option<String>| {
        let read = text.as_deref().map(percent).transpose();
        read.map_err(|why| format!("{name}: {why}"))
    };
    let time = read("time-threshold", &entry.time_threshold)?;
    let instructions = read("instruction-threshold", &entry.instruction_threshold)?;
    if time.is_none() && instructions.is_none() {
        return Err("expected a time-threshold or an instruction-threshold".into());
    }
    if row.is_none() && of.is_none() {
        return Err("expected a row or a quantity (of); -t is the threshold of all".into());
    }
    let threshold = RowThreshold { row, of, time, instructions };
    match threshold.kind() {
        Some(kind) if instructions.is_some() => Err(format!(
            "instruction-threshold: instructions of {kind} rays are not counted separately"
        )),
        _ => Ok(threshold),
    }
}

/// A structure, or the label of a row.
fn row(context: &Context<'_>, text: &str) -> Result<String, String> {
    let named = [text.to_owned()];
    let (structures, occluders) = select(context.registry, context.occluders, &named, &[])
        .map_err(|error| error.to_string())?;
    if !text.contains([':', ' ']) {
        return Ok(text.to_owned());
    }
    let labels = structures.iter().map(|row| row.label());
    let mut labels = labels.chain(occluders.iter().map(|row| row.label()));
    labels.next().ok_or_else(|| format!("{text}: no row"))
}
