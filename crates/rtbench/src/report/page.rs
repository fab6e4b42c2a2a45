//! Page that sections write to, and a moment as people write it there.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use measurement::system::progress::Progress;
use presentation::html::{Attribute, Html};
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

    pub(super) fn anchor(&self, name: &str) -> String {
        file_name(&format!("{}{name}", self.prefix))
    }
}

/// An image within the page, of a kind by its media type.
pub(super) fn image(html: &mut Html, kind: &str, bytes: &[u8], alt: &str, more: &[Attribute<'_>]) {
    let source = format!("data:image/{kind};base64,{}", STANDARD.encode(bytes));
    html.void("img", &[&[("src", &*source), ("alt", alt)], more].concat());
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

/// `2026-11-22 01:30 UTC` of seconds since 1970.
pub fn utc(unix_s: u64) -> String {
    let (days, seconds) = ((unix_s / 86_400) as i64, unix_s % 86_400);
    // Julian day number of 1970-01-01: 2440588
    let julian = days.saturating_add(2_440_588);
    let f = julian + 1401 + (((4 * julian + 274_277) / 146_097) * 3) / 4 - 38;
    let e = 4 * f + 3;
    let h = 5 * ((e % 1461) / 4) + 2;
    let (day, month) = ((h % 153) / 5 + 1, (h / 153 + 2) % 12 + 1);
    let year = e / 1461 - 4716 + (14 - month) / 12;
    let (hour, minute) = (seconds / 3600, seconds / 60 % 60);
    format!("{year}-{month:02}-{day:02} {hour:02}:{minute:02} UTC")
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

    #[test]
    fn known_moments() {
        assert_eq!(utc(0), "1970-01-01 00:00 UTC");
        assert_eq!(utc(951_827_696), "2000-02-29 12:34 UTC");
        assert_eq!(utc(1_795_280_839), "2026-11-21 17:07 UTC");
        assert_eq!(utc(4_107_542_399), "2100-02-28 23:59 UTC");
        assert_eq!(utc(4_107_542_400), "2100-03-01 00:00 UTC");
    }
}
