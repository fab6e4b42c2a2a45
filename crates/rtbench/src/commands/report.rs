//! `rtbench report`: the results in a folder as one page.

use std::fs;
use std::path::Path;

use crate::args::ReportArgs;
use crate::context::Context;
use crate::error::Error;
use crate::report::material::Material;
use crate::report::page;
use measurement::record::file;
use measurement::system::files::WriteError;
use measurement::system::files::write_text;
use measurement::system::progress::Progress;

/// The page's name unless another is asked for.
const NAME: &str = "report.html";

/// Reads what is there and writes the page and, where asked for, its plots.
///
/// # Errors
/// [`Error`] for results that cannot be read and files that cannot be written.
pub fn run(context: &mut Context<'_>, args: &ReportArgs) -> Result<(), Error> {
    let record = file::path_of(&args.folder);
    let material = Material::read(&record)?;
    let usual = material.folder.join(NAME);
    let output = args.output.as_deref().unwrap_or(&usual);
    let is_stdout = output == Path::new("-");
    // two plots a scene, about
    let steps = 2 * material.run.scenes.len() as u64;
    let progress = Progress::new(context.shows_progress(), steps, None);
    progress.message("costs of rows");
    let page = page(&material, !is_stdout && is_within(output, &material.folder), progress);
    if is_stdout {
        context.out.write_all(page.html.as_bytes())?;
        context.out.flush()?;
    } else {
        write_text(output, &page.html)?;
    }
    if let Some(folder) = &args.plots {
        fs::create_dir_all(folder).map_err(|source| WriteError { path: folder.clone(), source })?;
        for (name, svg) in &page.plots {
            write_text(&folder.join(name), svg)?;
        }
    }
    Ok(())
}

/// Whether the file lies in the folder, however both are named.
fn is_within(file: &Path, folder: &Path) -> bool {
    let parent = match file.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    match (fs::canonicalize(parent), fs::canonicalize(folder)) {
        (Ok(parent), Ok(folder)) => parent == folder,
        _ => false,
    }
}
