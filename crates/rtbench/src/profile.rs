//! What the time of rows is spent on: work a ray and lines of memory a ray, against what the machine
//! needs for a load.
//!
//! A ray is a chain of loads, each of which must arrive before the next address is known. If nothing
//! else were going on, the loads that miss a cache would cost their latencies one after the other:
//! that is the column `waits`. A row that is faster than its waits has several loads on their way at
//! once, of several rays or by the processor's looking ahead; one that is much slower is held up by
//! instructions, not by memory.
//!
//! Lines are counted by a simulation ([`measurement::callgrind::caches`]), latencies are measured
//! ([`crate::doctor::memory`]), times are those of the run.

use crate::doctor::memory::{Latency, interpolated};
use measurement::callgrind::simulation::{CacheLevel, Fetched};
use measurement::record::summary::summarize;
use measurement::record::{
    Answered, RunRecord, SceneRecord, SummaryRow, Verdict, label, reference,
};
use presentation::numbers::short;
use presentation::table::{Cell, Table, dash};
use statistics::estimate::median;

/// Rows that are profiled where none are named.
const ROWS: usize = 3;

/// Where a line may come from beyond the first level.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    /// `L2`, `L3`, `memory`.
    name: String,
    /// Seconds of a load from there.
    load_s: f64,
}

/// Caches and what loads from them take.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    first: String,
    sources: Vec<Source>,
}

impl Machine {
    /// A load from a level takes what it takes among half as many bytes as the level holds; one from
    /// memory what it takes among the most bytes that were timed.
    pub fn new(caches: &[CacheLevel], latencies: &[Latency]) -> Self {
        let load_s = |bytes: f64| interpolated(latencies, bytes).unwrap_or(0.0);
        let of = |cache: &CacheLevel| Source {
            name: format!("L{}", cache.level),
            load_s: load_s(cache.bytes as f64 / 2.0),
        };
        let mut all = caches.iter().map(of);
        let first = all.next().map(|source| source.name).unwrap_or_default();
        let memory = Source { name: "memory".into(), load_s: load_s(f64::INFINITY) };
        Self { first, sources: all.chain([memory]).collect() }
    }

    /// Lines that came from each source, of those that each level missed.
    fn lines(&self, missed: &[u64]) -> Vec<u64> {
        let beyond = missed.iter().skip(1).copied().chain([0]);
        missed.iter().zip(beyond).map(|(here, beyond)| here.saturating_sub(beyond)).collect()
    }
}

/// The rows that trace fastest over the scenes that have the same reference, of those that answered
/// all rays of all scenes rightly.
pub fn fastest_rows(record: &RunRecord) -> Vec<String> {
    let reference = reference::of_means(&record.scenes, &record.settings.reference);
    let scenes = reference::scenes_over(&record.scenes, &reference);
    let is_whole = |row: &&SummaryRow| {
        row.verdict == Verdict::Ok
            && row.answers == Answered::AllRays
            && row.scenes as usize == scenes
    };
    let summary = summarize(&record.scenes, &record.settings);
    let rows = summary.iter().filter(is_whole);
    let mut rows: Vec<(f64, String)> = rows
        .filter_map(|row| Some((row.ratio?.median, label(&row.structure, &row.settings))))
        .collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.into_iter().take(ROWS).map(|(_, label)| label).collect()
}

/// One table per scene.
pub fn tables(record: &RunRecord, fetched: &[Fetched], machine: &Machine) -> Vec<Table> {
    let of_scene = |scene: &SceneRecord| {
        let own = fetched.iter().filter(|f| f.batch.scene == scene.name);
        let rows: Vec<Vec<Cell>> = own.map(|f| cells(scene, f, machine)).collect();
        Table {
            title: format!("{}: cost per ray", scene.name),
            header: HEADER.into(),
            rows,
            notes: notes(machine),
        }
    };
    record.scenes.iter().map(of_scene).collect()
}

const HEADER: [&str; 12] = [
    "row",
    "query",
    "rays",
    "ns",
    "tests",
    "steps",
    "instr.",
    "refs",
    "lines",
    "far lines",
    "memory lines",
    "waits ns",
];

