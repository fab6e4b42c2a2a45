//! Elements of drawings.

use crate::svg_plot::pen::{Font, LETTER, PLAIN};

/// A colour in sRGB.
pub type Color = [u8; 3];

/// A colour of [`palette`](crate::svg_plot::palette), `#rrggbb`; black for other texts.
pub fn color(text: &str) -> Color {
    let number = text.strip_prefix('#').and_then(|hex| u32::from_str_radix(hex, 16).ok());
    let [_, r, g, b] = number.unwrap_or(0).to_be_bytes();
    [r, g, b]
}

/// Drawing style of an item.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Paint {
    /// Colour of its inside, and how much of what lies below it hides: from 0 to 1.
    pub fill: Option<(Color, f64)>,
    /// Colour of its outline or line, and the width of that.
    pub stroke: Option<(Color, f64)>,
}

/// Something that is drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// Boxes: left, top, width, height.
    Boxes(Vec<[f64; 4]>, Paint),
    /// Lines from point to point; closed ones have an inside.
    Lines {
        /// One or more lines.
        lines: Vec<Vec<[f64; 2]>>,
        /// True if they go back to where they begin.
        are_closed: bool,
        paint: Paint,
    },
    Disc {
        at: [f64; 2],
        radius: f64,
        paint: Paint,
    },
    /// Text, its baseline at a place.
    Text([f64; 2], Font, String),
    /// An image whose pixels stay squares: left, top, width, height; then its own width, and its
    /// rows from above.
    Image([f64; 4], u32, Vec<Color>),
}

/// A picture: later items cover earlier ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawing {
    pub size: [f64; 2],
    /// Text alternative for readers who cannot see it.
    pub alternative: String,
    pub items: Vec<Item>,
}

impl Drawing {
    pub fn text(&mut self, at: [f64; 2], font: Font, text: impl Into<String>) {
        self.items.push(Item::Text(at, font, text.into()));
    }

    /// Adds everything of another drawing, moved.
    pub fn add(&mut self, other: Self, by: [f64; 2]) {
        let moved = |p: [f64; 2]| [p[0] + by[0], p[1] + by[1]];
        let frame = |[x, y, w, h]: [f64; 4]| [x + by[0], y + by[1], w, h];
        self.items.extend(other.items.into_iter().map(|item| match item {
            Item::Boxes(boxes, paint) => Item::Boxes(boxes.into_iter().map(frame).collect(), paint),
            Item::Lines { lines, are_closed, paint } => {
                let line = |line: Vec<[f64; 2]>| line.into_iter().map(moved).collect();
                Item::Lines { lines: lines.into_iter().map(line).collect(), are_closed, paint }
            }
            Item::Disc { at, radius, paint } => Item::Disc { at: moved(at), radius, paint },
            Item::Text(at, font, text) => Item::Text(moved(at), font, text),
            Item::Image(at, width, pixels) => Item::Image(frame(at), width, pixels),
        }));
    }
}

/// A text in lines of about that width in pixels, broken between words.
pub fn wrapped(text: &str, width: f64, size: f64) -> Vec<String> {
    let letters = (width / (LETTER / PLAIN.size * size)) as usize;
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
