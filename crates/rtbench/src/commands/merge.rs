//! `rtbench merge`: the parts of a run, printed and exported like a run.

use std::path::PathBuf;

use crate::args::MergeArgs;
use crate::commands::measuring::{PlanResults, exit_code, warn_of};
use crate::commands::run_outputs;
use crate::context::Context;
use crate::error::Error;
use measurement::record::file;
use measurement::record::merge::{self, PartialRun};
use studies::run::conclusions::conclude;
use studies::run::output;
use studies::run::view::View;

/// Merges and returns the exit code: that of the whole run.
pub fn run(context: &mut Context<'_>, args: &MergeArgs) -> Result<u8, Error> {
    let read = |path: &PathBuf| Ok(PartialRun { record: file::read(path)?, path: path.clone() });
    let parts = args.parts.iter().map(read).collect();
    run_outputs::refuse_occupied(context, &args.exports, None)?;
    let mut record = merge::merge(parts, args.mixed_machines)?;
    run_outputs::refuse_unselected(&args.exports, || run_outputs::series_in(&record))?;
    conclude(&mut record);
    record.command_line = context.command_line.clone();
    // not before: parts that do not fit leave no empty files
    let mut outputs = run_outputs::of_run(&args.exports)?;
    outputs.write(&record, true)?;
    let view = View::on(context.screen());
    for scene in &record.scenes {
        warn_of(context, scene);
        output::write_scene(context.out, &record, scene, &view)?;
    }
    if !record.summary.is_empty() {
        output::write_end(context.out, &record, &view)?;
    }
    Ok(exit_code(&PlanResults { record, failures: 0, disturbed: false }))
}
