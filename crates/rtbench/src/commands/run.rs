//! `rtbench run`: measure, print, export.

use crate::args::{Color, RunArgs};
use crate::commands::measuring::{exit_code, measure_scenes, warn_of};
use crate::context::Context;
use crate::error::Error;
use crate::export::files::Outputs;
use crate::export::text;
use crate::plan::Plan;

/// Runs and returns the exit code.
///
/// # Errors
/// [`Error`] for what ends the run early: the command line, a scene, an output.
pub fn run(context: &mut Context<'_>, args: &RunArgs, color: Color) -> Result<u8, Error> {
    let plan = Plan::new(args, context.registry, context.occluders, context.scenes)?;
    let colors = context.terminal.colors(color);
    let mut outputs = Outputs::of_run(args)?;
    let measured = measure_scenes(context, &plan, &mut outputs, |context, record, scene| {
        warn_of(context, scene);
        text::write_scene(context.out, record, scene, colors)?;
        context.out.flush()?;
        Ok(())
    })?;
    if !measured.record.summary.is_empty() {
        text::write_summary(context.out, &measured.record, colors)?;
        context.out.flush()?;
    }
    Ok(exit_code(&measured))
}
