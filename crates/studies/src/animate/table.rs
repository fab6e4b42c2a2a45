//! Tables of an animation, one per number of threads, rows with the most frames per second first;
//! and its CSV.

use crate::animate::record::{AnimationRecord, LaneRecord};
use crate::animate::verdict;
use measurement::record::Verdict;
use presentation::csv::{number, written};
use presentation::json::FormatError;
use presentation::markdown::{escaped, push_table};
use presentation::numbers;
use presentation::table::{Cell, Style, Table, dash};
use statistics::estimate::median;

/// Columns of most weight.
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
    let number = |frame: Option<&crate::animate::record::FrameRecord>| frame.map_or(0, |f| f.frame);
    let mean = |of: fn(&crate::animate::record::FrameRecord) -> Option<u64>| {
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
    let a_ray = |of: fn(&measurement::record::WorkRecord) -> u64| {
        let works = || lane.updates().iter().filter_map(|frame| frame.work.as_ref());
        let sum =
            |of: &dyn Fn(&measurement::record::WorkRecord) -> u64| works().map(of).sum::<u64>();
        let rays = sum(&|work| work.rays);
        match rays {
            0 => dash(),
            rays => format!("{:.2}", sum(&of) as f64 / rays as f64).into(),
        }
    };
    let mean = |of: fn(&crate::animate::record::LaneFrame) -> Option<f64>| {
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
                let a_ray = |of: fn(&measurement::record::WorkRecord) -> u64| {
                    number(frame.work.as_ref().map(|w| of(w) as f64 / w.rays.max(1) as f64))
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
                    a_ray(|work| work.intersection_tests),
                    a_ray(|work| work.traversal_steps),
                    number(frame.expected_cost),
                    number(frame.overlap),
                    lane.mismatches.to_string(),
                ])?;
            }
        }
        Ok(())
    })
}
