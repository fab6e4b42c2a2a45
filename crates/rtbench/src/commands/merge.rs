//! `rtbench merge`: joins the parts of a run, and prints and exports it like a run.

use std::path::Path;

use crate::args::{Color, MergeArgs};
use crate::commands::measuring::{Measured, exit_code, warn_of};
use crate::commands::{merge_machines, run_outputs};
use crate::context::Context;
use crate::error::Error;
use measurement::record::file;
use measurement::record::merge::{MergeError, MergeProblem, Part, merge};
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
    if let Some(folder) = &args.exports.output
        && args.parts.iter().any(|part| is_in(part, folder))
    {
        let problems = vec![MergeProblem::Overwrites { folder: folder.clone() }];
        return Err(MergeError { problems }.into());
    }
    run_outputs::refuse_occupied(context, &args.exports, None)?;
    let mut record = merge(parts, args.mixed_machines)?;
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

/// Whether a part, a file or its folder, lies in that folder.
fn is_in(part: &Path, folder: &Path) -> bool {
    let place = |path: &Path| path.canonicalize().ok();
    let part = if part.is_dir() { place(part) } else { part.parent().and_then(place) };
    part.is_some() && part == place(folder)
}
