//! Pixels, and shapes upon them by the part of each pixel that they cover.

use super::item::Color;

/// An image that is drawn upon.
pub struct Canvas {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Color>,
}

impl Canvas {
    pub fn new([width, height]: [usize; 2], ground: Color) -> Self {
        Self { width, height, pixels: vec![ground; width * height] }
    }

    /// Mixes a colour into a pixel.
    fn blend(&mut self, x: usize, y: usize, color: Color, part: f64) {
        if part <= 0.0 || x >= self.width {
            return;
        }
        if let Some(pixel) = self.pixels.get_mut(y * self.width + x) {
            for (old, new) in pixel.iter_mut().zip(color) {
                *old = (f64::from(*old) * (1.0 - part) + f64::from(new) * part).round() as u8;
            }
        }
    }

    /// The pixels that an interval meets.
    fn pixel_range(low: f64, high: f64, n: usize) -> std::ops::Range<usize> {
        let end = high.ceil().clamp(0.0, n as f64) as usize;
        (low.floor().clamp(0.0, n as f64) as usize).min(end)..end
    }

    /// A box, as left, top, right, bottom.
    pub fn fill_box(&mut self, [x0, y0, x1, y1]: [f64; 4], color: Color, opacity: f64) {
        let part = |low: f64, high: f64, i: usize| {
            (high.min(i as f64 + 1.0) - low.max(i as f64)).clamp(0.0, 1.0)
        };
        for y in Self::pixel_range(y0, y1, self.height) {
            for x in Self::pixel_range(x0, x1, self.width) {
                self.blend(x, y, color, opacity * part(x0, x1, x) * part(y0, y1, y));
            }
        }
    }

    /// Fills the points within `radius` of the line from `a` to `b`; a disc if they are one point.
    pub fn fill_stadium(&mut self, [a, b]: [[f64; 2]; 2], radius: f64, color: Color, opacity: f64) {
        let along = [b[0] - a[0], b[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let reach = radius + 1.0;
        for y in Self::pixel_range(a[1].min(b[1]) - reach, a[1].max(b[1]) + reach, self.height) {
            // the part of the line that is near this row
            let (mut low, mut high) = (a[0].min(b[0]), a[0].max(b[0]));
            if along[1].abs() > 1e-9 {
                let at = |y: f64| a[0] + along[0] * ((y - a[1]) / along[1]).clamp(0.0, 1.0);
                let ends = [at(y as f64 + 0.5 - reach - 1.0), at(y as f64 + 0.5 + reach + 1.0)];
                low = ends[0].min(ends[1]);
                high = ends[0].max(ends[1]);
            }
            for x in Self::pixel_range(low - reach, high + reach, self.width) {
                let p = [x as f64 + 0.5 - a[0], y as f64 + 0.5 - a[1]];
                let t = if square > 0.0 {
                    ((p[0] * along[0] + p[1] * along[1]) / square).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let distance = (p[0] - along[0] * t).hypot(p[1] - along[1] * t);
                // thin lines are paler, not broken
                let part = (radius + 0.5 - distance).clamp(0.0, (2.0 * radius).min(1.0));
                self.blend(x, y, color, opacity * part);
            }
        }
    }

    /// The inside of a closed line, by the even-odd rule, four rows per pixel.
    pub fn fill_within(&mut self, points: &[[f64; 2]], color: Color, opacity: f64) {
        const ROWS: usize = 4;
        let of = |pick: fn(f64, f64) -> f64, start: f64, k: usize| {
            points.iter().fold(start, |all, p| pick(all, if k == 0 { p[0] } else { p[1] }))
        };
        let (low, high) = (of(f64::min, f64::MAX, 1), of(f64::max, f64::MIN, 1));
        let across =
            Self::pixel_range(of(f64::min, f64::MAX, 0), of(f64::max, f64::MIN, 0), self.width);
        let first = across.start;
        for y in Self::pixel_range(low, high, self.height) {
            let mut covered = vec![0.0; across.len()];
            for row in 0..ROWS {
                let at = y as f64 + (row as f64 + 0.5) / ROWS as f64;
                let edges = points.iter().zip(points.iter().cycle().skip(1));
                let mut cuts: Vec<f64> = edges
                    .filter(|(a, b)| (a[1] <= at) != (b[1] <= at))
                    .map(|(a, b)| a[0] + (b[0] - a[0]) * (at - a[1]) / (b[1] - a[1]))
                    .collect();
                cuts.sort_by(f64::total_cmp);
                for pair in cuts.chunks_exact(2) {
                    let [from, to] = [0, 1].map(|i| pair.get(i).copied().unwrap_or(0.0));
                    for x in Self::pixel_range(from, to, self.width) {
                        let part = to.min(x as f64 + 1.0) - from.max(x as f64);
                        if let Some(covered) = covered.get_mut(x.wrapping_sub(first)) {
                            *covered += part.clamp(0.0, 1.0) / ROWS as f64;
                        }
                    }
                }
            }
            for (i, part) in covered.into_iter().enumerate() {
                self.blend(first + i, y, color, opacity * part.min(1.0));
            }
        }
    }
}
