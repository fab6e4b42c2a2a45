//! `rtbench history`: the results that CI keeps, as a static site.

use std::fs;
use std::path::Path;

use crate::args::HistoryArgs;
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use crate::history::{History, site, visits};
use crate::outputs::refuse_files;
use crate::report::is_page;
use measurement::system::files::{WriteError, write_text};
use statistics::change_points::Sensitivity;

/// Seed of the permutation tests: the same runs make the same site.
const SITE_SEED: u64 = 1;

/// Reads what is there, writes every page, and says what changed.
pub fn run(context: &mut Context<'_>, args: &HistoryArgs) -> Result<u8, Error> {
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
    Ok(SUCCESS)
}
