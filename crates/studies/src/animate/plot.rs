//! An animation as plots over its frames.

use presentation::svg_plot::{Axis, Plot, Point, Scale, Series, figure};
use statistics::estimate::{Estimate, estimate};

use crate::animate::record::{AnimationRecord, LaneFrame, LaneRecord};

/// Quantity plotted for a frame.
struct Quantity {
    title: &'static str,
    label: &'static str,
    scale: Scale,
    of: FrameValue,
}

type FrameValue = fn(&LaneRecord, &LaneFrame) -> Option<Estimate>;

const fn in_milliseconds(title: &'static str, of: FrameValue) -> Quantity {
    Quantity { title, label: "milliseconds", scale: Scale::Log, of }
}

fn measured(samples: &[f64]) -> Option<Estimate> {
    let ms: Vec<f64> = samples.iter().map(|s| s * 1e3).collect();
    estimate(&ms, 1)
}

const QUANTITIES: [Quantity; 4] = [
    in_milliseconds("update and rays", |_, frame| {
        let both = frame.update_s.iter().zip(&frame.trace_s).map(|(a, b)| a + b);
        measured(&both.collect::<Vec<_>>())
    }),
    in_milliseconds("update", |_, frame| measured(&frame.update_s)),
    in_milliseconds("rays", |_, frame| measured(&frame.trace_s)),
    Quantity {
        title: "expected cost (surface-area heuristic)",
        label: "times that of the first frame",
        scale: Scale::FromZero,
        of: |lane, frame| {
            let first = lane.frames.first()?.expected_cost?;
            Some(Estimate::exactly(frame.expected_cost? / first))
        },
    },
];

/// The rows with the most frames per second, so that curves can be distinguished.
const MOST_ROWS: usize = 8;

pub fn to_svg(run: &AnimationRecord) -> String {
    let rate = |lane: &LaneRecord| {
        lane.totals(run).and_then(|totals| totals.frames_per_second(run.seed)).map(|e| e.median)
    };
    let of_one = run.lanes.iter().filter(|lane| lane.threads == 1);
    let mut lanes: Vec<(&LaneRecord, f64)> =
        of_one.filter_map(|lane| Some((lane, rate(lane)?))).collect();
    lanes.sort_by(|a, b| b.1.total_cmp(&a.1));
    let left_out = lanes.len().saturating_sub(MOST_ROWS);
    lanes.truncate(MOST_ROWS);
    let subtitle = match left_out {
        0 => "medians with 95% intervals; one thread".to_owned(),
        n => format!(
            "medians with 95% intervals; one thread; the {MOST_ROWS} rows with the most frames per second of {}",
            n + MOST_ROWS
        ),
    };
    let panels: Vec<Plot> =
        QUANTITIES.iter().filter_map(|q| panel(run, &lanes, q, &subtitle)).collect();
    figure(&panels)
}

fn panel(
    run: &AnimationRecord,
    lanes: &[(&LaneRecord, f64)],
    quantity: &Quantity,
    subtitle: &str,
) -> Option<Plot> {
    let series: Vec<Series> = lanes
        .iter()
        .map(|(lane, _)| {
            let point = |frame: &LaneFrame| {
                let of = (quantity.of)(lane, frame)?;
                Some(Point { x: f64::from(frame.frame), y: of.median, low: of.low, high: of.high })
            };
            let points: Vec<Point> = lane.frames.iter().filter_map(point).collect();
            // a row has its colour in all panels, also where it has no points
            let none = if points.is_empty() { " (not known)" } else { "" };
            Series { name: lane.label() + none, points, is_joined: true }
        })
        .collect();
    series.iter().any(|series| !series.points.is_empty()).then(|| Plot {
        title: format!("{}: {}", run.scene, quantity.title),
        subtitle: subtitle.to_owned(),
        x: Axis { label: "frame".into(), scale: Scale::Linear },
        y: Axis { label: quantity.label.into(), scale: quantity.scale.clone() },
        series,
        ..Plot::default()
    })
}
