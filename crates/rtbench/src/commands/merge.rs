//! `rtbench merge`: the parts of a run, printed and exported like a run.

use std::path::PathBuf;

use crate::args::{Color, MergeArgs};
use crate::commands::measuring::{PlanResults, exit_code, warn_of};
use crate::commands::run_outputs::{self, Measure};
use crate::context::Context;
use crate::error::Error;
use crate::outputs::OutputError;
use measurement::record::file;
use measurement::record::merge::{self, PartialRun};
use studies::run::conclusions::conclude;
use studies::run::output;
use studies::run::view::View;

/// Merges and returns the exit code: that of the whole run.
pub fn run(context: &mut Context<'_>, args: &MergeArgs, color: Color) -> Result<u8, Error> {
    let read = |path: &PathBuf| Ok(PartialRun { record: file::read(path)?, path: path.clone() });
    let parts = args.parts.iter().map(read).collect();
    run_outputs::refuse_occupied(context, &args.exports, None)?;
    let mut record = merge::merge(parts, args.mixed_machines)?;
    if let Some(select) = &args.exports.export_select
        && run_outputs::costs(&record, Some(select)).is_empty()
        && run_outputs::rates(&record, Some(select)).is_empty()
    {
        let example = run_outputs::costs(&record, None).first().map(Measure::series);
        let (select, example) = (select.as_str().to_owned(), example.unwrap_or_default());
        return Err(OutputError::NothingSelected(select, example).into());
    }
    conclude(&mut record);
    record.command_line = context.command_line.clone();
    // not before: parts that do not fit leave no empty files
    let mut outputs = run_outputs::of_run(&args.exports)?;
    outputs.write(&record, true)?;
    let view = View::on(context.terminal.screen(color));
    for scene in &record.scenes {
        warn_of(context, scene);
        output::write_scene(context.out, &record, scene, &view)?;
    }
    if !record.summary.is_empty() {
        output::write_end(context.out, &record, &view)?;
    }
    context.out.flush()?;
    Ok(exit_code(&PlanResults { record, failures: 0, disturbed: false }))
}
