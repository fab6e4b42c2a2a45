//! An animation as tables, one per number of threads, rows with the most frames per second first; its
//! CSV; and plots over its frames.

use measurement::record::{Verdict, WorkRecord};
use presentation::csv::{number, written};
use presentation::json::FormatError;
use presentation::markdown::{escaped, push_table};
use presentation::numbers;
use presentation::svg_plot::{Axis, Plot, Point, Scale, Series, figure};
use presentation::table::{Cell, Style, Table, dash};
use statistics::estimate::{Estimate, estimate, median};

use crate::animate::record::{AnimationRecord, FrameRecord, LaneFrame, LaneRecord};
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
    let mut lanes: Vec<_> = run
        .lanes
        .iter()
        .filter(|lane| lane.threads == threads)
        .map(|lane| {
            let rate = lane.totals(run).and_then(|totals| totals.frames_per_second(run.seed));
            (lane, rate)
        })
        .collect();
    // what is not timed comes last
    let rate = |rate: &Option<statistics::estimate::Estimate>| rate.map_or(-1.0, |r| r.median);
    lanes.sort_by(|a, b| rate(&b.1).total_cmp(&rate(&a.1)));
    let header = vec![
        "structure",
        "frames/s",
        "worst ms",
        "frame",
        "update ms",
        "trace ms",
        "updated %",
        "MiB",
        "N_IT",
        "N_TS",
        "cost",
        "cost x",
        "overlap",
        "verdict",
    ];
    let rows = lanes.iter().map(|(lane, rate)| {
        let mut cells: Vec<Cell> = vec![lane.label().into()];
        cells.push(rate.map_or_else(dash, |rate| numbers::interval(&rate).into()));
        cells.extend(of_times(run, lane));
        cells.extend(of_structure(lane));
        cells.push(verdict_cell(lane));
        cells
    });
    let mut notes: Vec<String> = verdict::lines(run, threads);
    for (lane, _) in &lanes {
        let said = lane.error.as_ref().or(lane.example.as_ref());
        notes.extend(said.map(|said| format!("{}: {said}", lane.label())));
    }
    Table { title: title(run, threads), header, rows: rows.collect(), notes }
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

fn of_times(run: &AnimationRecord, lane: &LaneRecord) -> Vec<Cell> {
    let ms =
        |samples: &[f64]| median(samples).map_or_else(dash, |s| numbers::milliseconds(s).into());
    let Some(totals) = lane.totals(run) else { return (0..5).map(|_| dash()).collect() };
    let worst = lane.worst();
    vec![
        worst.map_or_else(dash, |(_, seconds)| numbers::milliseconds(seconds).into()),
        worst.map_or_else(dash, |(frame, _)| frame.to_string().into()),
        ms(&totals.update_s),
        ms(&totals.trace_s),
        format!("{:.0}", 100.0 * lane.updated()).into(),
    ]
}

/// Memory at its most, work and quality on average.
fn of_structure(lane: &LaneRecord) -> Vec<Cell> {
    let bytes = lane.frames.iter().map(|frame| frame.bytes).max();
    let works: Vec<&WorkRecord> = lane.updates().iter().filter_map(|f| f.work.as_ref()).collect();
    let sum = |of: fn(&WorkRecord) -> u64| works.iter().map(|work| of(work)).sum::<u64>() as f64;
    let rays = sum(|work| work.rays);
    let a_ray = |of| if rays > 0.0 { format!("{:.2}", sum(of) / rays).into() } else { dash() };
    let mean = |of: fn(&LaneFrame) -> Option<f64>| {
        let all: Vec<f64> = lane.updates().iter().filter_map(of).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
    };
    let first = lane.frames.first().and_then(|frame| frame.expected_cost);
    let last = lane.frames.last().and_then(|frame| frame.expected_cost);
    let grown = first.zip(last).map(|(first, last)| last / first);
    let short = |x: Option<f64>| x.map_or_else(dash, |x| numbers::short(x).into());
    vec![
        bytes.map_or_else(dash, |bytes| numbers::mebibytes(bytes).into()),
        a_ray(|work| work.intersection_tests),
        a_ray(|work| work.traversal_steps),
        short(mean(|frame| frame.expected_cost)),
        short(grown),
        short(mean(|frame| frame.overlap)),
    ]
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

pub fn frames(run: &AnimationRecord) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record([
            "scene",
            "frame",
            "primitives",
            "moved",
            "rays",
            "structure",
            "settings",
            "threads",
            "rounds",
            "updated",
            "update_s",
            "trace_s",
            "every_nth_ray",
            "bytes",
            "n_it",
            "n_ts",
            "expected_cost",
            "overlap",
            "mismatches_of_all_frames",
        ])?;
        for lane in &run.lanes {
            for frame in &lane.frames {
                let of = run.frames.iter().find(|f| f.frame == frame.frame);
                let count = |n: Option<u64>| n.map(|n| n.to_string()).unwrap_or_default();
                let shown = |samples: &[f64]| number(median(samples).filter(|_| lane.is_timed()));
                let [n_it, n_ts, ..] = match &frame.work {
                    Some(work) => work.per_ray().map(Some),
                    None => [None; 4],
                };
                writer.write_record([
                    run.scene.clone(),
                    frame.frame.to_string(),
                    count(of.map(|f| f.primitives)),
                    count(of.and_then(|f| f.moved)),
                    count(of.map(|f| f.rays)),
                    lane.structure.clone(),
                    lane.settings.clone(),
                    lane.threads.to_string(),
                    frame.update_s.len().to_string(),
                    frame.updated.to_string(),
                    shown(&frame.update_s),
                    shown(&frame.trace_s),
                    lane.stride.to_string(),
                    frame.bytes.to_string(),
                    number(n_it),
                    number(n_ts),
                    number(frame.expected_cost),
                    number(frame.overlap),
                    lane.mismatches.to_string(),
                ])?;
            }
        }
        Ok(())
    })
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
