//! Two runs side by side: scene by scene, row by row, metric by metric.

pub mod differences;
pub mod entry;
pub mod pairing;
pub mod renamed;
pub mod tables;

use serde::Serialize;

pub use entry::{ComparisonSettings, NamedRun};

use crate::comparison::differences::{Difference, differences, notes, other_reference};
use crate::comparison::entry::{ComparisonOutcome, Entry, Mean, SIGNIFICANCE, means};
use crate::comparison::pairing::{Pairing, RowPair, ScenePair};
use measurement::record::metrics::DifferenceScope::{self, Everything, Ratios, Seconds};
use measurement::record::metrics::{METRICS, Metric};
use measurement::record::{RowRecord, RunRecord, Verdict, label};
use statistics::mann_whitney::{least_p, samples_needed};
use statistics::verdict::{Rule, correct};

#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    #[error("cannot be compared ({names}): {}; compare anyway with --force", reasons.join("; "))]
    Incomparable { names: String, reasons: Vec<String> },
    #[error(
        "{names}: no row in common: {old}, then {new}; use --match OLD=NEW if a row was renamed"
    )]
    NoCommonRow { names: String, old: String, new: String },
    #[error("{names}: no scene in common: {old}, then {new}")]
    NoCommonScene { names: String, old: String, new: String },
    #[error(
        "--match '{text}': {message}; expected OLD=NEW, rows of the first results and of the others: \
             'hug=hug density=4'"
    )]
    Match { text: String, message: String },
    #[error("--filter '{filter}': {message}")]
    Filter { filter: String, message: String },
    #[error(
        "--filter '{filter}' matches nothing among {among}, as SCENE/STRUCTURE SETTINGS/METRIC"
    )]
    NothingMatches { filter: String, among: String },
}

/// Metrics of a comparison where none are named; exact ones only where they differ.
pub fn default_metrics() -> Vec<&'static Metric> {
    let is_default = |m: &&Metric| m.is_exact() || ["build", "trace", "ratio"].contains(&m.name);
    METRICS.iter().filter(is_default).collect()
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Side {
    /// `A`, `B`, ...
    pub letter: String,
    pub path: String,
    pub git_revision: Option<String>,
    pub cpu: Option<String>,
}

/// A run compared with another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The run that the other is compared with.
    pub old: Side,
    pub new: Side,
    /// Notes that limit the figures: parts left out, forced or missing, with reasons.
    pub notes: Vec<String>,
    /// Rows whose answers to the same rays changed, with their scenes.
    pub answers_changed: Vec<String>,
    pub scenes: Vec<SceneComparison>,
    /// Over the scenes, geometric means.
    pub means: Vec<Mean>,
    /// Exact metrics that are equal and not shown.
    pub equal: u64,
    /// Number of rows below the threshold, which are not shown.
    pub below_threshold: u64,
}

/// A scene of both runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneComparison {
    pub scene: String,
    pub entries: Vec<Entry>,
    /// Rows, or parts of them, that cannot, and why.
    pub left_out: Vec<SkippedRow>,
}

/// A row that is not compared, or only in part, or with a caveat.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SkippedRow {
    pub structure: String,
    /// Settings that differ from the defaults.
    pub settings: String,
    pub why: String,
}

