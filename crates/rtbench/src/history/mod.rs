//! The results that CI keeps, as a static site: how the ratios of each row went from commit to
//! commit, on each machine, and at which commits they changed.
//!
//! Ratios are to the reference of the same run, which is why a history can be read at all: seconds
//! follow the machine's day. Runs are in the order of their commits. A line is of one machine and
//! its settings; nothing is ever joined across two. Changes are found by E-divisive
//! ([`statistics::change_points`]) on the logarithms of the ratios.

mod layout;
mod lines;
mod pages;
mod visit;

pub use lines::{Change, History, Key, Line, MachineSetup, Point, Quantity};
pub use visit::{HistoryError, Visit, visits};

use crate::history::layout::Names;

/// The files of the site: their paths within it, and what is in them.
pub fn site(history: &History) -> Vec<(String, String)> {
    let names = Names::new(history);
    let mut files = vec![(layout::INDEX.to_owned(), pages::index_page(history, &names))];
    for (scene, path) in &names.scenes {
        files.push((path.clone(), pages::scene_page(history, &names, scene)));
    }
    for (page, path) in &names.pages {
        files.push((path.clone(), pages::row_page(history, &names, page)));
    }
    files
}
