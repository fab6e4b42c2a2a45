//! Drawing primitives of panels and charts: colours, text, lines, points; and how wide a drawing is: for a
//! desk, or for a phone, where names stand above what they name and long labels below the frame.

use std::fmt::Write;

use crate::html::escaped;
use crate::svg_plot::plot::{Ring, WIDTH};
use crate::text::wrapped;

/// A page that is read in the dark replaces these colours by others: see [`IN_THE_DARK`].
pub const INK: &str = "#222222";
/// Text of less weight.
pub const GREY: &str = "#707070";
pub const GRID: &str = "#e4e4e4";
pub const PAPER: &str = "#ffffff";
pub const BEST: &str = "#137a3a";
/// Marks that belong to no series.
pub const MARK: &str = "#b4560a";
/// Colours of series, used in turn; distinguishable for colour-blind readers too.
pub const SERIES: [&str; 5] = ["#1f5fa8", "#8c3f97", "#4d8f8b", "#a3842c", "#555555"];

/// Patterns of the lines of series, as attributes: where the colours begin anew, the next one.
pub const DASHES: [&str; 4] = [
    "",
    " stroke-dasharray=\"7 3\"",
    " stroke-dasharray=\"2 3\"",
    " stroke-dasharray=\"10 3 2 3\"",
];

/// Colour and pattern of the series at a place.
pub fn style_of(place: usize) -> (&'static str, &'static str) {
    let of = |list: &[&'static str], i: usize| list.iter().copied().cycle().nth(i % list.len());
    let dashes = of(&DASHES, place / SERIES.len());
    (of(&SERIES, place).unwrap_or(INK), dashes.unwrap_or_default())
}

/// Each colour and what stands for it on a dark ground.
pub const IN_THE_DARK: [(&str, &str); 11] = [
    (INK, "#e8e8e8"),
    (GREY, "#b0b0b0"),
    (GRID, "#3a3f47"),
    (PAPER, "#16191d"),
    (BEST, "#5fd38d"),
    (MARK, "#f0a35e"),
    (SERIES[0], "#7ab8ff"),
    (SERIES[1], "#d69be0"),
    (SERIES[2], "#7fc9c4"),
    (SERIES[3], "#dcc06a"),
    (SERIES[4], "#c0c0c0"),
];

/// Style rules that draw the plots within `selector` in those colours.
pub fn dark_rules(selector: &str) -> String {
    let rule = |(light, dark): &(&str, &str)| {
        format!(
            "{selector} [fill=\"{light}\"]{{fill:{dark}}}{selector} [stroke=\"{light}\"]\
             {{stroke:{dark}}}"
        )
    };
    IN_THE_DARK.iter().map(rule).collect()
}

/// Width of a letter of a label, about; in the widest of usual fonts (DejaVu Sans), so that no text
/// is cut off where others are missing.
pub const LETTER: f64 = 7.2;
/// The same of a bold one.
pub const BOLD_LETTER: f64 = 8.3;

/// Alignment of text at its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Font {
    pub size: f64,
    /// `start`, `middle` or `end`.
    pub anchor: &'static str,
    pub color: &'static str,
    pub is_bold: bool,
    pub turned: f64,
}

pub const PLAIN: Font =
    Font { size: 12.0, anchor: "start", color: INK, is_bold: false, turned: 0.0 };

#[derive(Default)]
pub struct Pen {
    pub out: String,
}

impl Pen {
    pub fn text(&mut self, x: f64, y: f64, font: Font, text: &str) {
        let Font { size, anchor, color, is_bold, turned } = font;
        let weight = if is_bold { " font-weight=\"bold\"" } else { "" };
        let turn = match turned {
            0.0 => String::new(),
            degrees => format!(" transform=\"rotate({degrees} {x:.1} {y:.1})\""),
        };
        let _ = writeln!(
            self.out,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" \
             fill=\"{color}\"{weight}{turn}>{}</text>",
            escaped(text)
        );
    }

