//! What sections write to.

use presentation::html::Html;

/// Whether there was something to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// There was.
    Yes,
    /// The folder has nothing of it.
    Missing,
}

/// What sections write to.
#[derive(Default)]
pub struct Page {
    pub(super) html: Html,
    pub(super) plots: Vec<(String, String)>,
    pub(super) is_beside_record: bool,
}

impl Page {
    /// A plot within the page, kept by its name for files of its own, too.
    pub(super) fn plot(&mut self, name: &str, svg: String) {
        self.html.open("figure", &[]);
        self.html.open_scroll(&format!("plot {name}"));
        self.html.markup(&svg);
        self.html.close();
        self.html.close();
        self.plots.push((format!("{}.svg", file_name(name)), svg));
    }
}

/// A name that is safe as a file's.
fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    name.chars().map(safe).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_stay_in_their_folder() {
        assert_eq!(file_name("../a b/c"), "___a_b_c");
    }
}
