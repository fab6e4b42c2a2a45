//! A drawing as SVG.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::item::{Color, Drawing, Item, Paint};
use crate::drawing::raster::encoded;
use crate::svg_plot::palette::dark_rules;
use crate::svg_plot::pen::Pen;
use crate::svg_plot::xml::document_of;

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

pub fn written(drawing: &Drawing) -> Result<String, image::ImageError> {
    let mut pen = Pen::default();
    let _ = writeln!(
        pen.out,
        "<style>@media (prefers-color-scheme: dark){{{}}}</style>",
        dark_rules("svg")
    );
    for item in &drawing.items {
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
    Ok(document_of(&pen.out, drawing.size, &drawing.alternative))
}
