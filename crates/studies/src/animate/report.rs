//! An animation as tables, one per number of threads, rows with the most frames per second first; its
//! CSV; and plots over its frames.

use measurement::record::{Verdict, WorkRecord};
use presentation::column::{self, Column, Unit, Value};
use presentation::json::FormatError;
use presentation::markdown::{escaped, push_table};
use presentation::numbers;
use presentation::svg_plot::{Axis, Plot, Point, Scale, Series, figure};
use presentation::table::{Cell, Style, Table};
use statistics::estimate::{Estimate, estimate, median};

use crate::animate::record::{
    AnimationRecord, FrameRecord, LaneFrame, LaneRecord, RankedLane, Totals,
};
use crate::animate::verdict;

pub const FIRST: [&str; 5] = ["frames/s", "verdict", "update ms", "trace ms", "worst ms"];

/// The tables, with what is said below each.
pub fn tables(run: &AnimationRecord) -> Vec<Table> {
    let mut threads: Vec<usize> = run.lanes.iter().map(|lane| lane.threads).collect();
    threads.sort_unstable();
    threads.dedup();
    threads.into_iter().map(|threads| table(run, threads)).collect()
}

fn table(run: &AnimationRecord, threads: usize) -> Table {
    let lanes = run.ranked(threads);
    let mut notes: Vec<String> = verdict::lines(run, &lanes, threads);
    for RankedLane { lane, .. } in &lanes {
        let said = lane.error.as_ref().or(lane.example.as_ref());
        notes.extend(said.map(|said| format!("{}: {said}", lane.label())));
    }
    let columns = lane_columns();
    let heads = column::heads(&columns);
    Table { title: title(run, threads), notes, ..column::table(&columns, &heads, &lanes) }
}

/// Columns of the rows: memory at its most, work and quality on average.
#[rustfmt::skip]
fn lane_columns<'a>() -> [Column<RankedLane<'a>>; 14] {
    use Unit::{Bytes, None, PerRay, Seconds};
    use Value::{Count, Real, Text};
    let c = |head, unit, of| Column::new(&[], head, unit, of);
    [
        c("structure", None, |of: &RankedLane<'a>| Text(of.lane.label())),
        c("frames/s", None, |of| Value::of(of.rate, Value::Measured))
            .or(|of| of.rate.map(|rate| numbers::interval(&rate).into())),
        c("worst ms", Seconds, |of| Value::of(of.worst(), |(_, seconds)| Real(seconds))),
        c("frame", None, |of| Value::of(of.worst(), |(frame, _)| Count(frame.into()))),
        c("update ms", Seconds, |of| of.median(|totals| &totals.update_s)),
        c("trace ms", Seconds, |of| of.median(|totals| &totals.trace_s)),
        c("updated %", None, |of| of.median(|totals| &totals.update_s))
            .or(|of| of.totals.as_ref().map(|_| format!("{:.0}", 100.0 * of.lane.updated()).into())),
        c("MiB", Bytes, |of| Value::of(of.lane.frames.iter().map(|frame| frame.bytes).max(), Count)),
        c("N_IT", PerRay, |of| per_ray(of.lane, |work| work.intersection_tests)),
        c("N_TS", PerRay, |of| per_ray(of.lane, |work| work.traversal_steps)),
        c("cost", None, |of| mean(of.lane, |frame| frame.expected_cost)),
        c("cost x", None, |of| {
            let of_frame = |frame: Option<&LaneFrame>| frame.and_then(|frame| frame.expected_cost);
            let (first, last) = (of_frame(of.lane.frames.first()), of_frame(of.lane.frames.last()));
            Value::of(first.zip(last), |(first, last)| Real(last / first))
        }),
        c("overlap", None, |of| mean(of.lane, |frame| frame.overlap)),
        c("verdict", None, |_| Value::None).or(|of| Some(verdict_cell(of.lane))),
    ]
}

impl RankedLane<'_> {
    fn worst(&self) -> Option<(u32, f64)> {
        self.totals.as_ref().and_then(|_| self.lane.worst())
    }

    fn median(&self, of: fn(&Totals) -> &Vec<f64>) -> Value {
        Value::of(self.totals.as_ref().and_then(|totals| median(of(totals))), Value::Real)
    }
}

fn per_ray(lane: &LaneRecord, of: fn(&WorkRecord) -> u64) -> Value {
    let works: Vec<&WorkRecord> = lane.updates().iter().filter_map(|f| f.work.as_ref()).collect();
    let sum = |of: fn(&WorkRecord) -> u64| works.iter().map(|work| of(work)).sum::<u64>() as f64;
    let rays = sum(|work| work.rays);
    Value::of((rays > 0.0).then(|| sum(of) / rays), Value::Real)
}

fn mean(lane: &LaneRecord, of: fn(&LaneFrame) -> Option<f64>) -> Value {
    let all: Vec<f64> = lane.updates().iter().filter_map(of).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    Value::of((!all.is_empty()).then_some(mean), Value::Real)
}

fn title(run: &AnimationRecord, threads: usize) -> String {
    let (first, last) = (run.frames.first(), run.frames.last());
    let number = |frame: Option<&FrameRecord>| frame.map_or(0, |f| f.frame);
    let mean = |of: fn(&FrameRecord) -> Option<u64>| {
        let all: Vec<f64> = run.frames.iter().filter_map(of).map(|n| n as f64).collect();
        let sum: f64 = all.iter().sum();
        (sum / all.len().max(1) as f64).round()
    };
    format!(
        "{}, frames {} to {}: {} primitives, {} of them moved from frame to frame on average; {} rays per frame ({}), \
         {threads} thread{}",
        run.scene,
        number(first),
        number(last),
        mean(|frame| Some(frame.primitives)),
        mean(|frame| frame.moved),
        mean(|frame| Some(frame.rays)),
        run.kinds.join(", "),
        if threads == 1 { "" } else { "s" }
    )
}

