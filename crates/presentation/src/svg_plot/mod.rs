//! Plots as SVG, without a plotting library: curves with error bars, labelled marks, linear,
//! logarithmic and word axes. The same plots always give the same text.
//!
//! (The library that is in our dependency tree, `plotters` 0.3.7, has no marks with labels that
//! keep clear of each other, and saw its last release in 2024.)

pub mod bars;
mod panel;
pub mod pen;
mod plot;

use std::fmt::Write;

pub use pen::Format;
pub use plot::{Axis, Level, Mark, Plot, Point, Ring, Scale, Series};

use pen::document_of;

/// A figure that can be drawn in every format.
pub trait Figure {
    fn svg(&self, format: Format) -> String;
}

impl Figure for Plot {
    fn svg(&self, format: Format) -> String {
        drawn(std::slice::from_ref(self), format)
    }
}

/// The plots, one below the other.
pub fn figure(plots: &[Plot]) -> String {
    drawn(plots, Format::Wide)
}

fn drawn(plots: &[Plot], format: Format) -> String {
    let mut body = String::new();
    let mut top = 0.0;
    for plot in plots {
        let (elements, height) = panel::draw(plot, format);
        let _ = write!(body, "<g transform=\"translate(0 {top:.1})\">\n{elements}</g>\n");
        top += height;
    }
    let titles: Vec<&str> = plots.iter().map(|plot| plot.title.as_str()).collect();
    document_of(&body, [format.width(), top], &titles.join("; "))
}

#[cfg(test)]
mod tests {
    use super::plot::WIDTH;
    use super::*;

    fn point(x: f64, y: f64) -> Point {
        Point { x, y, low: 0.9 * y, high: 1.1 * y }
    }

    fn plot(x: Scale, y: Scale) -> Plot {
        let axis = |label: &str, scale| Axis { label: label.into(), scale };
        Plot {
            title: "a < b & \"c\" > 'd' \u{1}".into(),
            subtitle: "all of it".into(),
            x: axis("cells", x),
            y: axis("time (s)", y),
            series: vec![Series {
                name: "values".into(),
                points: vec![point(0.0, 3.0), point(1.0, 2.0), point(2.0, 4.0)],
                is_joined: true,
            }],
            marks: vec![
                Mark {
                    hover: String::new(),
                    point: point(1.0, 2.0),
                    label: "best: 1".into(),
                    ring: Ring::Best,
                    is_in_series: true,
                },
                Mark {
                    hover: String::new(),
                    point: point(1.0, 2.5),
                    label: "rule: <woo>".into(),
                    ring: Ring::None,
                    is_in_series: false,
                },
            ],
            marks_name: "rules of thumb".into(),
            levels: vec![Level { y: 1.0, label: "reference = 1".into() }],
        }
    }

    /// The texts of a figure, which must be well-formed.
    fn texts(svg: &str) -> Vec<String> {
        let tree = roxmltree::Document::parse(svg).expect("well-formed XML");
        let texts = tree.descendants().filter(|n| n.has_tag_name("text"));
        texts.map(|n| n.text().unwrap_or_default().to_owned()).collect()
    }

    #[test]
    fn texts_are_escaped_and_all_there() {
        let svg = figure(&[plot(Scale::Linear, Scale::FromZero)]);
        let texts = texts(&svg);
        for text in [
            "a < b & \"c\" > 'd' \u{fffd}",
            "all of it",
            "cells",
            "time (s)",
            "values",
            "best: 1",
            "rule: <woo>",
            "rules of thumb",
            "reference = 1",
        ] {
            assert!(texts.iter().any(|t| t == text), "{text}: {texts:?}");
        }
    }

    #[test]
    fn words_stand_at_their_places() {
        let words = ["none", "array", "hash"].map(String::from).to_vec();
        let texts = texts(&figure(&[plot(Scale::Words(words), Scale::Log)]));
        for word in ["none", "array", "hash"] {
            assert!(texts.iter().any(|t| t == word), "{texts:?}");
        }
    }

