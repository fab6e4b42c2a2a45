//! `rtbench report`: the results in a folder as one page.

use std::fs;
use std::path::Path;

use crate::args::ReportArgs;
use crate::context::Context;
use crate::error::Error;
use crate::export::files::write_text;
use crate::record_file;
use crate::report::material::Material;
use crate::report::page;

/// The page's name unless another is asked for.
const NAME: &str = "report.html";

/// Reads what is there and writes the page and, where asked for, its plots.
///
/// # Errors
/// [`Error`] for results that cannot be read and files that cannot be written.
pub fn run(context: &mut Context<'_>, args: &ReportArgs) -> Result<(), Error> {
    let record = record_file::path_of(&args.folder);
    let material = Material::read(&record)?;
    let page = page(&material);
    match &args.output {
        Some(path) if path == Path::new("-") => {
            context.out.write_all(page.html.as_bytes())?;
            context.out.flush()?;
        }
        Some(path) => write_text(path, &page.html)?,
        None => write_text(&material.folder.join(NAME), &page.html)?,
    }
    if let Some(folder) = &args.plots {
        fs::create_dir_all(folder)
            .map_err(|source| Error::Write { path: folder.clone(), source })?;
        for (name, svg) in &page.plots {
            write_text(&folder.join(name), svg)?;
        }
    }
    Ok(())
}
