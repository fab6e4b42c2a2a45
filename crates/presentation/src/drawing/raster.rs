//! A drawing as pixels.

use crate::drawing::canvas::Canvas;
use crate::drawing::item::{Color, Drawing, Item, Paint, color};
use crate::drawing::letters;
use crate::svg_plot::palette::PAPER;
use crate::svg_plot::pen::Font;
use image::ImageEncoder;

/// Thickness of letters, as a part of their size.
const THIN: f64 = 0.085;
const BOLD: f64 = 0.13;
/// Pixels of the longest side, at most.
const MOST: f64 = 32_768.0;

/// The pixels of a drawing that is so many times as large, and their width.
pub fn drawn(drawing: &Drawing, scale: f64) -> (u32, Vec<Color>) {
    let longest = drawing.size.into_iter().fold(1.0, f64::max);
    let scale = scale.min(MOST / longest);
    let size = drawing.size.map(|x| (x * scale).ceil().max(1.0) as usize);
    let mut on = ScaledImage { canvas: Canvas::new(size, color(PAPER)), scale };
    for item in &drawing.items {
        on.item(item);
    }
    (on.canvas.width as u32, on.canvas.pixels)
}

struct ScaledImage {
    canvas: Canvas,
    scale: f64,
}

impl ScaledImage {
    fn item(&mut self, item: &Item) {
        match item {
            Item::Boxes(boxes, paint) => {
                for &[x, y, w, h] in boxes {
                    self.boxed([x, y, x + w, y + h], paint);
                }
            }
            Item::Lines { lines, are_closed, paint } => {
                for line in lines {
                    self.lines(line, *are_closed, paint);
                }
            }
            Item::Disc { at, radius, paint } => {
                let at = self.point(*at);
                let disc = |on: &mut Self, radius: f64, color, opacity| {
                    on.canvas.fill_stadium([at, at], radius * on.scale, color, opacity);
                };
                match (paint.stroke, paint.fill) {
                    // a ring is what a smaller disc leaves of a larger one
                    (Some((ring, width)), Some((fill, opacity))) => {
                        disc(self, radius + 0.5 * width, ring, 1.0);
                        disc(self, radius - 0.5 * width, fill, opacity);
                    }
                    (None, Some((fill, opacity))) => disc(self, *radius, fill, opacity),
                    (stroke, None) => {
                        let turn = |i: usize| std::f64::consts::TAU * i as f64 / 48.0;
                        let on_ring =
                            |i| [at[0] + turn(i).cos() * radius, at[1] + turn(i).sin() * radius];
                        let ring: Vec<_> = (0..48).map(on_ring).collect();
                        self.lines(&ring, true, &Paint { fill: None, stroke });
                    }
                }
            }
            Item::Text(at, font, text) => self.text(*at, font, text),
            Item::Image([x, y, w, h], width, pixels) => {
                let width = (*width).max(1) as usize;
                let cell = [w / width as f64, h / (pixels.len() / width).max(1) as f64];
                for (i, &color) in pixels.iter().enumerate() {
                    let left = x + cell[0] * (i % width) as f64;
                    let top = y + cell[1] * (i / width) as f64;
                    let ends = [left, top, left + cell[0], top + cell[1]];
                    self.canvas.fill_box(ends.map(|x| x * self.scale), color, 1.0);
                }
            }
        }
    }

    fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x * self.scale, y * self.scale]
    }

    fn boxed(&mut self, ends: [f64; 4], paint: &Paint) {
        let [x0, y0, x1, y1] = ends.map(|x| x * self.scale);
        if let Some((fill, opacity)) = paint.fill {
            self.canvas.fill_box([x0, y0, x1, y1], fill, opacity);
        }
        if let Some((stroke, width)) = paint.stroke {
            let half = 0.5 * width * self.scale;
            let mut side = |ends| self.canvas.fill_box(ends, stroke, 1.0);
            side([x0 - half, y0 - half, x1 + half, y0 + half]);
            side([x0 - half, y1 - half, x1 + half, y1 + half]);
            side([x0 - half, y0 + half, x0 + half, y1 - half]);
            side([x1 - half, y0 + half, x1 + half, y1 - half]);
        }
    }

    fn lines(&mut self, line: &[[f64; 2]], is_closed: bool, paint: &Paint) {
        let mut points: Vec<[f64; 2]> = line.iter().map(|&p| self.point(p)).collect();
        if let (Some((fill, opacity)), true) = (paint.fill, is_closed) {
            self.canvas.fill_within(&points, fill, opacity);
        }
        let Some((stroke, width)) = paint.stroke else { return };
        if let (Some(&first), true) = (points.first(), is_closed || points.len() == 1) {
            points.push(first);
        }
        for (&a, &b) in points.iter().zip(points.iter().skip(1)) {
            self.canvas.fill_stadium([a, b], 0.5 * width * self.scale, stroke, 1.0);
        }
    }

    fn text(&mut self, at: [f64; 2], font: &Font, text: &str) {
        let (lines, width) = letters::lines(text, font.size);
        let back = match font.anchor {
            "middle" => 0.5 * width,
            "end" => width,
            _ => 0.0,
        };
        let (sin, cos) = font.turned.to_radians().sin_cos();
        let turned = |[x, y]: [f64; 2]| {
            let x = x - back;
            [at[0] + x * cos - y * sin, at[1] + x * sin + y * cos]
        };
        let thickness = font.size * if font.is_bold { BOLD } else { THIN };
        let paint = Paint { fill: None, stroke: Some((color(font.color), thickness)) };
        for line in lines {
            let line: Vec<_> = line.into_iter().map(turned).collect();
            self.lines(&line, false, &paint);
        }
    }
}

pub fn encoded(width: u32, pixels: &[Color]) -> Result<Vec<u8>, image::ImageError> {
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