fn verdict_cell(lane: &LaneRecord) -> Cell {
    let verdict = lane.verdict();
    match (verdict, lane.stride) {
        (Verdict::Ok, 1) => "ok".to_owned().into(),
        (Verdict::Ok, n) => format!("ok, every {n}th ray").into(),
        (Verdict::NotBuilt, _) => Cell { text: "ended early".into(), style: Style::Bad },
        (_, _) => {
            let text = format!("{} wrong", lane.mismatches);
            let known = lane.known_defect.is_some();
            Cell { text, style: if known { Style::Plain } else { Style::Bad } }
        }
    }
}

pub fn to_markdown(run: &AnimationRecord) -> String {
    let mut text = format!("# rtbench animate: {}\n", escaped(&run.scene));
    for table in tables(run) {
        text.push('\n');
        push_table(&mut text, &table);
    }
    for line in GLOSSARY {
        text.push_str(&format!("\n* {line}"));
    }
    text.push('\n');
    text
}

pub const GLOSSARY: &[&str] = &[
    "frames/s: frames after the first one over the time of their updates and rays, the median of the rounds with \
     its 95% interval; a round is a structure of its own, taken from frame to frame. worst: the slowest of these \
     frames, and which. update, trace: milliseconds per frame. updated: how many of the updates were no builds. \
     Loading a frame, finding out what moved, and checking are not timed.",
    "MiB: the most in any frame. N_IT, N_TS: tests and steps per ray. cost: cells that a random line meets, and \
     primitives in them (surface-area heuristic), the mean of the frames; cost x: that of the last frame over that \
     of the first. overlap: cost of the cells around a point of the scene's surface that do not hold it (end-point \
     overlap), of random points.",
];

/// A row in a frame.
struct FrameRow<'a> {
    run: &'a AnimationRecord,
    lane: &'a LaneRecord,
    frame: &'a LaneFrame,
}

impl FrameRow<'_> {
    /// A count of the frame itself.
    fn count(&self, of: fn(&FrameRecord) -> Option<u64>) -> Value {
        let frame = self.run.frames.iter().find(|f| f.frame == self.frame.frame);
        Value::of(frame.and_then(of), Value::Count)
    }

    fn median(&self, samples: &[f64]) -> Value {
        Value::of(median(samples).filter(|_| self.lane.is_timed()), Value::Real)
    }

    fn work(&self, counter: usize) -> Value {
        let per_ray = self.frame.work.as_ref().map(WorkRecord::per_ray);
        Value::of(per_ray.and_then(|work| work.get(counter).copied()), Value::Real)
    }
}

#[rustfmt::skip]
fn frame_columns<'a>() -> [Column<FrameRow<'a>>; 19] {
    use Value::{Count, Real, Text};
    let c = |keys, of| Column::new(keys, "", Unit::None, of);
    [
        c(&["scene"], |of: &FrameRow<'a>| Text(of.run.scene.clone())),
        c(&["frame"], |of| Count(of.frame.frame.into())),
        c(&["primitives"], |of| of.count(|frame| Some(frame.primitives))),
        c(&["moved"], |of| of.count(|frame| frame.moved)),
        c(&["rays"], |of| of.count(|frame| Some(frame.rays))),
        c(&["structure"], |of| Text(of.lane.structure.clone())),
        c(&["settings"], |of| Text(of.lane.settings.clone())),
        c(&["threads"], |of| Count(of.lane.threads as u64)),
        c(&["rounds"], |of| Count(of.frame.update_s.len() as u64)),
        c(&["updated"], |of| Count(of.frame.updated as u64)),
        c(&["update_s"], |of| of.median(&of.frame.update_s)),
        c(&["trace_s"], |of| of.median(&of.frame.trace_s)),
        c(&["every_nth_ray"], |of| Count(of.lane.stride as u64)),
        c(&["bytes"], |of| Count(of.frame.bytes)),
        c(&["n_it"], |of| of.work(0)),
        c(&["n_ts"], |of| of.work(1)),
        c(&["expected_cost"], |of| Value::of(of.frame.expected_cost, Real)),
        c(&["overlap"], |of| Value::of(of.frame.overlap, Real)),
        c(&["mismatches_of_all_frames"], |of| Count(of.lane.mismatches)),
    ]
}

/// Each row in each frame as CSV.
pub fn frames(run: &AnimationRecord) -> Result<String, FormatError> {
    let rows = run
        .lanes
        .iter()
        .flat_map(|lane| lane.frames.iter().map(move |frame| FrameRow { run, lane, frame }));
    column::csv(&frame_columns(), rows)
}

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
    let mut lanes = run.ranked(1);
    lanes.retain(|lane| lane.rate.is_some());
    let mut subtitle = "medians with 95% intervals; one thread".to_owned();
    if lanes.len() > MOST_ROWS {
        subtitle +=
            &format!("; the {MOST_ROWS} rows with the most frames per second of {}", lanes.len());
    }
    lanes.truncate(MOST_ROWS);
    let panels: Vec<Plot> =
        QUANTITIES.iter().filter_map(|q| panel(run, &lanes, q, &subtitle)).collect();
    figure(&panels)
}

fn panel(
    run: &AnimationRecord,
    lanes: &[RankedLane<'_>],
    quantity: &Quantity,
    subtitle: &str,
) -> Option<Plot> {
    let series: Vec<Series> = lanes
        .iter()
        .map(|RankedLane { lane, .. }| {
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
