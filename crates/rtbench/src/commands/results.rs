//! Commands that read recorded results: `rtbench compare` (two or more runs side by side), `rtbench
//! history` (the results that CI keeps, as a static site), `rtbench merge` (the parts of a run, printed
//! and exported like a run) and `rtbench report` (the results in folders as one page).

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use regex_lite::Regex;

use crate::args::{Color, CompareArgs, CompareFormat, HistoryArgs, MergeArgs, ReportArgs};
use crate::commands::measuring::{PlanResults, exit_code, warn_of};
use crate::commands::render::scene_pictures;
use crate::commands::run_outputs::{self, Measure};
use crate::comparison::{
    self, CompareError, Comparison, ComparisonSettings, NamedRun, default_metrics, renamed, tables,
};
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use crate::history::{History, site, visits};
use crate::outputs::{OutputError, refuse_files};
use crate::report::material::Material;
use crate::report::{is_page, page};
use measurement::record::file;
use measurement::record::merge::{self, PartialRun};
use measurement::record::metrics::{self, METRICS};
use measurement::system::files::{WriteError, write_text};
use measurement::system::progress::Progress;
use presentation::json;
use statistics::change_points::Sensitivity;
use studies::run::conclusions::conclude;
use studies::run::output;
use studies::run::view::View;

/// Prints. What changed is no failure: `rtbench check` is the gate.
pub fn compare(context: &mut Context<'_>, args: &CompareArgs, color: Color) -> Result<u8, Error> {
    let choice = choice(args)?;
    let mut runs =
        args.results.iter().map(|path| file::read(path)).collect::<Result<Vec<_>, _>>()?;
    let mut matched = Vec::new();
    if let Some((old, others)) = runs.split_first_mut() {
        for text in &args.matches {
            matched.push(renamed::matched(text, old, others)?);
        }
        matched.iter().for_each(|renamed| renamed.apply(old));
    }
    let paths: Vec<String> = args.results.iter().map(|p| p.display().to_string()).collect();
    let letters: Vec<String> = (0..runs.len()).map(letter).collect();
    let all = letters.iter().zip(&paths).zip(&runs);
    let mut named = all.map(|((letter, path), run)| NamedRun { letter, path, run });
    let mut comparisons = Vec::new();
    if let Some(old) = named.next() {
        for new in named {
            comparisons.push(comparison::compare(old, new, &choice)?);
        }
    }
    for comparison in &mut comparisons {
        warn_of_comparison(context, comparison);
        comparison.notes.extend(matched.iter().map(ToString::to_string));
    }
    match args.format {
        CompareFormat::Text => {
            tables::write(context.out, &comparisons, context.terminal.screen(color))?;
        }
        CompareFormat::Markdown => write!(context.out, "{}", tables::to_markdown(&comparisons))?,
        CompareFormat::Csv => write!(context.out, "{}", tables::to_csv(&comparisons)?)?,
        CompareFormat::Json => write!(context.out, "{}", json::written(&comparisons)?)?,
    }
    context.out.flush()?;
    Ok(SUCCESS)
}

fn choice(args: &CompareArgs) -> Result<ComparisonSettings, Error> {
    let filter = |text: &String| {
        let error = |message| CompareError::Filter { filter: text.clone(), message };
        Regex::new(text).map_err(|e| error(e.to_string()))
    };
    let metrics = match &args.metrics[..] {
        [] => default_metrics(),
        names if names.iter().any(|name| name == "all") => METRICS.iter().collect(),
        names => names.iter().map(|name| metrics::named(name)).collect::<Result<_, _>>()?,
    };
    Ok(ComparisonSettings {
        metrics,
        shows_equal: !args.metrics.is_empty(),
        filter: args.filter.as_ref().map(filter).transpose()?,
        margin: args.margin,
        threshold: args.threshold,
        is_forced: args.force,
    })
}

/// `A`, `B`, ..., `Z`, `AA`, ...
fn letter(place: usize) -> String {
    let last = char::from(b'A' + (place % 26) as u8);
    match place / 26 {
        0 => last.to_string(),
        more => letter(more - 1) + &last.to_string(),
    }
}

/// Warns on standard error, as the output may go to a file.
fn warn_of_comparison(context: &mut Context<'_>, comparison: &Comparison) {
    for note in &comparison.notes {
        context.warn(note);
    }
    for row in &comparison.answers_changed {
        context.warn(format_args!(
            "ANSWERS CHANGED: {row}: {} and {} hit differently for the same rays; `rtbench \
             verify` tells which is right",
            comparison.old.letter, comparison.new.letter
        ));
    }
}

