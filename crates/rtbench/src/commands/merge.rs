//! `rtbench merge`: joins the parts of a run, and prints and exports it like a run.

use crate::args::{Color, MergeArgs};
use crate::commands::measuring::{PlanResults, exit_code, warn_of};
use crate::commands::run_outputs;
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::SUCCESS;
use crate::exports::measures::{self, Measure};
use crate::exports::outputs::{OutputError, write_file};
use measurement::record::file;
use measurement::record::machines::over_machines;
use measurement::record::merge::{PartialRun, merge};
use measurement::system::created::{CreatedFiles, create};
use presentation::json;
use studies::run::conclusions::conclude;
use studies::run::{machines, text};

/// Merges and returns the exit code: that of the whole run.
///
/// # Errors
/// [`Error`] for parts that cannot be read or joined, and for outputs.
pub fn run(context: &mut Context<'_>, args: &MergeArgs, color: Color) -> Result<u8, Error> {
    if args.machines {
        return machines_of(context, args, color);
    }
    let parts = args.parts.iter();
    let read = parts.map(|path| Ok(PartialRun { record: file::read(path)?, path: path.clone() }));
    let parts = read.collect();
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
    let view = args.tables.view(context.terminal.screen(color));
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
    Ok(exit_code(&PlanResults { record, failures: 0, disturbed: false }))
}

/// The record's file in the folder of `-o`, where `rtbench report` finds it.
pub const NAME: &str = "machines.json";

/// Joins, prints and writes; returns the exit code.
///
/// # Errors
/// [`Error`] for runs that cannot be read or are not the same, and for outputs.
fn machines_of(context: &mut Context<'_>, args: &MergeArgs, color: Color) -> Result<u8, Error> {
    let read = |path: &std::path::PathBuf| {
        Ok::<_, Error>(PartialRun { record: file::read(path)?, path: path.clone() })
    };
    let runs = args.parts.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let record = over_machines(&runs, &context.command_line)?;
    let mut folders = CreatedFiles::default();
    let exports = &args.exports;
    if let Some(folder) = &exports.output {
        folders.folder(folder)?;
    }
    let in_folder = |name: &str| exports.output.as_ref().map(|folder| folder.join(name));
    let wanted = [
        [in_folder(NAME), exports.export_json.clone()],
        [in_folder("machines.csv"), exports.export_csv.clone()],
        [in_folder("machines.md"), exports.export_markdown.clone()],
    ];
    let _created = create(wanted.iter().flatten())?;
    for (format, paths) in wanted.iter().enumerate() {
        for path in paths.iter().flatten() {
            write_file(Some(path), || match format {
                0 => json::written(&record),
                1 => machines::csv(&record),
                _ => machines::markdown(&record),
            })?;
        }
    }
    context.terminal.screen(color).write_table(context.out, &machines::table(&record))?;
    context.out.flush()?;
    Ok(SUCCESS)
}
