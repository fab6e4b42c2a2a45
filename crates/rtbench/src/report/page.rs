//! Page that sections write to, and its glossary: symbols of Havran and Sixta (1999), and of times.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use scene_loading::source_hash::sha256_of_bytes;

use crate::report::material::Material;
use measurement::system::progress::Progress;
use presentation::html::{Attribute, Html};
use presentation::page::{TableStyle, figure, write_table};
use presentation::svg_plot::Figure;
use presentation::table::Table;

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
    pub(super) fn plot(&mut self, name: &str, drawing: &dyn Figure) {
        let name = format!("{}{name}", self.prefix);
        let svg = figure(&mut self.html, &format!("plot {name}"), drawing);
        self.progress.message(format!("plot {name}"));
        self.progress.reach(self.plots.len() as u64);
        self.plots.push((format!("{}.svg", file_name(&name)), svg));
    }

    /// The contents so far, taken out.
    pub(super) fn take(&mut self) -> String {
        std::mem::take(&mut self.html).finish()
    }

    /// A table whose heads are explained.
    pub(super) fn table(&mut self, table: &Table) {
        write_table(
            &mut self.html,
            table,
            TableStyle { meaning: Some(meaning), ..TableStyle::default() },
        );
    }

    /// The same with the rows' numbers before them.
    pub(super) fn numbered_table(&mut self, table: &Table, numbers: &[usize]) {
        let look = TableStyle { meaning: Some(meaning), numbers, ..TableStyle::default() };
        write_table(&mut self.html, table, look);
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

/// Symbols and words of the tables' heads.
pub static MEANINGS: &[(&str, &str)] = &[
    ("N_IN", "inner cells: nodes of a hierarchy, grids within grids"),
    ("N_V", "elementary cells: voxels, leaves"),
    ("N_EV", "elementary cells that are empty"),
    ("N_OIV", "references to primitives in elementary cells"),
    ("N_IT", "ray-primitive intersection tests per ray"),
    ("N_TS", "traversal steps per ray, those in the hierarchy included"),
    ("N_ETS", "steps per ray into elementary cells"),
    ("N_EETS", "steps per ray into empty elementary cells"),
    ("MiB", "memory of the structure, 2^20 bytes"),
    ("rays", "number of rays that a row was timed on: slow rows are timed on every k-th ray"),
    ("build ms", "median time to build the structure from the primitives, milliseconds"),
    ("trace ms", "median time for the rays of the column `rays`, milliseconds"),
    ("image ms", "the whole image through the renderer, once, milliseconds"),
    (
        "ratio [95%]",
        "trace time over the reference's for the same rays in the same round: the median with its \
         95% bootstrap interval; below 1 is faster; = where the interval contains 1: no \
         significant difference",
    ),
    ("trace ratio [95%]", "geometric mean over the scenes of the ratio of trace times"),
    ("build ratio [95%]", "geometric mean over the scenes of the ratio of build times"),
    ("primary", "millions of primary rays per second"),
    ("shadow", "millions of shadow rays per second"),
    ("second.", "millions of reflected and refracted rays per second"),
    ("diffuse", "millions of rays per second in random directions from surfaces"),
    ("verdict", "whether every answer was right, and on how many rays that rests where not on all"),
    ("query", "whether rays were issued to a row one by one, or a batch of them together"),
    ("time to image ms", "build, one million primary rays and their shadow rays, milliseconds"),
    ("to obvhs [95%]", "time to image over that of the fastest row of obvhs"),
    ("least", "the scene with the fewest rays per second over those of the reference"),
    ("break-even", "break-even: the number of rays from which the slower build pays off"),
    ("not significantly different", "the 95% interval of the ratio of both times contains 1"),
    ("k, M, G", "thousand, million, thousand million"),
];

pub fn meaning(name: &str) -> Option<&'static str> {
    MEANINGS.iter().find(|(symbol, _)| *symbol == name).map(|(_, meaning)| *meaning)
}

pub fn glossary(_: &Material, page: &mut Page) {
    let html = &mut page.html;
    html.definitions(MEANINGS.iter().copied());
    html.paragraph(
        "Times are medians over rounds; each round visits every row once, in seeded random order, \
         so that what disturbs a round disturbs all rows alike. Intervals are 95% bootstrap \
         percentile intervals (expanded, Hesterberg 2015); of fewer than six rounds they reach from \
         the least to the largest value. Each interval holds by itself: of many comparisons some \
         differ by chance. All answers are compared, and a wrong row shows no time.",
    );
    papers(html);
}

fn papers(html: &mut Html) {
    html.list(
        [
            "V. Havran, F. Sixta, Comparison of Hierarchical Grids, Ray Tracing News 12(1), 1999: \
             counters and tables.",
            "G. Zachmann, lecture on ray tracing acceleration, 2007: the two tables of times.",
            "T. Hesterberg, What Teachers Should Know About the Bootstrap, The American Statistician \
             69(4), 2015: intervals.",
            "J. W. Tukey, Exploratory Data Analysis, 1977: outliers.",
        ]
        .map(str::to_owned),
    );
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