fn cells(scene: &SceneRecord, fetched: &Fetched, machine: &Machine) -> Vec<Cell> {
    let batch = &fetched.batch;
    let row = scene
        .rows
        .iter()
        .find(|row| row.structure == batch.structure && row.settings == batch.settings);
    let ns = row.and_then(|row| {
        let rays = *row.rays_by_kind.get(&batch.name)? as f64;
        let seconds = row.samples.iter().filter_map(|s| s.trace_s.get(&batch.name).copied());
        Some(1e9 * median(&seconds.collect::<Vec<_>>())? / rays)
    });
    let rays = batch.rays.max(1) as f64;
    let a_ray = |count: u64| Cell::from(short(count as f64 / rays));
    let lines = machine.lines(&fetched.missed);
    let waits: f64 = lines.iter().zip(&machine.sources).map(|(n, s)| *n as f64 * s.load_s).sum();
    let beyond = |level: usize| fetched.missed.get(level).map_or_else(dash, |n| a_ray(*n));
    vec![
        label(&batch.structure, &batch.settings).into(),
        row.map_or_else(dash, |row| row.query.name().to_owned().into()),
        batch.name.clone().into(),
        ns.map_or_else(dash, |ns| short(ns).into()),
        a_ray(batch.tests),
        a_ray(batch.steps),
        a_ray(fetched.instructions),
        a_ray(fetched.references),
        beyond(0),
        beyond(1),
        fetched.missed.last().filter(|_| fetched.missed.len() > 2).map_or_else(dash, |n| a_ray(*n)),
        short(1e9 * waits / rays).into(),
    ]
}

fn notes(machine: &Machine) -> Vec<String> {
    let named = machine.sources.iter().map(|s| format!("{} {} ns", s.name, short(1e9 * s.load_s)));
    let named: Vec<String> = named.collect();
    let second = machine.sources.first().map_or("", |source| &source.name);
    vec![
        "A ray takes, on the average of its kind: ns in the run; tests and steps as a run counts them; \
         instructions, reads and writes."
            .into(),
        format!(
            "lines: those of 64 bytes that {} misses; far lines: that {second} misses as well; memory \
             lines: that no cache has (simulated, with no prefetcher). waits: what these lines would \
             take one after the other, at the measured latencies: {}.",
            machine.first,
            named.join(", ")
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::callgrind::caches::AskedBatch;
    use measurement::record::made_up::{Rows, run};

    fn machine() -> Machine {
        let level = |level, bytes| CacheLevel { level, bytes, ways: 8, line: 64 };
        let caches = [level(1, 32 << 10), level(2, 512 << 10), level(3, 32 << 20)];
        let latency = |bytes, ns: f64| Latency { bytes, load_s: ns * 1e-9 };
        let latencies = [
            latency(16 << 10, 1.0),
            latency(256 << 10, 4.0),
            latency(16 << 20, 50.0),
            latency(256 << 20, 100.0),
        ];
        Machine::new(&caches, &latencies)
    }

    #[test]
    fn lines_wait_where_they_come_from() {
        let machine = machine();
        let names: Vec<&str> = machine.sources.iter().map(|s| s.name.as_str()).collect();
        assert_eq!((machine.first.as_str(), names), ("L1", vec!["L2", "L3", "memory"]));
        assert_eq!(machine.lines(&[100, 30, 10]), [70, 20, 10]);
        let record = run(&[("tetra", &[("obvhs-cwbvh", &[256e-6, 256e-6])])]);
        let fetched = Fetched {
            batch: AskedBatch {
                scene: "tetra".into(),
                structure: "obvhs-cwbvh".into(),
                settings: String::new(),
                name: "primary".into(),
                rays: 10,
                tests: 20,
                steps: 50,
            },
            instructions: 1000,
            references: 400,
            missed: vec![100, 30, 10],
        };
        let tables = tables(&record, &[fetched], &machine);
        let cells: Vec<&str> = tables[0].rows[0].iter().map(|cell| cell.text.as_str()).collect();
        // 7 * 4 + 2 * 50 + 1 * 100 = 228 ns per ray; 256 us for 256 rays in the run
        assert_eq!(
            cells,
            [
                "obvhs-cwbvh",
                "one ray",
                "primary",
                "1000",
                "2.00",
                "5.00",
                "100",
                "40.0",
                "10.0",
                "3.00",
                "1.00",
                "228"
            ]
        );
        assert_eq!(tables[0].header.len(), cells.len());
    }

    #[test]
    fn the_fastest_rows_are_right_everywhere() {
        let rows: Rows<'_> = &[
            ("obvhs-cwbvh", &[2.0, 2.0]),
            ("hug", &[1.0, 1.0]),
            ("octree", &[4.0, 4.0]),
            ("kd-tree", &[3.0, 3.0]),
            ("uniform-grid", &[0.1, 0.1]),
        ];
        let mut record = run(&[("tetra", rows), ("balls", rows)]);
        record.scenes[1].rows[4].verdict = Verdict::Wrong;
        assert_eq!(fastest_rows(&record), ["hug", "obvhs-cwbvh", "kd-tree"]);
        // in a scene without the reference, ratios are to another row
        let rows = &mut record.scenes[1].rows;
        (rows[0].verdict, rows[0].is_reference) = (Verdict::NotBuilt, false);
        rows[1].is_reference = true;
        assert_eq!(fastest_rows(&record), ["hug", "kd-tree", "octree"]);
    }
}