    /// Straight lines from point to point; `more` are further attributes.
    pub fn path(&mut self, points: &[(f64, f64)], color: &str, width: f64, more: &str) {
        let places: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(
            self.out,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"\
             {more}/>",
            places.join(" ")
        );
    }

    /// The point of a series.
    pub fn circle(&mut self, x: f64, y: f64, color: &str) {
        let _ =
            writeln!(self.out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{color}\"/>");
    }

    /// A point that belongs to no series; `hover` is shown while a pointer is over it.
    pub fn diamond(&mut self, x: f64, y: f64, color: &str, hover: &str) {
        let shape = format!("M{x:.1} {:.1}l5.5 5.5l-5.5 5.5l-5.5 -5.5z", y - 5.5);
        let _ = match hover {
            "" => writeln!(self.out, "<path d=\"{shape}\" fill=\"{color}\"/>"),
            text => writeln!(
                self.out,
                "<path d=\"{shape}\" fill=\"{color}\"><title>{}</title></path>",
                escaped(text)
            ),
        };
    }

    /// The tip of what goes on beyond an axis that is cut there.
    pub fn arrow(&mut self, x: f64, y: f64, is_leftwards: bool, color: &str) {
        let back = if is_leftwards { 8 } else { -8 };
        let _ = writeln!(self.out, "<path d=\"M{x:.1} {y:.1}l{back} -5l0 10z\" fill=\"{color}\"/>");
    }

    pub fn ring(&mut self, x: f64, y: f64, ring: Ring) {
        let style = match ring {
            Ring::None => return,
            Ring::Best => "stroke-width=\"2\"",
            Ring::AsGood => "stroke-width=\"1.2\" stroke-dasharray=\"3 2\"",
        };
        let left = x - 8.0;
        let _ = writeln!(
            self.out,
            "<path d=\"M{left:.1} {y:.1}a8 8 0 1 0 16 0a8 8 0 1 0 -16 0z\" fill=\"none\" \
             stroke=\"{BEST}\" {style}/>"
        );
    }
}

/// Width of a drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// For windows of 900 pixels and more, and for files.
    Wide,
    Narrow,
}

impl Format {
    pub fn width(self) -> f64 {
        match self {
            Self::Wide => WIDTH,
            Self::Narrow => 340.0,
        }
    }

    /// Characters of the usual size in a line that begins at a place.
    pub(crate) fn letters(self, from: f64) -> usize {
        ((self.width() - from) / LETTER) as usize
    }

    /// Title and subtitle; returns the height of what is below them.
    pub(crate) fn head(self, pen: &mut Pen, left: f64, title: &str, subtitle: &str) -> f64 {
        let bold = Font { is_bold: true, ..PLAIN };
        let grey = Font { color: GREY, ..PLAIN };
        // letters of the title are larger than usual ones
        let (size, step, mut y, share) = match self {
            Self::Wide => (17.0, 21.0, 7.0, 0.65),
            Self::Narrow => (14.0, 18.0, 4.0, 0.75),
        };
        for line in wrapped(title, (self.letters(left) as f64 * share) as usize, 0) {
            y += step;
            pen.text(left, y, Font { size, ..bold }, &line);
        }
        y += if self == Self::Wide { 4.0 } else { 0.0 };
        for line in wrapped(subtitle, self.letters(left), 0) {
            y += 15.0;
            pen.text(left, y, grey, &line);
        }
        y + 15.0
    }
}

/// A picture of that size, and what it is for those who cannot see it.
pub fn document_of(body: &str, [width, height]: [f64; 2], alternative: &str) -> String {
    let height = f64::max(height, 1.0);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
         viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" \
         role=\"img\" aria-label=\"{}\">\n<rect width=\"100%\" height=\"100%\" \
         fill=\"{PAPER}\"/>\n{body}</svg>\n",
        escaped(alternative)
    )
}