pub fn compare(
    old: NamedRun<'_>,
    new: NamedRun<'_>,
    choice: &ComparisonSettings,
) -> Result<Comparison, CompareError> {
    let names = || format!("{}: {}, {}: {}", old.letter, old.path, new.letter, new.path);
    let pairing = Pairing::of(old.run, new.run);
    let listed = |of: &dyn Fn(&RunRecord) -> Vec<String>| {
        [old, new].map(|named| match of(named.run) {
            none if none.is_empty() => "none".to_owned(),
            mut all => {
                all.dedup();
                all.join(", ")
            }
        })
    };
    if pairing.scenes.is_empty() {
        let [old, new] = listed(&|run| run.scenes.iter().map(|s| s.name.clone()).collect());
        return Err(CompareError::NoCommonScene { names: names(), old, new });
    }
    if pairing.rows().next().is_none() {
        let rows = |run: &RunRecord| -> Vec<String> {
            run.scenes.iter().flat_map(|s| &s.rows).map(RowRecord::label).collect()
        };
        let [old, new] = listed(&rows);
        return Err(CompareError::NoCommonRow { names: names(), old, new });
    }
    let differing = differences(old.run, new.run);
    let metrics = metrics(choice, &differing)
        .map_err(|reasons| CompareError::Incomparable { names: names(), reasons })?;
    let mut rows = ComparedRows {
        choice,
        metrics: &metrics,
        letters: [old.letter, new.letter],
        compared: Vec::new(),
        answers_changed: Vec::new(),
    };
    let mut comparison = Comparison {
        old: side(old),
        new: side(new),
        notes: notes(old, new, &pairing, choice, &differing),
        scenes: pairing.scenes.iter().map(|pair| rows.scene(pair)).collect(),
        answers_changed: rows.answers_changed,
        means: Vec::new(),
        equal: 0,
        below_threshold: 0,
    };
    let is_empty = comparison.scenes.iter().all(SceneComparison::is_empty);
    let rule = rule([old.run, new.run], choice.margin);
    comparison.decide(&rule, choice);
    comparison.means = means(&rows.compared, &metrics, choice, &rule);
    if let (true, Some(filter)) = (is_empty, &choice.filter) {
        let filter = filter.as_str().to_owned();
        return Err(CompareError::NothingMatches { filter, among: names() });
    }
    Ok(comparison)
}

/// Thresholds of changes: the larger A/A floor of both runs, if any.
fn rule(runs: [&RunRecord; 2], margin: f64) -> Rule {
    let floors = runs.into_iter().filter_map(|run| run.floor.as_ref());
    let noise = floors.map(|floor| floor.floor).fold(0.0, f64::max);
    Rule { margin, noise, significance: SIGNIFICANCE }
}

fn side(named: NamedRun<'_>) -> Side {
    Side {
        letter: named.letter.into(),
        path: named.path.into(),
        git_revision: named.run.tool.git_revision.clone(),
        cpu: named.run.machine.cpu.clone(),
    }
}

/// The metrics that can be compared, or every reason why none can.
fn metrics(
    choice: &ComparisonSettings,
    differing: &[Difference],
) -> Result<Vec<&'static Metric>, Vec<String>> {
    let reasons = |concerns: DifferenceScope| {
        let of = differing.iter().filter(move |d| d.concerns == concerns);
        of.map(|d| d.what.clone()).collect::<Vec<_>>()
    };
    if choice.is_forced {
        return Ok(choice.metrics.clone());
    }
    let is_left = |m: &&&Metric| !differing.iter().any(|d| m.is_concerned(d.concerns));
    let left: Vec<_> = choice.metrics.iter().filter(is_left).copied().collect();
    if reasons(Everything).is_empty() && !left.is_empty() {
        return Ok(left);
    }
    Err([Everything, Seconds, Ratios].into_iter().flat_map(reasons).collect())
}

/// What a comparison finds, scene by scene.
struct ComparedRows<'a, 'r> {
    choice: &'a ComparisonSettings,
    metrics: &'a [&'static Metric],
    letters: [&'a str; 2],
    /// The metrics of rows that can be compared.
    compared: Vec<(&'static Metric, RowPair<'r>)>,
    answers_changed: Vec<String>,
}

