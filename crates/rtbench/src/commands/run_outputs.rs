//! The files that `rtbench run` writes: one line a format.

use std::path::{Path, PathBuf};

use measurement::journal;
use measurement::journal::lines::Manifest;
use measurement::plan::Plan;
use measurement::record::{RunRecord, file};
use presentation::json;
use presentation::json::FormatError;
use scene_loading::source_names::name_of_path;
use studies::run::markdown;

use crate::args::ExportArgs;
use crate::context::Context;
use crate::exports::measures::{self, Select};
use crate::exports::occupied::{OccupiedError, PlannedOutput};
use crate::exports::outputs::{OutputError, Outputs};
use crate::exports::{bencher, github_action_benchmark};

/// A format that the record of a run is written in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exporter {
    /// Path given on the command line.
    pub path: fn(&ExportArgs) -> Option<&PathBuf>,
    /// The file's name in the folder of `-o`, if it is written there.
    pub in_folder: Option<&'static str>,
    /// The text of what is finished so far, or of the series of it that are selected.
    pub to_string: fn(&RunRecord, Select<'_>) -> Result<String, FormatError>,
}

/// All formats, the record first: it says of which run the files beside it are, also when the
/// program is killed between the first two.
static EXPORTERS: [Exporter; 6] = [
    exporter(|args| args.export_json.as_ref(), Some(file::NAME), |run, _| json::written(run)),
    exporter(|args| args.export_csv.as_ref(), Some("results.csv"), |run, _| markdown::to_csv(run)),
    exporter(
        |args| args.export_markdown.as_ref(),
        Some("results.md"),
        |run, _| Ok(markdown::to_string(run)),
    ),
    exporter(|args| args.export_github_smaller.as_ref(), None, github_action_benchmark::smaller),
    exporter(|args| args.export_github_bigger.as_ref(), None, github_action_benchmark::bigger),
    exporter(|args| args.export_bencher.as_ref(), None, bencher::to_string),
];

const fn exporter(
    path: fn(&ExportArgs) -> Option<&PathBuf>,
    in_folder: Option<&'static str>,
    to_string: fn(&RunRecord, Select<'_>) -> Result<String, FormatError>,
) -> Exporter {
    Exporter { path, in_folder, to_string }
}

/// Refuses a folder of `-o` that holds other results, unless they may be replaced.
pub fn refuse_occupied(
    context: &Context<'_>,
    args: &ExportArgs,
    manifest: Option<&Manifest>,
) -> Result<(), OccupiedError> {
    let Some(folder) = &args.output else { return Ok(()) };
    let names: Vec<&str> = EXPORTERS.iter().filter_map(|e| e.in_folder).collect();
    let (command_line, overwrite) = (&*context.command_line, context.overwrite);
    PlannedOutput { names: &names, command_line, manifest, overwrite }.check(folder)
}

/// Files that are written to a folder of `-o`, including the journal of a run.
pub fn files_in(folder: &Path) -> Vec<PathBuf> {
    let names = EXPORTERS.iter().filter_map(|exporter| exporter.in_folder);
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

/// The files that a run is begun with, beside those in its folder.
pub fn named(args: &ExportArgs) -> Vec<String> {
    let paths = EXPORTERS.iter().filter_map(|e| (e.path)(args));
    paths
        .filter(|path| path.as_os_str() != "-")
        .map(|path| name_of_path(path.as_os_str()))
        .collect()
}

/// Creates the files that the command line of a run names.
///
/// # Errors
/// [`OutputError::Write`] naming the file or folder, [`OutputError::OneStdout`].
pub fn of_run(args: &ExportArgs) -> Result<Outputs<'static>, OutputError> {
    let mut outputs = Outputs::default();
    if let Some(folder) = &args.output {
        outputs.folder(folder)?;
        for exporter in &EXPORTERS {
            let path = exporter.in_folder.map(|name| folder.join(name));
            outputs.add(path.as_ref(), text_of(exporter, args))?;
        }
    }
    for exporter in &EXPORTERS {
        outputs.add((exporter.path)(args), text_of(exporter, args))?;
    }
    Ok(outputs)
}

/// Text of an exporter for a run, limited to the selected series.
fn text_of(
    exporter: &Exporter,
    args: &ExportArgs,
) -> impl Fn(&RunRecord) -> Result<String, FormatError> + use<> {
    let (to_string, select) = (exporter.to_string, args.export_select.clone());
    move |run| to_string(run, select.as_ref())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_is_the_first_file_of_a_folder() {
        let first = EXPORTERS.iter().find_map(|exporter| exporter.in_folder);
        assert_eq!(first, Some(file::NAME));
    }
}
