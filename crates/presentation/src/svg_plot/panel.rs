//! One panel: frame, ticks, curves, marks with their flags, legend.

use crate::svg_plot::pen::{
    BEST, BOLD_LETTER, Font, Format, GREY, GRID, INK, LETTER, MARK, PLAIN, Pen, SERIES, style_of,
};
use crate::svg_plot::plot::{FittedAxis, Mark, Plot, Point, Ring, Scale};
use crate::text::wrapped;

/// Room below the frame.
const BOTTOM: f64 = 86.0;
/// Between two labels of an axis, at least.
const LABEL_GAP: f64 = 12.0;
/// Distance of the flags' labels along the frame.
const FLAG_GAP: f64 = 18.0;
/// Height of a line of the legend.
const LEGEND_STEP: f64 = 18.0;
/// Height of the bend between a flag's line and its label.
const BEND: f64 = 14.0;

/// The elements of a panel with its upper left corner at the origin, and its height.
pub fn draw(plot: &Plot, format: Format) -> (String, f64) {
    let mut plot = plot.clone();
    let keys = if format == Format::Narrow { shorten_labels(&mut plot) } else { Vec::new() };
    let mut canvas = Canvas::new(&plot, format);
    canvas.grid(&plot);
    canvas.levels(&plot);
    canvas.flags(&plot);
    canvas.series(&plot);
    canvas.marks(&plot);
    let more = canvas.legend(&plot, &keys);
    (canvas.pen.out, canvas.bottom + BOTTOM + more)
}

/// Labels of more letters do not stand at their flags on a phone.
const LONGEST_LABEL: usize = 4;
/// Flags beside one another on a phone; of more, only those of what is best.
const MOST_FLAGS: usize = 12;

/// Gives a plot short labels for long ones; returns what those stand for.
fn shorten_labels(plot: &mut Plot) -> Vec<String> {
    let mut keys = Vec::new();
    let are_too_many = plot.marks.iter().filter(|m| !m.label.is_empty()).count() > MOST_FLAGS;
    for mark in &mut plot.marks {
        if are_too_many && mark.ring == Ring::None {
            mark.label.clear();
        } else if mark.label.chars().count() > LONGEST_LABEL {
            let key = key(keys.len());
            keys.push(format!("{key}: {}", mark.label));
            mark.label = key;
        }
    }
    keys
}

/// a, b, ... z, a1, b1, ...
fn key(place: usize) -> String {
    let letter = char::from(b'a' + (place % 26) as u8);
    if place < 26 { letter.to_string() } else { format!("{letter}{}", place / 26) }
}

