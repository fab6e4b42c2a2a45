//! `rtbench report`: the results in folders as one page. `rtbench history`: the results that CI keeps,
//! as a static site.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::args::{HistoryArgs, ReportArgs};
use crate::commands::render::scene_pictures;
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use crate::history::{History, site, visits};
use crate::outputs::refuse_files;
use crate::report::material::Material;
use crate::report::{is_page, page};
use measurement::record::file;
use measurement::system::files::{WriteError, write_text};
use measurement::system::progress::Progress;
use statistics::change_points::Sensitivity;

/// The page's name unless another is asked for.
const PAGE_NAME: &str = "report.html";
/// Bytes in which a page says whose it is.
const PAGE_BEGINNING: u64 = 1024;

/// Reads what is there and writes the page and, where asked for, its plots.
pub fn run(context: &mut Context<'_>, args: &ReportArgs) -> Result<u8, Error> {
    let read = |folder: &PathBuf| Material::read(&file::path_of(folder));
    let mut runs = args.folders.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let folder = if let [run] = &runs[..] { Some(run.folder.clone()) } else { None };
    let usual = folder.as_deref().unwrap_or(Path::new("")).join(PAGE_NAME);
    let output = args.output.as_deref().unwrap_or(&usual);
    let is_stdout = output == Path::new("-");
    if !is_stdout {
        refuse_other_pages(context, output)?;
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
    Ok(SUCCESS)
}

/// Seed of the permutation tests: the same runs make the same site.
const SITE_SEED: u64 = 1;

/// `rtbench history`: writes every page of a site, and says what changed.
pub fn history(context: &mut Context<'_>, args: &HistoryArgs) -> Result<u8, Error> {
    let visits = visits(&args.folders, args.repository.as_deref())?;
    refuse_other_pages(context, &args.output.join("index.html"))?;
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
    Ok(SUCCESS)
}

/// Refuses a file that is there, unless it may be replaced, as earlier pages of ours may.
fn refuse_other_pages(context: &Context<'_>, path: &Path) -> Result<(), Error> {
    let is_ours = || {
        // a pipe would have to be waited for
        let Some(Ok(file)) = path.is_file().then(|| fs::File::open(path)) else { return false };
        let mut beginning = Vec::new();
        let read = file.take(PAGE_BEGINNING).read_to_end(&mut beginning);
        read.is_ok() && is_page(&String::from_utf8_lossy(&beginning))
    };
    if context.overwrite || is_ours() { Ok(()) } else { Ok(refuse_files([path.to_owned()])?) }
}

/// Returns whether the file lies in the folder, however both are named.
fn is_within(file: &Path, folder: &Path) -> bool {
    let parent = file.parent().filter(|parent| *parent != Path::new(""));
    let parent = fs::canonicalize(parent.unwrap_or(Path::new(".")));
    parent.is_ok_and(|parent| fs::canonicalize(folder).is_ok_and(|folder| parent == folder))
}