/// Seed of the permutation tests: the same runs make the same site.
const SITE_SEED: u64 = 1;

/// Reads what is there, writes every page, and says what changed.
pub fn history(context: &mut Context<'_>, args: &HistoryArgs) -> Result<(), Error> {
    let visits = visits(&args.folders, args.repository.as_deref())?;
    let index = args.output.join("index.html");
    // an earlier site is replaced, nothing else is
    let is_ours = fs::read_to_string(&index).is_ok_and(|text| is_page(&text));
    if !context.overwrite && !is_ours {
        refuse_files([index])?;
    }
    let history = History::new(visits, &Sensitivity::default(), SITE_SEED);
    let files = site(&history);
    for (path, page) in &files {
        let path = args.output.join(path);
        let folder = path.parent().unwrap_or(Path::new(""));
        let failed = |source| WriteError { path: folder.to_owned(), source };
        fs::create_dir_all(folder).map_err(failed)?;
        write_text(&path, page)?;
    }
    let (runs, changes) = (history.visits.len(), history.changes().count());
    let pages = files.len();
    let what = format_args!("{pages} pages of {runs} runs; {changes} changes found");
    context.wrote(&args.output, what);
    Ok(())
}

/// Merges and returns the exit code: that of the whole run.
pub fn merge(context: &mut Context<'_>, args: &MergeArgs, color: Color) -> Result<u8, Error> {
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

/// The page's name unless another is asked for.
const PAGE_NAME: &str = "report.html";
/// Bytes in which a page says whose it is.
const PAGE_BEGINNING: u64 = 1024;

/// Reads what is there and writes the page and, where asked for, its plots.
pub fn report(context: &mut Context<'_>, args: &ReportArgs) -> Result<(), Error> {
    let read = |folder: &PathBuf| Material::read(&file::path_of(folder));
    let mut runs = args.folders.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let folder = if let [run] = &runs[..] { Some(run.folder.clone()) } else { None };
    let usual = folder.as_deref().unwrap_or(Path::new("")).join(PAGE_NAME);
    let output = args.output.as_deref().unwrap_or(&usual);
    let is_stdout = output == Path::new("-");
    if !is_stdout && !context.overwrite && !is_page_of_ours(output) {
        refuse_files([output.to_owned()])?;
    }
    if !args.no_pictures {
        for run in &mut runs {
            scene_pictures(context, &run.run, &mut run.pictures)?;
        }
    }
    // two plots per scene, about
    let steps = runs.iter().map(|run| 2 * run.run.scenes.len() as u64).sum();
    let progress = Progress::new(context.shows_progress(), steps, None);
    progress.message("costs of rows");
    let is_beside = folder.is_some_and(|folder| !is_stdout && is_within(output, &folder));
    let page = page(&runs, is_beside, progress);
    if is_stdout {
        context.out.write_all(page.html.as_bytes())?;
        context.out.flush()?;
    } else {
        write_text(output, &page.html)?;
        let scenes: usize = runs.iter().map(|run| run.run.scenes.len()).sum();
        context.wrote(output, format_args!("report of {scenes} scene(s)"));
    }
    if let Some(folder) = &args.plots {
        if !context.overwrite {
            refuse_files(page.plots.iter().map(|(name, _)| folder.join(name)))?;
        }
        fs::create_dir_all(folder).map_err(|source| WriteError { path: folder.clone(), source })?;
        for (name, svg) in &page.plots {
            write_text(&folder.join(name), svg)?;
        }
        context.wrote(folder, format_args!("{} plots", page.plots.len()));
    }
    Ok(())
}

/// Returns whether an earlier report is there: it may be replaced.
fn is_page_of_ours(path: &Path) -> bool {
    // a pipe would have to be waited for
    let Some(Ok(file)) = path.is_file().then(|| fs::File::open(path)) else { return false };
    let mut beginning = Vec::new();
    let read = file.take(PAGE_BEGINNING).read_to_end(&mut beginning);
    read.is_ok() && is_page(&String::from_utf8_lossy(&beginning))
}

/// Returns whether the file lies in the folder, however both are named.
fn is_within(file: &Path, folder: &Path) -> bool {
    let parent = file.parent().filter(|parent| *parent != Path::new(""));
    let parent = fs::canonicalize(parent.unwrap_or(Path::new(".")));
    parent.is_ok_and(|parent| fs::canonicalize(folder).is_ok_and(|folder| parent == folder))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_continue_after_z() {
        assert_eq!([0, 25, 26, 27, 52].map(letter), ["A", "Z", "AA", "AB", "BA"]);
    }
}