/// The frame's place and axes, and what is drawn so far.
struct Canvas {
    pen: Pen,
    format: Format,
    x: FittedAxis,
    y: FittedAxis,
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Canvas {
    fn new(plot: &Plot, format: Format) -> Self {
        let points = || {
            let series = plot.series.iter().flat_map(|s| &s.points);
            series.chain(plot.marks.iter().map(|m| &m.point))
        };
        let heights = points().flat_map(|p| [p.y, p.low, p.high]);
        let levels = plot.levels.iter().map(|l| l.y);
        // Flags lean over by half a right angle, so they need as much room to the right as above.
        let length = |m: &Mark| {
            let letter = if m.ring == Ring::Best { BOLD_LETTER } else { LETTER };
            m.label.chars().count() as f64 * letter
        };
        let longest = plot.marks.iter().map(length).fold(0.0, f64::max);
        let flag = longest * std::f64::consts::FRAC_1_SQRT_2;
        let mut pen = Pen::default();
        let (left, height) = match format {
            Format::Wide => (78.0, 380.0),
            Format::Narrow => (50.0, 280.0),
        };
        let mut head = format.head(&mut pen, left, &plot.title, &plot.subtitle);
        if format == Format::Narrow {
            // beside the axis there is no room for its name
            let font = Font { is_bold: true, ..PLAIN };
            pen.text(0.0, head + 4.0, font, &plot.y.label);
            head += 16.0;
        }
        let top = head + if longest == 0.0 { 0.0 } else { flag + BEND + 8.0 };
        let (width, bottom) = (format.width(), top + height);
        let right = match format {
            Format::Wide => width - f64::max(34.0, flag + 12.0).min(width / 3.0),
            Format::Narrow => width - f64::max(10.0, flag),
        };
        let x = FittedAxis::new(&plot.x.scale, [left, right], points().map(|p| p.x));
        let y = FittedAxis::new(&plot.y.scale, [bottom, top], heights.chain(levels));
        Self { pen, format, x, y, left, top, right, bottom }
    }

    fn place(&self, point: &Point) -> Option<(f64, f64)> {
        Some((self.x.place(point.x)?, self.y.place(point.y)?))
    }

    fn grid(&mut self, plot: &Plot) {
        let (top, right, bottom, left) = (self.top, self.right, self.bottom, self.left);
        let mut used = f64::NEG_INFINITY;
        for tick in self.x.ticks.clone() {
            let Some(x) = self.x.place(tick.at) else { continue };
            if let Some(label) = &tick.label {
                if !matches!(plot.x.scale, Scale::Words(_)) {
                    self.pen.path(&[(x, top), (x, bottom)], GRID, 1.0, "");
                }
                let half = label.chars().count() as f64 * LETTER / 2.0;
                if x - half >= used {
                    self.pen.text(x, bottom + 20.0, Font { anchor: "middle", ..PLAIN }, label);
                    used = x + half + LABEL_GAP;
                }
            }
            let length = if tick.label.is_some() { 6.0 } else { 3.0 };
            self.pen.path(&[(x, bottom), (x, bottom + length)], INK, 1.0, "");
        }
        for tick in self.y.ticks.clone() {
            let Some(y) = self.y.place(tick.at) else { continue };
            if let Some(label) = &tick.label {
                self.pen.path(&[(left, y), (right, y)], GRID, 1.0, "");
                self.pen.text(left - 10.0, y + 4.0, Font { anchor: "end", ..PLAIN }, label);
            }
            let length = if tick.label.is_some() { 6.0 } else { 3.0 };
            self.pen.path(&[(left - length, y), (left, y)], INK, 1.0, "");
        }
        self.pen.path(&[(left, top), (left, bottom), (right, bottom)], INK, 1.0, "");
        let (middle, centre) = ((left + right) / 2.0, (top + bottom) / 2.0);
        let axis = Font { size: 13.0, anchor: "middle", ..PLAIN };
        self.pen.text(middle, bottom + 44.0, axis, &plot.x.label);
        if self.format == Format::Wide {
            self.pen.text(24.0, centre, Font { turned: -90.0, ..axis }, &plot.y.label);
        }
    }

    fn levels(&mut self, plot: &Plot) {
        for level in &plot.levels {
            let Some(y) = self.y.place(level.y) else { continue };
            self.pen.path(
                &[(self.left, y), (self.right, y)],
                GREY,
                1.0,
                " stroke-dasharray=\"6 4\"",
            );
            let font = Font { size: 11.0, color: GREY, ..PLAIN };
            self.pen.text(self.left + 8.0, y - 5.0, font, &level.label);
        }
    }

    /// A line from each mark up to its label above the frame.
    fn flags(&mut self, plot: &Plot) {
        let mut flags: Vec<(f64, f64, &Mark)> = plot
            .marks
            .iter()
            .filter(|mark| !mark.label.is_empty())
            .filter_map(|mark| self.place(&mark.point).map(|(x, y)| (x, y, mark)))
            .collect();
        flags.sort_by(|a, b| a.0.total_cmp(&b.0));
        let wanted: Vec<f64> = flags.iter().map(|(x, _, _)| *x).collect();
        let places = spread(&wanted, FLAG_GAP, self.left, self.right);
        for ((x, y, mark), place) in flags.into_iter().zip(places) {
            let color = color_of(mark);
            let line = [(x, y), (x, self.top), (place, self.top - BEND)];
            self.pen.path(&line, color, 0.8, " stroke-opacity=\"0.55\"");
            let font = Font { color, is_bold: mark.ring == Ring::Best, turned: -45.0, ..PLAIN };
            self.pen.text(place + 4.0, self.top - BEND - 3.0, font, &mark.label);
        }
    }

    fn series(&mut self, plot: &Plot) {
        for (i, series) in plot.series.iter().enumerate() {
            let (color, dashes) = style_of(i);
            let places: Vec<(f64, f64)> =
                series.points.iter().filter_map(|p| self.place(p)).collect();
            if series.is_joined && places.len() > 1 {
                self.pen.path(&places, color, 1.8, dashes);
            }
            for point in &series.points {
                self.error_bar(point, color);
            }
            for (x, y) in places {
                self.pen.circle(x, y, color);
            }
        }
    }

    fn error_bar(&mut self, point: &Point, color: &str) {
        let Some((x, _)) = self.place(point) else { return };
        if point.low == point.high {
            return;
        }
        // it ends at the frame at the latest
        let [low, high] = [point.low, point.high].map(|y| self.y.nearest_place(y));
        self.pen.path(&[(x, low), (x, high)], color, 1.2, "");
        for y in [low, high] {
            self.pen.path(&[(x - 4.0, y), (x + 4.0, y)], color, 1.2, "");
        }
    }

    fn marks(&mut self, plot: &Plot) {
        for mark in &plot.marks {
            let Some((x, y)) = self.place(&mark.point) else { continue };
            if !mark.is_in_series {
                self.error_bar(&mark.point, MARK);
                self.pen.diamond(x, y, MARK, &mark.hover);
            }
            self.pen.ring(x, y, mark.ring);
        }
    }

    /// The names of the series, in as many lines as they need, and what keys stand for; returns the
    /// height of those beyond the first.
    fn legend(&mut self, plot: &Plot, keys: &[String]) -> f64 {
        let first = self.bottom + 68.0;
        let left = match self.format {
            Format::Wide => self.left + 6.0,
            Format::Narrow => 16.0,
        };
        let (mut x, mut y) = (left, first);
        for (i, series) in plot.series.iter().enumerate() {
            let (color, dashes) = style_of(i);
            let width = series.name.chars().count() as f64 * LETTER;
            if x > left && x + 12.0 + width > self.format.width() {
                (x, y) = (left, y + LEGEND_STEP);
            }
            if series.is_joined && !dashes.is_empty() {
                self.pen.path(&[(x - 14.0, y - 4.0), (x + 10.0, y - 4.0)], color, 1.8, dashes);
            }
            self.pen.circle(x, y - 4.0, color);
            y = self.lines(x + 12.0, y, PLAIN, &series.name);
            x += 44.0 + width;
        }
        let is_drawn = |m: &Mark| !m.is_in_series && self.place(&m.point).is_some();
        if plot.marks.iter().any(is_drawn) {
            let width = plot.marks_name.chars().count() as f64 * LETTER;
            if self.format == Format::Narrow && x + 12.0 + width > self.format.width() {
                (x, y) = (left, y + LEGEND_STEP);
            }
            self.pen.diamond(x, y - 4.0, MARK, "");
            y = self.lines(x + 12.0, y, PLAIN, &plot.marks_name);
        }
        for key in keys {
            y = self.lines(0.0, y + LEGEND_STEP, PLAIN, key);
        }
        y - first
    }

    /// Text from a place on, on a phone in as many lines as it needs; returns where the last one
    /// is.
    fn lines(&mut self, x: f64, mut y: f64, font: Font, text: &str) -> f64 {
        if self.format == Format::Wide {
            self.pen.text(x, y, font, text);
            return y;
        }
        for (i, line) in wrapped(text, self.format.letters(x), 0).iter().enumerate() {
            if i > 0 {
                y += LEGEND_STEP - 3.0;
            }
            self.pen.text(x, y, font, line);
        }
        y
    }
}

fn color_of(mark: &Mark) -> &'static str {
    match mark.ring {
        Ring::Best => BEST,
        _ if mark.is_in_series => SERIES[0],
        _ => MARK,
    }
}

