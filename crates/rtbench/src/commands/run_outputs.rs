//! The files that `rtbench run` writes: one line a format.

use std::path::{Path, PathBuf};

use measurement::journal;
use measurement::journal::lines::Manifest;
use measurement::plan::Plan;
use measurement::record::{RunRecord, file};
use measurement::system::files::CreatedFiles;
use presentation::json;
use presentation::json::FormatError;
use studies::run::markdown;

use crate::args::ExportArgs;
use crate::context::Context;
use crate::measures::{self, Select};
use crate::outputs::{OccupiedError, OutputError, Outputs, PlannedOutput};

/// The text of what is finished so far.
type Format = fn(&RunRecord) -> Result<String, FormatError>;
/// The same of the series that are selected.
type SeriesFormat = fn(&RunRecord, Select<'_>) -> Result<String, FormatError>;

/// The files in the folder of `-o`, the record first: it says of which run the files beside it are,
/// also when the program is killed between the first two.
static IN_FOLDER: [(&str, Format); 3] = [
    (file::NAME, json::written),
    ("results.csv", markdown::to_csv),
    ("results.md", |run| Ok(markdown::to_string(run))),
];

/// The files of services that keep time series.
fn series(args: &ExportArgs) -> [(&Option<PathBuf>, SeriesFormat); 3] {
    [
        (&args.export_github_smaller, measures::smaller),
        (&args.export_github_bigger, measures::bigger),
        (&args.export_bencher, measures::bencher),
    ]
}

pub fn named(args: &ExportArgs) -> Vec<PathBuf> {
    series(args).into_iter().filter_map(|(path, _)| path.clone()).collect()
}

/// Refuses a folder of `-o` that holds other results, unless they may be replaced.
pub fn refuse_occupied(
    context: &Context<'_>,
    args: &ExportArgs,
    manifest: Option<&Manifest>,
) -> Result<(), OccupiedError> {
    let Some(folder) = &args.output else { return Ok(()) };
    let names = IN_FOLDER.map(|(name, _)| name);
    let (command_line, overwrite) = (&*context.command_line, context.overwrite);
    PlannedOutput { names: &names, command_line, manifest, overwrite }.check(folder)
}

/// Files that are written to a folder of `-o`, including the journal of a run.
pub fn files_in(folder: &Path) -> Vec<PathBuf> {
    let names = IN_FOLDER.iter().map(|(name, _)| *name);
    names.chain([journal::NAME]).map(|name| folder.join(name)).collect()
}

/// Refuses a selection of series that finds none of those that a plan will have.
pub fn refuse_unselected(args: &ExportArgs, plan: &Plan<'_>) -> Result<(), OutputError> {
    let Some(select) = &args.export_select else { return Ok(()) };
    let all = measures::series_of(plan);
    if all.iter().any(|series| select.is_match(series)) {
        Ok(())
    } else {
        let example = all.first().cloned().unwrap_or_default();
        Err(OutputError::NothingSelected(select.as_str().to_owned(), example))
    }
}

/// Creates the files that the command line of a run names.
pub fn of_run(args: &ExportArgs) -> Result<Outputs<'static>, OutputError> {
    let mut created = CreatedFiles::default();
    args.output.iter().try_for_each(|folder| created.folder(folder))?;
    let mut outputs = Outputs::new(args.output.clone(), created);
    for (name, format) in IN_FOLDER {
        outputs.add_in_folder(name, format)?;
    }
    for (path, format) in series(args) {
        let select = args.export_select.clone();
        outputs.add(path.clone(), move |run| format(run, select.as_ref()))?;
    }
    Ok(outputs)
}
