//! A drawing as SVG, and as the pixels that resvg draws of it, with the letters of DejaVu Sans.

use std::fmt::Write;
use std::sync::{Arc, LazyLock};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::error::{EncodingError, ImageFormatHint};
use image::{ImageEncoder, ImageError, ImageFormat};
use resvg::tiny_skia::{Color as Fill, Pixmap, Transform};
use resvg::usvg::fontdb::Database;
use resvg::usvg::{Options, Tree};

use super::item::{Color, Drawing, Item, Paint};
use crate::svg_plot::palette::dark_rules;
use crate::svg_plot::pen::{Pen, document_of};

/// Pixels of the longest side, at most.
const MOST: f32 = 32_768.0;

static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.load_font_data(dejavu::sans::bold().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

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

    /// As PNG, two pixels for one.
    ///
    /// # Errors
    /// [`ImageError`] for a drawing that is too large.
    pub fn png(&self) -> Result<Vec<u8>, ImageError> {
        let (width, pixels) = drawn(&self.svg()?, 2.0)?;
        encoded(width, &pixels)
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

/// The attributes of a paint.
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

/// The pixels of a picture that is so many times as large, and their width.
pub(super) fn drawn(svg: &str, scale: f32) -> Result<(u32, Vec<Color>), ImageError> {
    let failed = |error| {
        ImageError::Encoding(EncodingError::new(ImageFormatHint::Exact(ImageFormat::Png), error))
    };
    let options = Options { fontdb: Arc::clone(&FONTS), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|error| failed(error.to_string()))?;
    let size = tree.size();
    let scale = scale.min(MOST / size.width().max(size.height()));
    let [width, height] = [size.width(), size.height()].map(|x| (x * scale).ceil() as u32);
    let mut pixels = Pixmap::new(width, height)
        .ok_or_else(|| failed(format!("{width} x {height} pixels are too many")))?;
    pixels.fill(Fill::WHITE);
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok((width, pixels.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect()))
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