/// Places near the wanted ones (which ascend), each `gap` from the next, between `low` and `high`;
/// where there is no room for that, at equal distances.
pub fn spread(wanted: &[f64], gap: f64, low: f64, high: f64) -> Vec<f64> {
    let between = wanted.len().saturating_sub(1).max(1) as f64;
    let gap = gap.min((high - low) / between);
    let rightwards = |places: &[f64], start: f64| -> Vec<f64> {
        let next = |least: &mut f64, &x: &f64| {
            let place = x.max(*least);
            *least = place + gap;
            Some(place)
        };
        places.iter().scan(start, next).collect()
    };
    let leftwards = |places: &[f64], end: f64| -> Vec<f64> {
        let next = |most: &mut f64, &x: &f64| {
            let place = x.min(*most);
            *most = place - gap;
            Some(place)
        };
        let mut out: Vec<f64> = places.iter().rev().scan(end, next).collect();
        out.reverse();
        out
    };
    // Pushed to the right and to the left, the mean of both keeps the gaps and the middle.
    let right = rightwards(wanted, f64::NEG_INFINITY);
    let left = leftwards(wanted, f64::INFINITY);
    let middle: Vec<f64> = right.iter().zip(left).map(|(r, l)| (r + l) / 2.0).collect();
    leftwards(&rightwards(&middle, low), high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_with_room_stay_and_others_move_apart() {
        assert_eq!(spread(&[10.0, 50.0], 20.0, 0.0, 100.0), [10.0, 50.0]);
        assert_eq!(spread(&[40.0, 40.0, 40.0], 10.0, 0.0, 100.0), [30.0, 40.0, 50.0]);
        assert_eq!(spread(&[0.0, 0.0], 10.0, 0.0, 100.0), [0.0, 10.0]);
        assert_eq!(spread(&[100.0, 100.0], 10.0, 0.0, 100.0), [90.0, 100.0]);
        assert!(spread(&[], 10.0, 0.0, 1.0).is_empty());
    }

    #[test]
    fn without_room_labels_are_at_equal_distances() {
        assert_eq!(spread(&[5.0; 5], 100.0, 0.0, 40.0), [0.0, 10.0, 20.0, 30.0, 40.0]);
    }
}
