//! The ratios of each row over the runs, a line for each machine, and where they change.

use std::collections::BTreeMap;

use crate::comparison::differences::{Difference, differences};
use crate::history::visit::Visit;
use measurement::record::metrics::{DifferenceScope, METRICS, Reading};
use measurement::record::{Machine, RowRecord, SceneRecord, reference};
use statistics::change_points::{Sensitivity, change_points};
use statistics::estimate::Estimate;
use statistics::verdict;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// The trace time of all rays.
    Trace,
    Build,
    /// The trace time of a kind of rays, as records call it.
    Kind(&'static str),
}

impl Quantity {
    pub fn head(self) -> &'static str {
        match self {
            Self::Trace => "all rays",
            Self::Build => "build",
            Self::Kind(kind) => kind,
        }
    }

    pub fn in_words(self) -> String {
        match self {
            Self::Trace => "trace time of all rays".to_owned(),
            Self::Build => "build time".to_owned(),
            Self::Kind(kind) => match kind.split_once('-') {
                Some((kind, order)) => format!("trace time of {kind} rays, {order}"),
                None => format!("trace time of {kind} rays"),
            },
        }
    }
}

/// A machine and settings: figures of two of them never stand in one line.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineSetup {
    first: usize,
    pub words: String,
}

/// The figure of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Index of the run.
    pub visit: usize,
    /// Over the reference of that run.
    pub ratio: Estimate,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// The first point that is different.
    pub place: usize,
    /// The points from there to the next change over those before it back to the last one.
    pub times: Estimate,
}

/// The points of a row on a bench.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// By its place among [`History::benches`].
    pub bench: usize,
    /// The scene by its hash, and what ratios are over: another one of the same name has another
    /// line.
    identity: String,
    /// In the order of the runs.
    pub points: Vec<Point>,
    /// In the order of the runs.
    pub changes: Vec<Change>,
}

/// Key of a line: scene, structure, settings, quantity.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    pub scene: String,
    pub structure: String,
    pub quantity: Quantity,
    pub settings: String,
}

#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// The runs, in their order.
    pub visits: Vec<Visit>,
    pub benches: Vec<MachineSetup>,
    /// Index of the machine setup of each run.
    pub bench_of: Vec<usize>,
    pub lines: BTreeMap<Key, Vec<Line>>,
}

impl Line {
    /// The last point before a change, and the first one behind it.
    pub fn around(&self, change: &Change) -> Option<[Point; 2]> {
        let before = self.points.get(change.place.checked_sub(1)?)?;
        Some([*before, *self.points.get(change.place)?])
    }
}

impl History {
    pub fn new(visits: Vec<Visit>, sensitivity: &Sensitivity, seed: u64) -> Self {
        let (benches, bench_of) = benches(&visits);
        let mut history = Self { visits, benches, bench_of, lines: BTreeMap::new() };
        history.collect();
        for line in history.lines.values_mut().flatten() {
            line.changes = changes(&line.points, sensitivity, seed);
        }
        history
    }

    fn collect(&mut self) {
        let benches = self.visits.iter().zip(&self.bench_of).enumerate();
        for (visit, (run, bench)) in benches {
            for scene in &run.run.scenes {
                let identity = identity(scene);
                for row in scene.rows.iter().filter(|row| is_measured(row)) {
                    for (quantity, ratio) in figures(row) {
                        let key = Key {
                            scene: scene.name.clone(),
                            structure: row.structure.clone(),
                            quantity,
                            settings: row.settings.clone(),
                        };
                        let point = Point { visit, ratio };
                        let lines = self.lines.entry(key).or_default();
                        let is_own =
                            |line: &&mut Line| line.bench == *bench && line.identity == identity;
                        match lines.iter_mut().find(is_own) {
                            Some(line) => line.points.push(point),
                            None => lines.push(Line {
                                bench: *bench,
                                identity: identity.clone(),
                                points: vec![point],
                                changes: Vec::new(),
                            }),
                        }
                    }
                }
            }
        }
    }

    /// The commit's name of a run, short.
    pub fn id(&self, visit: usize) -> String {
        self.visits.get(visit).map_or(String::new(), Visit::id)
    }

