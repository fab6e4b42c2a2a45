//! `rtbench sweep`: measure one parameter over its values, print, export, plot.

use crate::args::{Color, SweepArgs};
use crate::commands::measuring::{exit_code, measure_scenes, warn_of};
use crate::context::Context;
use crate::error::Error;
use crate::export::files::Outputs;
use crate::export::{json, sweep_csv, sweep_plot, sweep_table};
use crate::sweep::Sweep;

/// Sweeps and returns the exit code.
///
/// # Errors
/// [`Error`] for what ends the sweep early: the command line, an output.
pub fn run(context: &mut Context<'_>, args: &SweepArgs, color: Color) -> Result<u8, Error> {
    let sweep = Sweep::new(args, context.registry, context.scenes)?;
    let colors = context.terminal.colors(color);
    let mut outputs = Outputs::default();
    outputs.add(args.export_csv.as_ref(), |run| sweep_csv::to_string(&sweep, run))?;
    outputs.add(args.export_svg.as_ref(), |run| Ok(sweep_plot::to_svg(&sweep, run)))?;
    outputs.add(args.export_markdown.as_ref(), |run| Ok(sweep_table::to_markdown(&sweep, run)))?;
    outputs.add(args.export_json.as_ref(), json::to_string)?;
    let has_tables = !outputs.are_printed();
    let measured = measure_scenes(context, &sweep.plan, &mut outputs, |context, run, scene| {
        warn_of(context, scene);
        if has_tables {
            sweep_table::write(context.out, &sweep, run, scene, colors)?;
            context.out.flush()?;
        }
        Ok(())
    })?;
    if has_tables && !measured.record.scenes.is_empty() {
        sweep_table::write_glossary(context.out, colors)?;
        context.out.flush()?;
    }
    Ok(exit_code(&measured))
}
