//! Bars side by side: names down, a column for each quantity, intervals across the ends of bars.

use std::fmt::Write;

use crate::svg_plot::axis::Fitted;
use crate::svg_plot::document::document;
use crate::svg_plot::palette::{GREY, GRID, INK, MARK, SERIES};
use crate::svg_plot::pen::{Font, LETTER, PLAIN, Pen};
use crate::svg_plot::plot::{Axis, Ring, WIDTH};
use statistics::estimate::Estimate;

/// Height of a bar with the room around it.
const STEP: f64 = 20.0;
/// Room above the bars: title, subtitle, names of the columns.
const HEAD: f64 = 86.0;
/// Room below the bars: ticks and labels of the axes.
const FOOT: f64 = 34.0;
/// Room right of a column's bars for their numbers.
const NUMBERS: f64 = 62.0;
/// The most that names take of the width.
const NAMES: f64 = 340.0;

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub struct BarChart {
    /// Above it, large.
    pub title: String,
    /// Below the title, small.
    pub subtitle: String,
    /// The quantities, at least one.
    pub columns: Vec<Column>,
    /// The bars, from above.
    pub rows: Vec<BarRow>,
}

/// A quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its axis.
    pub axis: Axis,
    /// Where bars begin; at the left end where that has no place.
    pub base: f64,
}

/// One name and its bars.
#[derive(Debug, Clone, PartialEq)]
pub struct BarRow {
    /// The name.
    pub name: String,
    /// One bar a column.
    pub bars: Vec<Bar>,
}

/// A bar.
#[derive(Debug, Clone, PartialEq)]
pub enum Bar {
    /// As long as a value; the number that stands beside it, and a ring around its end.
    Of(Estimate, String, Ring),
    /// No value: the words in its place.
    Words(String),
}

/// Draws the chart.
pub fn chart(chart: &BarChart) -> String {
    let longest = chart.rows.iter().map(|r| r.name.chars().count()).max().unwrap_or(0);
    let left = (longest as f64 * LETTER + 18.0).min(NAMES);
    let width = (WIDTH - left) / chart.columns.len().max(1) as f64;
    let bottom = HEAD + STEP * chart.rows.len() as f64;
    let mut pen = Pen::default();
    pen.text(8.0, 28.0, Font { size: 17.0, is_bold: true, ..PLAIN }, &chart.title);
    pen.text(8.0, 47.0, Font { color: GREY, ..PLAIN }, &chart.subtitle);
    for (i, row) in chart.rows.iter().enumerate() {
        let y = middle(i);
        pen.path(&[(left, y), (WIDTH - 4.0, y)], GRID, 1.0, " stroke-dasharray=\"1 3\"");
        pen.text(left - 8.0, y + 4.0, Font { anchor: "end", ..PLAIN }, &row.name);
    }
    for (i, column) in chart.columns.iter().enumerate() {
        let bars = || chart.rows.iter().map(move |row| row.bars.get(i));
        let values = bars().flat_map(|bar| match bar {
            Some(Bar::Of(e, ..)) => vec![e.median, e.low, e.high],
            _ => Vec::new(),
        });
        let from = left + width * i as f64;
        let place = Place {
            axis: Fitted::new(&column.axis.scale, values.chain([column.base])),
            left: from + 6.0,
            right: from + width - NUMBERS,
            bottom,
        };
        place.frame(&mut pen, column);
        for (j, bar) in bars().enumerate() {
            place.bar(&mut pen, column.base, middle(j), bar);
        }
    }
    document(&pen.out, bottom + FOOT, &format!("{}. {}", chart.title, chart.subtitle))
}

/// The middle of a row, from above.
fn middle(row: usize) -> f64 {
    HEAD + STEP * (row as f64 + 0.5)
}

/// A column's place.
struct Place {
    axis: Fitted,
    left: f64,
    right: f64,
    bottom: f64,
}

impl Place {
    fn across(&self, x: f64) -> f64 {
        self.left + self.axis.nearest_place(x) * (self.right - self.left)
    }

