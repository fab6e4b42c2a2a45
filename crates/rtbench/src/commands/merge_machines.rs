//! `rtbench merge --machines`: the same run on several machines, side by side.

use crate::args::{Color, MergeArgs};
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::SUCCESS;
use crate::exports::outputs::write_file;
use measurement::record::file;
use measurement::record::machines::over_machines;
use measurement::record::merge::Part;
use measurement::system::created::{Created, create};
use presentation::{json, text};
use studies::run::machines;

/// The record's file in the folder of `-o`, where `rtbench report` finds it.
pub const NAME: &str = "machines.json";

/// Joins, prints and writes; returns the exit code.
///
/// # Errors
/// [`Error`] for runs that cannot be read or are not the same, and for outputs.
pub fn run(context: &mut Context<'_>, args: &MergeArgs, color: Color) -> Result<u8, Error> {
    let read = |path: &std::path::PathBuf| {
        Ok::<_, Error>(Part { record: file::read(path)?, path: path.clone() })
    };
    let runs = args.parts.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let record = over_machines(&runs, &context.command_line)?;
    let mut folders = Created::default();
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
    let colors = context.terminal.colors(color);
    text::write_table(context.out, &machines::table(&record), colors)?;
    context.out.flush()?;
    Ok(SUCCESS)
}
