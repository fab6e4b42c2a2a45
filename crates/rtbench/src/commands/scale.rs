//! `rtbench scale`: measure one scene in several sizes, print, export, plot.

use std::ffi::OsString;

use crate::args::{Color, ScaleArgs};
use crate::commands::measuring::{Kept, begin, exit_code, measure_rest, warn_of};
use crate::commands::run::{Begun, go_on, journal_in, watch};
use crate::context::Context;
use crate::error::Error;
use crate::export::files::Outputs;
use crate::export::{json, scale_csv, scale_plot, scale_table};
use crate::record::RunRecord;
use crate::scale::Scale;

/// Measures and returns the exit code. `arguments` are those of the process, program first.
///
/// # Errors
/// [`Error`] for what ends the run early: the command line, an output.
pub fn run(
    context: &mut Context<'_>,
    args: &ScaleArgs,
    color: Color,
    arguments: &[OsString],
) -> Result<u8, Error> {
    let scale = Scale::new(args, context.registry, context.occluders, context.scenes)?;
    let record = begun(context, &scale);
    let mut kept = Kept::default();
    let outputs = outputs(args)?;
    if let Some(folder) = &args.output {
        kept.journal = Some(journal_in(context, folder, &scale.plan, &record, arguments)?);
    }
    watch(&kept, args.output.as_deref(), scale.plan.scenes.len())?;
    measure(context, color, &scale, outputs, kept, record)
}

/// Finishes what was begun in the folder of `-o`.
///
/// # Errors
/// Those of [`run`], and for a run that would not be the same.
pub(super) fn resume(
    context: &mut Context<'_>,
    args: &ScaleArgs,
    color: Color,
    begun_before: Begun<'_>,
) -> Result<u8, Error> {
    let args = ScaleArgs { output: Some(begun_before.folder.to_owned()), ..args.clone() };
    let scale = Scale::new(&args, context.registry, context.occluders, context.scenes)?;
    let record = begun(context, &scale);
    let (kept, record) = go_on(context, begun_before, &scale.plan, record)?;
    let outputs = outputs(&args)?;
    watch(&kept, args.output.as_deref(), scale.plan.scenes.len())?;
    measure(context, color, &scale, outputs, kept, record)
}

/// The record before the first size.
fn begun(context: &Context<'_>, scale: &Scale<'_>) -> RunRecord {
    RunRecord { scale: Some(scale.record.clone()), ..begin(context, &scale.plan) }
}

fn measure(
    context: &mut Context<'_>,
    color: Color,
    scale: &Scale<'_>,
    mut outputs: Outputs<'static>,
    kept: Kept,
    record: RunRecord,
) -> Result<u8, Error> {
    let colors = context.terminal.colors(color);
    let has_tables = !outputs.are_printed();
    let measured =
        measure_rest(context, &scale.plan, &mut outputs, kept, record, |context, run, scene| {
            warn_of(context, scene);
            if has_tables {
                scale_table::write_size(context.out, run, scene, colors)?;
                context.out.flush()?;
            }
            Ok(())
        })?;
    if has_tables && !measured.record.scenes.is_empty() {
        scale_table::write_slopes(context.out, &measured.record, colors)?;
        context.out.flush()?;
    }
    Ok(exit_code(&measured))
}

/// The files that the command line names, and those of its folder.
fn outputs(args: &ScaleArgs) -> Result<Outputs<'static>, Error> {
    let mut outputs = Outputs::default();
    if let Some(folder) = &args.output {
        outputs.folder(folder)?;
    }
    let within = |name| args.output.as_ref().map(|folder| folder.join(name));
    for path in [within("results.json"), args.export_json.clone()] {
        outputs.add(path.as_ref(), json::to_string)?;
    }
    for path in [within("scale.csv"), args.export_csv.clone()] {
        outputs.add(path.as_ref(), scale_csv::sizes)?;
    }
    for path in [within("slopes.csv"), args.export_slopes.clone()] {
        outputs.add(path.as_ref(), scale_csv::slopes)?;
    }
    for path in [within("scale.md"), args.export_markdown.clone()] {
        outputs.add(path.as_ref(), |run| Ok(scale_table::to_markdown(run)))?;
    }
    for path in [within("scale.svg"), args.export_svg.clone()] {
        outputs.add(path.as_ref(), |run| Ok(scale_plot::to_svg(run)))?;
    }
    Ok(outputs)
}