impl<'r> ComparedRows<'_, 'r> {
    /// Compares the rows of a scene, all their metrics.
    fn scene(&mut self, pair: &ScenePair<'r>) -> SceneComparison {
        let name = &pair.scenes[0].name;
        let mut out =
            SceneComparison { scene: name.clone(), entries: Vec::new(), left_out: Vec::new() };
        let (metrics, choice) = (self.metrics, self.choice);
        let finds_row =
            |row: &RowRecord| metrics.iter().any(|m| choice.finds(name, &row.label(), m.name));
        for pair in pair.rows.iter().filter(|pair| finds_row(pair.rows[1])) {
            let bad: Vec<String> = (pair.rows.iter().zip(self.letters))
                .filter(|(row, _)| !row.verdict.is_timed())
                .map(|(row, letter)| format!("{} in {letter}", row.verdict.name()))
                .collect();
            if bad.is_empty() {
                self.row(pair, &mut out);
            } else {
                out.leave_out(pair.rows[1], bad.join(", "));
            }
        }
        for (rows, letter) in pair.only.iter().zip(self.letters).rev() {
            for row in rows.iter().filter(|row| finds_row(row)) {
                out.leave_out(row, format!("only in {letter}"));
            }
        }
        out
    }

    /// Compares a row that both runs timed.
    fn row(&mut self, pair: &RowPair<'r>, out: &mut SceneComparison) {
        let RowPair { scenes, rows: [before, after] } = *pair;
        let (choice, name) = (self.choice, &scenes[0].name);
        if answers_changed([before, after]) {
            self.answers_changed.push(format!("{name}: {}", after.label()));
        }
        if before.verdict != after.verdict {
            let ([a, b], [in_a, in_b]) =
                ([before, after].map(|row| row.verdict.name()), self.letters);
            out.leave_out(after, format!("{a} in {in_a}, {b} in {in_b}, compared"));
        }
        let has_ratios = choice.is_forced || other_reference(scenes).is_none();
        let is_asked = |metric: &&&'static Metric| {
            (has_ratios || !metric.is_to_reference())
                && choice.finds(name, &after.label(), metric.name)
        };
        let mut other_rays = Vec::new();
        for metric in self.metrics.iter().filter(is_asked) {
            if metric.rays(before) != metric.rays(after) {
                other_rays.push(metric.name);
                if !choice.is_forced {
                    continue;
                }
            }
            // the reference is its own measure
            if metric.is_to_reference() && before.is_reference && after.is_reference {
                continue;
            }
            self.compared.push((metric, *pair));
            out.entries.extend(Entry::of(metric, pair));
        }
        if !other_rays.is_empty() {
            let names = other_rays.join(", ");
            let what = if choice.is_forced { "compared by --force" } else { "not compared" };
            out.leave_out(after, format!("{names} over other rays, {what}"));
        }
    }
}

impl Comparison {
    /// Corrects and decides what was measured; keeps what is shown, and counts the rest.
    fn decide(&mut self, rule: &Rule, choice: &ComparisonSettings) {
        let entries = || self.scenes.iter().flat_map(|scene| &scene.entries);
        let measured = entries().filter(|entry| entry.change.p.is_some());
        let (tests, samples) = (measured.clone().count(), measured.map(|e| e.change.samples).min());
        if let Some(n) = samples.filter(|n| least_p(*n, *n) * tests as f64 >= rule.significance) {
            let needed = samples_needed(tests, rule.significance);
            self.notes.push(format!(
                "{n} rounds cannot be significant among {tests} tests; {needed} can (run --rounds {needed}), or fewer rows \
                 (-f)"
            ));
        }
        correct(self.scenes.iter_mut().flat_map(|s| &mut s.entries).map(|entry| &mut entry.change));
        for scene in &mut self.scenes {
            scene.entries.iter_mut().for_each(|entry| entry.decide(rule));
            let (shown, hidden): (Vec<Entry>, Vec<Entry>) = std::mem::take(&mut scene.entries)
                .into_iter()
                .partition(|entry| choice.shows(entry.change.ratio, entry.outcome));
            let is_equal =
                |entry: &&Entry| entry.outcome == ComparisonOutcome::Equal && !choice.shows_equal;
            let equal = hidden.iter().filter(is_equal).count();
            self.equal += equal as u64;
            self.below_threshold += (hidden.len() - equal) as u64;
            scene.entries = shown;
        }
    }
}

impl SceneComparison {
    /// There is nothing to say of it.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty() && self.left_out.is_empty()
    }

    fn leave_out(&mut self, row: &RowRecord, why: String) {
        let (structure, settings) = (row.structure.clone(), row.settings.clone());
        self.left_out.push(SkippedRow { structure, settings, why });
    }
}

impl SkippedRow {
    pub fn label(&self) -> String {
        label(&self.structure, &self.settings)
    }
}

/// Both runs found the row's answers right, over as many rays of the same scene; but they are not
/// the same.
fn answers_changed([old, new]: [&RowRecord; 2]) -> bool {
    let is_judged = |row: &RowRecord| row.verdict == Verdict::Ok;
    is_judged(old)
        && is_judged(new)
        && old.checked_rays == new.checked_rays
        && matches!((&old.answers_sha256, &new.answers_sha256), (Some(a), Some(b)) if a != b)
}

#[cfg(test)]
mod tests;
