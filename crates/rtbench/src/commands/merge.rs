//! `rtbench merge`: joins the parts of a run, and prints and exports it like a run.

use crate::args::{Color, MergeArgs};
use crate::commands::measuring::{Measured, exit_code, warn_of};
use crate::commands::{merge_machines, run_outputs};
use crate::context::Context;
use crate::error::Error;
use crate::exports::measures::{self, Measure};
use crate::exports::outputs::OutputError;
use measurement::record::file;
use measurement::record::merge::{Part, merge};
use studies::run::conclusions::conclude;
use studies::run::text;

/// Merges and returns the exit code: that of the whole run.
///
/// # Errors
/// [`Error`] for parts that cannot be read or joined, and for outputs.
pub fn run(context: &mut Context<'_>, args: &MergeArgs, color: Color) -> Result<u8, Error> {
    if args.machines {
        return merge_machines::run(context, args, color);
    }
    let mut parts = Vec::with_capacity(args.parts.len());
    for path in &args.parts {
        parts.push(Part { record: file::read(path)?, path: path.clone() });
    }
    run_outputs::refuse_occupied(context, &args.exports, None)?;
    let mut record = merge(parts, args.mixed_machines)?;
    if let Some(select) = &args.exports.export_select
        && measures::costs(&record, Some(select)).is_empty()
        && measures::rates(&record, Some(select)).is_empty()
    {
        let example = measures::costs(&record, None).first().map(Measure::series);
        let (select, example) = (select.as_str().to_owned(), example.unwrap_or_default());
        return Err(OutputError::NothingSelected(select, example).into());
    }
    conclude(&mut record);
    record.command_line = context.command_line.clone();
    // not before: parts that do not fit leave no empty files
    let mut outputs = run_outputs::of_run(&args.exports)?;
    outputs.write(&record, true)?;
    outputs.print(&record, context.out)?;
    let view = args.tables.view(context.terminal.width(), context.terminal.colors(color));
    for scene in &record.scenes {
        warn_of(context, scene);
        if !outputs.are_printed() {
            text::write_scene(context.out, &record, scene, &view)?;
        }
    }
    if !outputs.are_printed() && !record.summary.is_empty() {
        text::write_end(context.out, &record, &view)?;
    }
    context.out.flush()?;
    Ok(exit_code(&Measured { record, failures: 0, disturbed: false }))
}
