//! Bars side by side: names down, a column for each quantity, intervals across the ends of bars.

use std::fmt::Write;

use crate::svg_plot::Figure;
use crate::svg_plot::pen::{
    Font, Format, GREY, GRID, INK, LETTER, MARK, PAPER, PLAIN, Pen, document_of, style_of,
};
use crate::svg_plot::plot::{FittedAxis, Ring, Scale};
use statistics::estimate::Estimate;

/// Room below the bars: ticks and labels of the axes.
const FOOT: f64 = 34.0;
/// The most that names take of the width, where they stand beside the bars.
const NAMES: f64 = 400.0;
/// Times the best value at which the axis is cut: a bar beyond it has an arrow.
const CUT: f64 = 10.0;
/// Start of the bars: their values are ratios.
const BASE: f64 = 1.0;

#[derive(Debug, Clone, PartialEq)]
pub struct BarChart {
    pub title: String,
    /// Below the title, small.
    pub subtitle: String,
    /// Names of the quantities, at least one.
    pub columns: Vec<String>,
    /// The bars, from above.
    pub rows: Vec<BarRow>,
}

/// One name and its bars.
#[derive(Debug, Clone, PartialEq)]
pub struct BarRow {
    pub name: String,
    /// Index of the colour of its bars.
    pub color: usize,
    /// One bar per column.
    pub bars: Vec<Bar>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Bar {
    /// As long as a value; the number that stands beside it, and a ring around its end.
    Of(Estimate, String, Ring),
    /// No value: the words in its place.
    Words(String),
}

/// Layout: names beside the bars, or above them on a phone.
struct Layout {
    format: Format,
    /// Left edge of the columns.
    left: f64,
    /// Top edge of the rows.
    top: f64,
    step: f64,
    /// Room right of a column's bars for their numbers.
    numbers: f64,
}

impl Layout {
    fn new(chart: &BarChart, format: Format, head: f64) -> Self {
        let texts = chart.rows.iter().flat_map(|row| &row.bars).map(|bar| match bar {
            Bar::Of(_, text, _) | Bar::Words(text) => text.chars().count(),
        });
        let numbers = (texts.max().unwrap_or(0) as f64 * LETTER + 14.0).max(44.0);
        match format {
            Format::Wide => {
                let longest = chart.rows.iter().map(|r| r.name.chars().count()).max().unwrap_or(0);
                let left = (longest as f64 * LETTER + 18.0).min(NAMES);
                Self { format, left, top: head + 24.0, step: 20.0, numbers }
            }
            Format::Narrow => Self { format, left: 0.0, top: head + 24.0, step: 36.0, numbers },
        }
    }

    /// The middle of a row's bars, from above.
    fn middle(&self, row: usize) -> f64 {
        let within = match self.format {
            Format::Wide => self.step / 2.0,
            Format::Narrow => self.step - 10.0,
        };
        self.top + self.step * row as f64 + within
    }

