//! How wide a drawing is: for a desk, or for a phone, where names stand above what they name and
//! long labels below the frame.

use crate::fitted::wrapped;
use crate::svg_plot::palette::GREY;
use crate::svg_plot::pen::{Font, LETTER, PLAIN, Pen};
use crate::svg_plot::plot::WIDTH;

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
