//! A scene in several sizes as plots: a panel for each quantity, both axes logarithmic.

use crate::sweep::sizes::quantities::{QUANTITIES, Quantity, points, rows};
use measurement::record::{RowRecord, RunRecord, Verdict};
use presentation::svg_plot::{Axis, Plot, Point, Scale, Series, figure};
use statistics::estimate::Estimate;

/// The panels that have something to show.
pub fn to_svg(run: &RunRecord) -> String {
    let panels: Vec<Plot> = QUANTITIES.iter().filter_map(|quantity| panel(run, quantity)).collect();
    figure(&panels)
}

fn panel(run: &RunRecord, quantity: &Quantity) -> Option<Plot> {
    let scale = run.scale.as_ref()?;
    let series: Vec<Series> = rows(&run.scenes)
        .into_iter()
        .map(|row| series(run, row, quantity))
        .filter(|series| !series.points.is_empty())
        .collect();
    let axis = |label: &str| Axis { label: label.to_owned(), scale: Scale::Log };
    (!series.is_empty()).then(|| Plot {
        title: format!("{}: {}", scale.scene, quantity.label),
        subtitle: subtitle(run),
        x: axis("primitives"),
        y: axis(quantity.label),
        series,
        ..Plot::default()
    })
}

/// A row's curve; the legend has its slope.
fn series(run: &RunRecord, row: &RowRecord, quantity: &Quantity) -> Series {
    let point = |&(x, Estimate { median: y, low, high }): &_| Point { x, y, low, high };
    let label = row.label();
    let slope = run.scale.as_ref().and_then(|scale| scale.slope(&label, quantity.name));
    Series {
        name: slope.map_or_else(|| label.clone(), |s| format!("{label} ({:.2})", s.slope)),
        points: points(&run.scenes, row, quantity).iter().map(point).collect(),
        is_joined: true,
    }
}

/// Subtitle: the quantity, and rows missing at some size.
fn subtitle(run: &RunRecord) -> String {
    let mut text = "medians with 95% intervals; in parentheses the slope".to_owned();
    let hidden = rows(&run.scenes).into_iter().filter(|row| {
        let same = run.scenes.iter().flat_map(|s| &s.rows).filter(|other| other.is_same(row));
        same.map(|row| row.verdict).any(|verdict| verdict != Verdict::Ok)
    });
    let hidden: Vec<String> = hidden.map(RowRecord::label).collect();
    match hidden.len() {
        0 => {}
        1..=3 => text.push_str(&format!("; not ok at some size: {}", hidden.join(", "))),
        n => text.push_str(&format!("; {n} rows are not ok at some size")),
    }
    text
}