    fn frame(&self, pen: &mut Pen, column: &Column) {
        let top = HEAD - 4.0;
        for tick in &self.axis.ticks {
            if self.axis.place(tick.at).is_none() {
                continue;
            }
            let x = self.across(tick.at);
            if let Some(label) = &tick.label {
                pen.path(&[(x, top), (x, self.bottom)], GRID, 1.0, "");
                let font = Font { size: 11.0, anchor: "middle", ..PLAIN };
                pen.text(x, self.bottom + 18.0, font, label);
            }
        }
        let base = self.across(column.base);
        pen.path(&[(base, top), (base, self.bottom + 4.0)], GREY, 1.0, " stroke-dasharray=\"6 4\"");
        let ends = [(self.left, self.bottom), (self.right, self.bottom)];
        pen.path(&ends, INK, 1.0, "");
        let font = Font { is_bold: true, ..PLAIN };
        pen.text(self.left, 70.0, font, &column.axis.label);
    }

    fn bar(&self, pen: &mut Pen, base: f64, y: f64, bar: Option<&Bar>) {
        let (estimate, number, ring) = match bar {
            None => return,
            Some(Bar::Words(words)) => {
                let font = Font { size: 11.0, color: MARK, ..PLAIN };
                return pen.text(self.right + 10.0, y + 4.0, font, words);
            }
            Some(Bar::Of(estimate, number, ring)) => (estimate, number, *ring),
        };
        let color = SERIES[0];
        let (from, to) = (self.across(base), self.across(estimate.median));
        let (x, width) = (from.min(to), (from - to).abs());
        let _ = writeln!(
            pen.out,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"10\" fill=\"{color}\" \
             fill-opacity=\"0.35\"/>",
            y - 5.0
        );
        let (low, high) = (self.across(estimate.low), self.across(estimate.high));
        pen.path(&[(low, y), (high, y)], color, 1.4, "");
        for end in [low, high] {
            pen.path(&[(end, y - 4.0), (end, y + 4.0)], color, 1.4, "");
        }
        pen.circle(to, y, color);
        pen.ring(to, y, ring);
        let font = Font { size: 11.0, is_bold: ring == Ring::Best, ..PLAIN };
        pen.text(self.right + 10.0, y + 4.0, font, number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg_plot::plot::Scale;

    fn sample(scale: Scale, values: &[f64]) -> BarChart {
        let bar = |&x: &f64| BarRow {
            name: format!("<{x}>"),
            bars: vec![
                Bar::Of(
                    Estimate { median: x, low: x * 0.9, high: x * 1.1 },
                    "n".into(),
                    Ring::Best,
                ),
                Bar::Words("wrong".into()),
            ],
        };
        let column = Column { axis: Axis { label: "a & b".into(), scale }, base: 1.0 };
        BarChart {
            title: "<t>".into(),
            subtitle: String::new(),
            columns: vec![column.clone(), column],
            rows: values.iter().map(bar).collect(),
        }
    }

    #[test]
    fn bars_are_as_long_as_their_values_and_texts_are_escaped() {
        let svg = chart(&sample(Scale::Log, &[1.0, 10.0, 100.0]));
        let tree = roxmltree::Document::parse(&svg).expect("well-formed XML");
        let bars = tree.descendants().filter(|n| n.attribute("height") == Some("10"));
        let widths: Vec<f64> =
            bars.map(|n| n.attribute("width").unwrap().parse().unwrap()).collect();
        assert_eq!((widths.len(), widths[0]), (3, 0.0));
        assert!((widths[2] - 2.0 * widths[1]).abs() < 0.2, "{widths:?}");
        let has = |text: &str| tree.descendants().any(|n| n.text() == Some(text));
        assert!(has("<t>") && has("<10>") && has("a & b") && has("wrong"));
    }

    #[test]
    fn odd_numbers_and_nothing_at_all_can_be_drawn() {
        for scale in [Scale::Log, Scale::FromZero, Scale::Linear] {
            for values in [&[f64::NAN, f64::INFINITY, -1.0, 0.0][..], &[]] {
                let svg = chart(&sample(scale.clone(), values));
                assert!(roxmltree::Document::parse(&svg).is_ok());
                assert!(!svg.contains("\"NaN") && !svg.contains("\"inf"), "{svg}");
            }
        }
    }
}
