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
        let bold = Font { size: 17.0, is_bold: true, ..PLAIN };
        let grey = Font { color: GREY, ..PLAIN };
        match self {
            Self::Wide => {
                pen.text(left, 28.0, bold, title);
                pen.text(left, 47.0, grey, subtitle);
                62.0
            }
            Self::Narrow => {
                // letters of the title are larger than usual ones
                let title = wrapped(title, self.letters(0.0) * 3 / 4, 0);
                let mut y = 4.0;
                for line in &title {
                    y += 18.0;
                    pen.text(0.0, y, Font { size: 14.0, ..bold }, line);
                }
                for line in wrapped(subtitle, self.letters(0.0), 0) {
                    y += 15.0;
                    pen.text(0.0, y, grey, &line);
                }
                y + 15.0
            }
        }
    }
}
