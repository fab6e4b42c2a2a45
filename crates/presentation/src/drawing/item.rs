//! Elements of drawings; a drawing as SVG.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ImageEncoder, ImageError};

use crate::svg_plot::pen::{Font, LETTER, PLAIN, Pen, dark_rules, document_of};

/// A colour in sRGB.
pub type Color = [u8; 3];

/// A colour of [`pen`](crate::svg_plot::pen), `#rrggbb`; black for other texts.
pub fn color(text: &str) -> Color {
    let number = text.strip_prefix('#').and_then(|hex| u32::from_str_radix(hex, 16).ok());
    let [_, r, g, b] = number.unwrap_or(0).to_be_bytes();
    [r, g, b]
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Paint {
    /// Colour of its inside, and how much of what lies below it hides: from 0 to 1.
    pub fill: Option<(Color, f64)>,
    /// Colour of its outline or line, and the width of that.
    pub stroke: Option<(Color, f64)>,
}

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

impl Drawing {
    /// As SVG.
    ///
    /// # Errors
    /// [`ImageError`] for an image that cannot be encoded.
    pub fn svg(&self) -> Result<String, ImageError> {
        let mut pen = Pen::default();
        let _ = writeln!(
            pen.out,
            "<style>@media (prefers-color-scheme: dark){{{}}}</style>",
            dark_rules("svg")
        );
        for item in &self.items {
            match item {
                Item::Boxes(boxes, paint) => {
                    let path = boxes.iter().fold(String::new(), |mut path, &[x, y, w, h]| {
                        let [x, y, w, h] = [x, y, w, h].map(short);
                        let _ = write!(path, "M{x} {y}h{w}v{h}h-{w}z");
                        path
                    });
                    if !path.is_empty() {
                        let _ = writeln!(pen.out, "<path d=\"{path}\"{}/>", painted(paint));
                    }
                }
                Item::Lines { lines, are_closed, paint } => {
                    let mut path = String::new();
                    for line in lines {
                        for (i, &[x, y]) in line.iter().enumerate() {
                            let letter = if i == 0 { 'M' } else { 'L' };
                            let _ = write!(path, "{letter}{} {}", short(x), short(y));
                        }
                        path.push_str(if *are_closed { "z" } else { "" });
                    }
                    if !path.is_empty() {
                        let _ = writeln!(
                            pen.out,
                            "<path d=\"{path}\"{} stroke-linejoin=\"round\" stroke-linecap=\"round\"/>",
                            painted(paint)
                        );
                    }
                }
                Item::Disc { at: [x, y], radius, paint } => {
                    let [x, y, r] = [*x, *y, *radius].map(short);
                    let paint = painted(paint);
                    let _ = writeln!(pen.out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"{paint}/>");
                }
                Item::Text([x, y], font, text) => pen.text(*x, *y, *font, text),
                Item::Image(_, _, pixels) if pixels.is_empty() => {}
                Item::Image(at, width, pixels) => {
                    let [x, y, w, h] = at.map(short);
                    let png = STANDARD.encode(encoded(*width, pixels)?);
                    let _ = writeln!(
                        pen.out,
                        "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" \
                         style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{png}\"/>"
                    );
                }
            }
        }
        Ok(document_of(&pen.out, self.size, &self.alternative))
    }
}

/// A number in as few letters as it needs, to a hundredth.
fn short(x: f64) -> String {
    // + 0.0: no "-0"
    let text = format!("{:.2}", (x * 100.0).round() / 100.0 + 0.0);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn painted(paint: &Paint) -> String {
    let mut out = String::new();
    match paint.fill {
        Some((color, opacity)) => {
            let _ = write!(out, " fill=\"{}\"", hex(color));
            if opacity < 1.0 {
                let _ = write!(out, " fill-opacity=\"{}\"", short(opacity));
            }
        }
        None => out.push_str(" fill=\"none\""),
    }
    if let Some((color, width)) = paint.stroke {
        let _ = write!(out, " stroke=\"{}\" stroke-width=\"{}\"", hex(color), short(width));
    }
    out
}

fn encoded(width: u32, pixels: &[Color]) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    let height = pixels.len() as u32 / width.max(1);
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(
        pixels.as_flattened(),
        width,
        height,
        image::ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg_plot::pen::{INK, PAPER};

    /// Lines, a box, a disc, an image, text that must be escaped.
    fn all_kinds() -> Drawing {
        let red = [200, 0, 0];
        let fill = Paint { fill: Some((red, 1.0)), stroke: None };
        let line = Paint { fill: None, stroke: Some((red, 2.0)) };
        let items = vec![
            Item::Boxes(vec![[2.0, 2.0, 10.0, 6.0]], fill),
            Item::Lines {
                lines: vec![vec![[20.0, 5.0], [30.0, 5.0]]],
                are_closed: false,
                paint: line,
            },
            Item::Lines {
                lines: vec![vec![[2.0, 20.0], [12.0, 20.0], [2.0, 30.0]]],
                are_closed: true,
                paint: fill,
            },
            Item::Disc { at: [25.0, 25.0], radius: 4.0, paint: fill },
            Item::Image([40.0, 2.0, 8.0, 4.0], 2, vec![[0, 0, 255], [0, 255, 0]]),
            Item::Text([40.0, 20.0], PLAIN, "a < b".into()),
        ];
        Drawing { size: [80.0, 40.0], alternative: "all & more".into(), items }
    }

    #[test]
    fn colors_are_read() {
        assert_eq!((color(PAPER), color(INK)), ([255; 3], [0x22; 3]));
        assert_eq!(color("red"), [0; 3]);
    }

    #[test]
    fn svg_is_well_formed_and_says_all() {
        let svg = all_kinds().svg().unwrap();
        let tree = roxmltree::Document::parse(&svg).unwrap();
        let count = |name: &str| tree.descendants().filter(|n| n.has_tag_name(name)).count();
        assert_eq!((count("path"), count("circle"), count("image"), count("text")), (3, 1, 1, 1));
        assert_eq!(tree.root_element().attribute("aria-label"), Some("all & more"));
        assert!(svg.contains("prefers-color-scheme: dark") && svg.contains("a &lt; b"));
        assert!(svg.contains("M2 2h10v6h-10z"), "{svg}");
    }

    #[test]
    fn drawings_are_moved_as_a_whole() {
        let mut page = Drawing { size: [200.0, 100.0], ..Drawing::default() };
        page.add(all_kinds(), [100.0, 50.0]);
        let svg = page.svg().unwrap();
        for moved in
            ["M102 52h10v6", "M120 55L130 55", "cx=\"125\" cy=\"75\"", "x=\"140\" y=\"52\""]
        {
            assert!(svg.contains(moved), "{moved}: {svg}");
        }
    }

    #[test]
    fn odd_numbers_can_be_drawn() {
        let mut drawing = all_kinds();
        let paint = Paint { fill: Some(([1; 3], 1.0)), stroke: Some(([2; 3], f64::NAN)) };
        let odd = [f64::NAN, f64::INFINITY, -1e300];
        drawing.items.push(Item::Boxes(vec![[odd[0], odd[1], odd[2], 1.0]], paint));
        let lines = vec![odd.map(|x| [x, -x]).to_vec(), Vec::new()];
        drawing.items.push(Item::Lines { lines, are_closed: true, paint });
        drawing.items.push(Item::Disc { at: [odd[0], odd[1]], radius: odd[2], paint });
        drawing.items.push(Item::Image([0.0; 4], 0, Vec::new()));
        roxmltree::Document::parse(&drawing.svg().unwrap()).unwrap();
        assert_eq!(wrapped("ab cde f", 1.0, 12.0), ["ab", "cde", "f"]);
        assert_eq!(wrapped("ab cde f", 1e3, 12.0), ["ab cde f"]);
    }
}