    /// All changes, each with its key and line, in the order of the keys.
    pub fn changes(&self) -> impl Iterator<Item = (&Key, &Line, &Change)> {
        let lines = self.lines.iter().flat_map(|(key, lines)| lines.iter().map(move |l| (key, l)));
        lines.flat_map(|(key, line)| line.changes.iter().map(move |change| (key, line, change)))
    }
}

/// Identity of a scene: its name, its rays, and its reference.
fn identity(scene: &SceneRecord) -> String {
    let reference = reference::of_scene(scene).unwrap_or_default();
    format!("{} {:?} {reference}", scene.sha256, scene.rays)
}

/// Returns whether it has figures that mean something: it is right, and not what they are over.
fn is_measured(row: &RowRecord) -> bool {
    row.verdict.is_timed() && !row.is_reference
}

fn figures(row: &RowRecord) -> Vec<(Quantity, Estimate)> {
    let kinds = METRICS.iter().filter_map(|metric| {
        let Reading::RatioOf(kind) = metric.reading else { return None };
        Some((Quantity::Kind(kind), row.ratio_by_kind.get(kind).copied()))
    });
    let all = [(Quantity::Trace, row.ratio), (Quantity::Build, row.build_ratio)];
    let known =
        all.into_iter().chain(kinds).filter_map(|(quantity, ratio)| Some((quantity, ratio?)));
    known.filter(|(_, ratio)| ratio.median.is_finite() && ratio.median > 0.0).collect()
}

/// The benches of runs, and which each was made on: two runs share one where nothing is between
/// their ratios but the program. Scenes are looked at one by one.
fn benches(visits: &[Visit]) -> (Vec<MachineSetup>, Vec<usize>) {
    let parts =
        |d: &Difference| d.concerns != DifferenceScope::Nothing && !d.what.starts_with("scene ");
    let mut benches: Vec<MachineSetup> = Vec::new();
    let mut bench_of = Vec::new();
    for (place, visit) in visits.iter().enumerate() {
        let is_same = |bench: &MachineSetup| {
            let first = visits.get(bench.first);
            first.is_some_and(|first| !differences(&first.run, &visit.run).iter().any(parts))
        };
        let known = benches.iter().position(is_same).unwrap_or_else(|| {
            let mut words = in_words(visit);
            // two may read alike
            if let Some(first) = visits.first().filter(|_| place > 0) {
                let found = differences(&first.run, &visit.run);
                let found: Vec<String> = found.into_iter().filter(parts).map(|d| d.what).collect();
                words += &format!("; from the first machine it differs in {}", found.join(", "));
            }
            benches.push(MachineSetup { first: place, words });
            benches.len() - 1
        });
        bench_of.push(known);
    }
    (benches, bench_of)
}

fn in_words(visit: &Visit) -> String {
    let (Machine { cpu, threads, os, .. }, settings) = (&visit.run.machine, &visit.run.settings);
    let cpu = cpu.as_deref().unwrap_or("unknown processor");
    let [width, height] = settings.resolution;
    format!(
        "{cpu}, {threads} threads, {os}; {width} x {height} pixels, {}, {} thread(s) used, ratios to {}",
        settings.precision, settings.threads, settings.reference
    )
}

/// Change points of the logarithms of the ratios.
fn changes(points: &[Point], sensitivity: &Sensitivity, seed: u64) -> Vec<Change> {
    let logs: Vec<f64> = points.iter().map(|point| point.ratio.median.ln()).collect();
    let places = change_points(&logs, sensitivity, seed);
    let medians: Vec<f64> = points.iter().map(|point| point.ratio.median).collect();
    let ends: Vec<usize> =
        std::iter::once(0).chain(places.iter().copied()).chain([medians.len()]).collect();
    let change = |ends: &[usize]| {
        let [from, place, to] = *ends else { return None };
        let (before, after) = (medians.get(from..place)?, medians.get(place..to)?);
        let change = verdict::Change::of_series(&before.to_vec().into(), &after.to_vec().into())?;
        let times = change.ratio?;
        Some(Change { place, times })
    };
    ends.windows(3).filter_map(change).collect()
}
