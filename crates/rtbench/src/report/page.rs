//! Page that sections write to.

use measurement::system::progress::Progress;
use presentation::html::Html;
use presentation::page::figure;
use presentation::svg_plot::Drawing;
use scene_loading::source_hash::sha256_of_bytes;

/// True if there was something to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SectionOutcome {
    Yes,
    /// The folder has nothing of it.
    Missing,
}

/// Page that sections write to.
#[derive(Default)]
pub struct Page {
    pub(super) html: Html,
    pub(super) plots: Vec<(String, String)>,
    pub(super) is_beside_record: bool,
    /// Prefix of anchors, for one run of several.
    pub(super) prefix: String,
    pub(super) progress: Progress,
}

impl Page {
    /// A plot within the page, kept by its name for files of its own, too.
    pub(super) fn plot(&mut self, name: &str, drawing: impl Into<Drawing>) {
        let name = format!("{}{name}", self.prefix);
        let svg = figure(&mut self.html, &format!("plot {name}"), &drawing.into());
        self.progress.message(format!("plot {name}"));
        self.progress.reach(self.plots.len() as u64);
        self.plots.push((format!("{}.svg", file_name(&name)), svg));
    }

    /// Anchor of a part of the page.
    pub(super) fn anchor(&self, name: &str) -> String {
        file_name(&format!("{}{name}", self.prefix))
    }
}

/// The most bytes of a file's name, without its extension: systems take 255.
const LONGEST: usize = 200;

/// A name that is safe as a file's. One that is too long ends with a hash, so that names stay
/// distinct.
pub fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let mut file: String = name.chars().map(safe).collect();
    if file.len() > LONGEST {
        file.truncate(LONGEST - 17);
        file.extend(std::iter::once('-').chain(sha256_of_bytes(name.as_bytes()).chars().take(16)));
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_stay_in_their_folder() {
        assert_eq!(file_name("../a b/c"), "___a_b_c");
        let names = ["x".repeat(200), "x".repeat(201), "x".repeat(5000)];
        let files = names.each_ref().map(|name| file_name(name));
        assert_eq!(files[0], names[0]);
        assert!(files.iter().all(|file| file.len() == LONGEST) && files[1] != files[2]);
    }
}
