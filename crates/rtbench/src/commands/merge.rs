//! `rtbench merge`: joins the parts of a run, and prints and exports it like a run.

use std::path::PathBuf;

use crate::args::{Color, MergeArgs};
use crate::commands::measuring::{PlanResults, exit_code, warn_of};
use crate::commands::run_outputs;
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::SUCCESS;
use crate::exports::measures::{self, Measure};
use crate::exports::outputs::OutputError;
use measurement::record::file::{self, RecordError};
use measurement::record::machines::over_machines;
use measurement::record::merge::{PartialRun, merge};
use measurement::system::files::write_text;
use presentation::json;
use studies::run::conclusions::conclude;
use studies::run::view::View;
use studies::run::{machines, text};

/// Merges and returns the exit code: that of the whole run.
pub fn run(context: &mut Context<'_>, args: &MergeArgs, color: Color) -> Result<u8, Error> {
    if args.machines {
        return machines_of(context, args, color);
    }
    let parts = read(args).collect();
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
    let view = View::on(context.terminal.screen(color));
    for scene in &record.scenes {
        warn_of(context, scene);
        text::write_scene(context.out, &record, scene, &view)?;
    }
    if !record.summary.is_empty() {
        text::write_end(context.out, &record, &view)?;
    }
    context.out.flush()?;
    Ok(exit_code(&PlanResults { record, failures: 0, disturbed: false }))
}

fn read(args: &MergeArgs) -> impl Iterator<Item = Result<PartialRun, RecordError>> {
    let read = |path: &PathBuf| Ok(PartialRun { record: file::read(path)?, path: path.clone() });
    args.parts.iter().map(read)
}

/// The record's file in the folder of `-o`, where `rtbench report` finds it.
pub const NAME: &str = "machines.json";

/// Joins, prints and writes; returns the exit code.
fn machines_of(context: &mut Context<'_>, args: &MergeArgs, color: Color) -> Result<u8, Error> {
    let runs = read(args).collect::<Result<Vec<_>, _>>()?;
    let record = over_machines(&runs, &context.command_line)?;
    let names = [NAME, "machines.csv", "machines.md"];
    let _created = context.created_folder(args.exports.output.as_ref(), &names)?;
    if let Some(folder) = &args.exports.output {
        write_text(&folder.join(NAME), &json::written(&record)?)?;
        write_text(&folder.join("machines.csv"), &machines::csv(&record)?)?;
        write_text(&folder.join("machines.md"), &machines::markdown(&record)?)?;
    }
    context.terminal.screen(color).write_table(context.out, &machines::table(&record))?;
    context.out.flush()?;
    Ok(SUCCESS)
}