    #[test]
    fn points_without_a_logarithm_are_left_out() {
        let svg = figure(&[plot(Scale::Log, Scale::Log)]);
        let tree = roxmltree::Document::parse(&svg).unwrap();
        let circles = tree.descendants().filter(|n| n.has_tag_name("circle")).count();
        assert_eq!(circles, 2 + 1, "not the point at x = 0; one in the legend");
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn odd_numbers_and_nothing_at_all_can_be_drawn() {
        for scale in [Scale::Linear, Scale::FromZero, Scale::Log, Scale::Words(Vec::new())] {
            let mut odd = plot(scale.clone(), scale.clone());
            for p in &mut odd.series[0].points {
                *p = Point { x: f64::NAN, y: f64::INFINITY, low: -1.0, high: f64::MAX };
            }
            let mut none = plot(scale.clone(), scale);
            none.series.clear();
            none.marks.clear();
            none.levels.clear();
            let svg = figure(&[odd, none]);
            texts(&svg);
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
        texts(&figure(&[]));
    }

    #[test]
    fn many_series_have_distinct_styles_and_a_legend() {
        let mut many = plot(Scale::Linear, Scale::Linear);
        many.marks.clear();
        let one = many.series[0].clone();
        many.series =
            (0..18).map(|i| Series { name: format!("series number {i}"), ..one.clone() }).collect();
        let svg = figure(&[many.clone()]);
        let tree = roxmltree::Document::parse(&svg).unwrap();
        let number = |n: &roxmltree::Node<'_, '_>, name| n.attribute(name)?.parse::<f64>().ok();
        let named: Vec<(f64, f64)> = tree
            .descendants()
            .filter(|n| n.text().is_some_and(|t| t.starts_with("series number")))
            .filter_map(|n| number(&n, "x").zip(number(&n, "y")))
            .collect();
        assert_eq!(named.len(), 18);
        let height = number(&tree.root_element(), "height").unwrap();
        assert!(named.iter().all(|(x, y)| *x < WIDTH - 80.0 && *y < height), "{named:?} {height}");
        assert!(named[17].1 > named[0].1, "more than one line");
        let lines = tree.descendants().filter(|n| n.has_tag_name("polyline"));
        let curves = lines.filter(|n| n.attribute("stroke-width") == Some("1.8"));
        let mut styles: Vec<_> =
            curves.map(|n| (n.attribute("stroke"), n.attribute("stroke-dasharray"))).collect();
        styles.sort_unstable();
        styles.dedup();
        assert_eq!(styles.len(), 18, "no two look the same");
        // a few series look as they did when there was but one line
        many.series.truncate(3);
        assert!(!figure(&[many]).contains("7 3"));
    }

    #[test]
    fn a_phone_shows_the_same_within_its_width() {
        let mut long = plot(Scale::Linear, Scale::Log);
        long.marks[0].label = "wide-bvh with settings that are long".into();
        long.series[0].name = "a series of a name that is so long that it has to be broken".into();
        let svg = long.svg(Format::Narrow);
        let tree = roxmltree::Document::parse(&svg).unwrap();
        let width: f64 = tree.root_element().attribute("width").unwrap().parse().unwrap();
        assert_eq!(width, Format::Narrow.width());
        for text in tree.descendants().filter(|n| n.has_tag_name("text")) {
            let x: f64 = text.attribute("x").unwrap().parse().unwrap();
            let length = text.text().unwrap().chars().count() as f64 * pen::LETTER;
            let is_at_start = text.attribute("text-anchor") == Some("start");
            assert!(!is_at_start || x + length <= width + 1.0, "{:?}", text.text());
        }
        let all = texts(&svg).join(" ");
        assert!(all.contains("a: wide-bvh with settings that are long"), "{all}");
        let frame = tree.descendants().find(|n| n.attribute("stroke") == Some(pen::INK));
        assert!(frame.is_some());
    }

    #[test]
    fn the_same_plots_give_the_same_text() {
        let one = || figure(&[plot(Scale::Linear, Scale::Log), plot(Scale::Log, Scale::Linear)]);
        assert_eq!(one(), one());
    }
}