    fn name(&self, pen: &mut Pen, row: usize, name: &str) {
        let (y, width) = (self.middle(row), self.format.width());
        match self.format {
            Format::Wide => {
                pen.path(
                    &[(self.left, y), (width - 4.0, y)],
                    GRID,
                    1.0,
                    " stroke-dasharray=\"1 3\"",
                );
                let font = Font { anchor: "end", ..fitting(name, self.left - 18.0) };
                pen.text(self.left - 8.0, y + 4.0, font, name);
            }
            Format::Narrow => {
                let font = fitting(name, width);
                let long = name.chars().count() as f64 * LETTER * font.size / PLAIN.size;
                let _ = writeln!(
                    pen.out,
                    "<rect x=\"0\" y=\"{:.1}\" width=\"{long:.1}\" height=\"13\" fill=\"{PAPER}\"/>",
                    y - 22.0
                );
                pen.text(0.0, y - 11.0, font, name);
            }
        }
    }
}

/// A font in which the text is not wider than that.
fn fitting(text: &str, width: f64) -> Font {
    let usual = (text.chars().count() as f64 * LETTER).max(1.0);
    let size = (10.0 * PLAIN.size * width / usual).floor() / 10.0;
    Font { size: size.min(PLAIN.size), ..PLAIN }
}

impl Figure for BarChart {
    fn svg(&self, format: Format) -> String {
        let mut pen = Pen::default();
        let from = if format == Format::Wide { 8.0 } else { 0.0 };
        let head = format.head(&mut pen, from, &self.title, &self.subtitle);
        let layout = Layout::new(self, format, head);
        let width = (format.width() - layout.left) / self.columns.len().max(1) as f64;
        let bottom = layout.top + layout.step * self.rows.len() as f64;
        // beside bars their guides are behind all, above bars names are before the grid
        let names = |pen: &mut Pen| {
            self.rows.iter().enumerate().for_each(|(i, row)| layout.name(pen, i, &row.name));
        };
        if format == Format::Wide {
            names(&mut pen);
        }
        for (i, name) in self.columns.iter().enumerate() {
            let bars = || self.rows.iter().map(move |row| (row.color, row.bars.get(i)));
            let best = bars().find_map(|(_, bar)| match bar {
                Some(Bar::Of(e, _, Ring::Best)) => Some(e.median),
                _ => None,
            });
            let best = best.unwrap_or(BASE);
            let is_kept = |e: &Estimate| (best / CUT..=best * CUT).contains(&e.median);
            let values = bars().flat_map(|(_, bar)| match bar {
                Some(Bar::Of(e, ..)) if is_kept(e) => vec![e.median, e.low, e.high],
                _ => Vec::new(),
            });
            let from = layout.left + width * i as f64;
            let (left, right) = (from + 6.0, from + width - layout.numbers);
            let values = values.chain([BASE]);
            let place = BarPlace {
                axis: FittedAxis::new(&Scale::Log, [left, right], values),
                left,
                right,
                top: layout.top - 4.0,
                bottom,
            };
            place.frame(&mut pen, name);
            for (j, (color, bar)) in bars().enumerate() {
                place.bar(&mut pen, layout.middle(j), style_of(color).0, bar);
            }
        }
        if format == Format::Narrow {
            names(&mut pen);
        }
        let alternative = format!("{}. {}", self.title, self.subtitle);
        document_of(&pen.out, [format.width(), bottom + FOOT], &alternative)
    }
}

struct BarPlace {
    axis: FittedAxis,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl BarPlace {
    fn frame(&self, pen: &mut Pen, name: &str) {
        let top = self.top;
        let mut used = f64::NEG_INFINITY;
        for tick in &self.axis.ticks {
            let Some(x) = self.axis.place(tick.at) else { continue };
            if let Some(label) = &tick.label {
                pen.path(&[(x, top), (x, self.bottom)], GRID, 1.0, "");
                let half = label.chars().count() as f64 * LETTER / 2.0;
                if x - half >= used {
                    let font = Font { size: 11.0, anchor: "middle", ..PLAIN };
                    pen.text(x, self.bottom + 18.0, font, label);
                    used = x + half + 4.0;
                }
            }
        }
        let base = self.axis.nearest_place(BASE);
        pen.path(&[(base, top), (base, self.bottom + 4.0)], GREY, 1.0, " stroke-dasharray=\"6 4\"");
        let ends = [(self.left, self.bottom), (self.right, self.bottom)];
        pen.path(&ends, INK, 1.0, "");
        let font = Font { is_bold: true, ..PLAIN };
        pen.text(self.left, self.top - 12.0, font, name);
    }

    fn bar(&self, pen: &mut Pen, y: f64, color: &str, bar: Option<&Bar>) {
        let (estimate, number, ring) = match bar {
            None => return,
            Some(Bar::Words(words)) => {
                let font = Font { size: 11.0, color: MARK, ..PLAIN };
                return pen.text(self.right + 10.0, y + 4.0, font, words);
            }
            Some(Bar::Of(estimate, number, ring)) => (estimate, number, *ring),
        };
        let (from, to) = (self.axis.nearest_place(BASE), self.axis.nearest_place(estimate.median));
        let (x, width) = (from.min(to), (from - to).abs());
        let _ = writeln!(
            pen.out,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"10\" fill=\"{color}\" \
             fill-opacity=\"0.35\"/>",
            y - 5.0
        );
        if estimate.median.is_finite() && self.axis.place(estimate.median).is_none() {
            pen.arrow(to, y, estimate.median < BASE, color);
        } else {
            let (low, high) =
                (self.axis.nearest_place(estimate.low), self.axis.nearest_place(estimate.high));
            pen.path(&[(low, y), (high, y)], color, 1.4, "");
            for end in [low, high] {
                pen.path(&[(end, y - 4.0), (end, y + 4.0)], color, 1.4, "");
            }
            pen.circle(to, y, color);
            pen.ring(to, y, ring);
        }
        let font = Font { size: 11.0, is_bold: ring == Ring::Best, ..PLAIN };
        pen.text(self.right + 10.0, y + 4.0, font, number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(values: &[f64]) -> BarChart {
        let bar = |&x: &f64| BarRow {
            name: format!("<{x}>"),
            color: 0,
            bars: vec![
                Bar::Of(
                    Estimate { median: x, low: x * 0.9, high: x * 1.1 },
                    "n".into(),
                    Ring::Best,
                ),
                Bar::Words("wrong".into()),
            ],
        };
        BarChart {
            title: "<t>".into(),
            subtitle: String::new(),
            columns: vec!["a & b".into(); 2],
            rows: values.iter().map(bar).collect(),
        }
    }

    #[test]
    fn bars_are_as_long_as_their_values_and_texts_are_escaped() {
        let svg = sample(&[1.0, 2.0, 4.0, 100.0]).svg(Format::Wide);
        let tree = roxmltree::Document::parse(&svg).expect("well-formed XML");
        let bars = tree.descendants().filter(|n| n.attribute("height") == Some("10"));
        let widths: Vec<f64> =
            bars.map(|n| n.attribute("width").unwrap().parse().unwrap()).collect();
        assert_eq!((widths.len(), widths[0]), (4, 0.0));
        assert!((widths[2] - 2.0 * widths[1]).abs() < 0.2, "{widths:?}");
        // beyond ten times the best the axis is cut: an arrow, and the number as of all
        assert_eq!(svg.matches("l-8 -5l0 10z").count(), 1);
        assert!(widths[3] < 1.2 * widths[2], "{widths:?}");
        let has = |text: &str| tree.descendants().any(|n| n.text() == Some(text));
        // a long name is set smaller, not cut off
        assert_eq!(fitting(&"n".repeat(100), 360.0).size, 6.0);
        assert_eq!(fitting("short", 360.0).size, PLAIN.size);
        assert!(has("<t>") && has("<2>") && has("a & b") && has("wrong"));
    }

    #[test]
    fn odd_numbers_and_nothing_at_all_can_be_drawn() {
        for values in [&[f64::NAN, f64::INFINITY, -1.0, 0.0][..], &[]] {
            for format in [Format::Wide, Format::Narrow] {
                let svg = sample(values).svg(format);
                assert!(roxmltree::Document::parse(&svg).is_ok());
                assert!(!svg.contains("\"NaN") && !svg.contains("\"inf"), "{svg}");
            }
        }
    }
}
