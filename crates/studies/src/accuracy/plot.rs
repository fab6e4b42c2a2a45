//! An axis as a plot: time against error, the front pointed out, one panel per scene.

use crate::accuracy::record::{AxisRecord, ErrorOf, SceneOutcome, VariantRecord, VariantStanding};
use presentation::svg_plot::{Axis, Level, Mark, Plot, Point, Ring, Scale, Series, figure};
use statistics::estimate::Estimate;

/// From this ratio of the largest to the smallest on, an axis is logarithmic.
const WIDE: f64 = 8.0;

pub fn to_svg(axis: &AxisRecord) -> String {
    let panels: Vec<Plot> = axis.scenes.iter().map(|scene| panel(axis, scene)).collect();
    figure(&panels)
}

pub fn panel(axis: &AxisRecord, scene: &SceneOutcome) -> Plot {
    let floor = floor(scene);
    let error = |row: &VariantRecord| match row.error.value() {
        e if e > 0.0 => e,
        _ => floor.unwrap_or(0.0),
    };
    let is_log = floor.is_some();
    let point = |row: &VariantRecord| {
        let Estimate { median: y, low, high } = row.ratio;
        Point { x: error(row), y, low, high }
    };
    let mut front: Vec<Point> =
        scene.rows.iter().filter(|r| r.standing == VariantStanding::OnFront).map(point).collect();
    front.sort_by(|a, b| a.x.total_cmp(&b.x));
    let mark = |row: &VariantRecord| Mark {
        hover: String::new(),
        point: point(row),
        label: row.variant.clone(),
        ring: match row.standing {
            VariantStanding::OnFront => Ring::Best,
            VariantStanding::NotToldApart => Ring::AsGood,
            VariantStanding::Dominated => Ring::None,
        },
        is_in_series: row.standing == VariantStanding::OnFront,
    };
    let slowest = scene.rows.iter().map(|r| r.ratio.median).fold(1.0, f64::max);
    let has_zero = is_log && scene.rows.iter().any(|r| r.error.value() == 0.0);
    let mut subtitle = format!("timed: {}; bars: 95% intervals", scene.timed);
    if has_zero {
        subtitle.push_str("; errors of 0 stand at the left end");
    }
    let mut levels = vec![Level { y: 1.0, label: "cheapest variant = 1".into() }];
    levels.truncate(usize::from(slowest.is_finite()));
    Plot {
        title: format!("{}: {}", axis.axis, scene.place()),
        subtitle,
        x: Axis {
            label: axis.metric.clone(),
            scale: if is_log { Scale::Log } else { Scale::FromZero },
        },
        y: Axis {
            label: "time / time of the cheapest variant".into(),
            scale: if slowest >= WIDE { Scale::Log } else { Scale::FromZero },
        },
        series: vec![Series { name: "Pareto front".into(), points: front, is_joined: true }],
        marks: scene.rows.iter().map(mark).collect(),
        marks_name: "dominated".into(),
        levels,
    }
}

/// Position of errors of 0 on a logarithmic axis: half the bound given by the number of trials, or
/// a third of the least error; `None` if no error is above 0.
fn floor(scene: &SceneOutcome) -> Option<f64> {
    let least = scene.rows.iter().map(|r| r.error.value()).filter(|e| *e > 0.0).reduce(f64::min)?;
    let bound = scene.rows.iter().find_map(|row| match row.error {
        ErrorOf::Counted { .. } => row.error.bound(),
        ErrorOf::Rmse { .. } => None,
    });
    Some(bound.map_or(least / 3.0, |b| (b / 2.0).min(least / 3.0)))
}
