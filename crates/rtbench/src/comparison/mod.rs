//! Two runs side by side: scene by scene, row by row, metric by metric.

pub mod choice;
pub mod csv;
pub mod differences;
pub mod entry;
pub mod means;
pub mod notes;
pub mod renamed;
pub mod tables;

use serde::Serialize;

pub use choice::{Choice, Named, Pair};

use crate::comparison::differences::{Difference, differences, other_reference, scenes_of_both};
use crate::comparison::entry::{Entry, Outcome};
use crate::comparison::means::{Mean, means};
use crate::comparison::notes::notes;
use measurement::record::metrics::Concerns;
use measurement::record::metrics::{METRICS, Metric};
use measurement::record::{RowRecord, RunRecord, SceneRecord, Verdict, label};

/// Why runs are not compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// They answer other questions.
    #[error("cannot be compared ({names}): {}; --force compares them all the same", reasons.join("; "))]
    Incomparable {
        /// Both runs.
        names: String,
        /// Every reason, with what was and what is.
        reasons: Vec<String>,
    },
    /// They have no scene in common.
    #[error("{names}: no scene in common: {old}, then {new}")]
    NoCommonScene {
        /// Both runs.
        names: String,
        /// Scenes of the first.
        old: String,
        /// Scenes of the second.
        new: String,
    },
    /// A row that is to be matched with another is not there, or may be read in two ways.
    #[error(
        "--match '{text}': {message}; expected OLD=NEW, rows of the first results and of the others: \
             'hug=hug density=4'"
    )]
    Match {
        /// As typed.
        text: String,
        /// What is wrong with it.
        message: String,
    },
    /// The filter is no regular expression.
    #[error("--filter '{filter}': {message}")]
    Filter {
        /// As typed.
        filter: String,
        /// What is wrong with it.
        message: String,
    },
    /// The filter finds nothing.
    #[error("--filter '{filter}' finds nothing among {among}, as SCENE/STRUCTURE SETTINGS/METRIC")]
    NothingMatches {
        /// As typed.
        filter: String,
        /// Both runs.
        among: String,
    },
}

/// Metrics of a comparison where none are named; exact ones only where they differ.
pub fn default_metrics() -> Vec<&'static Metric> {
    let is_default = |m: &&Metric| m.is_exact() || ["build", "trace", "ratio"].contains(&m.name);
    METRICS.iter().filter(is_default).collect()
}

/// What is known of one side.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Side {
    /// `A`, `B`, ...
    pub letter: String,
    /// Where it was read from.
    pub path: String,
    /// Commit of the program.
    pub git_revision: Option<String>,
    /// Processor.
    pub cpu: Option<String>,
}

/// A run held against another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The run that the other is held against.
    pub old: Side,
    /// The other.
    pub new: Side,
    /// What makes the figures less than they seem: what is left out or forced, and why; what is
    /// not there.
    pub notes: Vec<String>,
    /// Rows whose answers to the same rays changed, with their scenes.
    pub answers_changed: Vec<String>,
    /// By scene.
    pub scenes: Vec<SceneComparison>,
    /// Over the scenes, geometric means.
    pub means: Vec<Mean>,
    /// Exact metrics that are equal and not shown.
    pub equal: u64,
    /// What did not change by the threshold and is not shown.
    pub below_threshold: u64,
}

/// A scene of both runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneComparison {
    /// Name.
    pub scene: String,
    /// What can be compared.
    pub entries: Vec<Entry>,
    /// Rows, or parts of them, that cannot, and why.
    pub left_out: Vec<LeftOut>,
}

/// A row that is not compared, or not in all its metrics, or not without a word.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Structure.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// Why.
    pub why: String,
}

/// Compares a run with another.
///
/// # Errors
/// [`CompareError`].
pub fn compare(
    old: Named<'_>,
    new: Named<'_>,
    choice: &Choice,
) -> Result<Comparison, CompareError> {
    let names = || format!("{}: {}, {}: {}", old.letter, old.path, new.letter, new.path);
    if scenes_of_both(old.run, new.run).next().is_none() {
        let scenes = |run: &RunRecord| {
            let names: Vec<&str> = run.scenes.iter().map(|s| s.name.as_str()).collect();
            if names.is_empty() { "none".to_owned() } else { names.join(", ") }
        };
        let (old, new) = (scenes(old.run), scenes(new.run));
        return Err(CompareError::NoCommonScene { names: names(), old, new });
    }
    let differing = differences(old.run, new.run);
    let metrics = metrics(choice, &differing)
        .map_err(|reasons| CompareError::Incomparable { names: names(), reasons })?;
    let mut comparison = Comparison {
        old: side(old),
        new: side(new),
        notes: notes(old, new, choice, &differing),
        answers_changed: Vec::new(),
        scenes: Vec::new(),
        means: Vec::new(),
        equal: 0,
        below_threshold: 0,
    };
    let mut pairs = Vec::new();
    for scenes in scenes_of_both(old.run, new.run) {
        comparison.add_scene(scenes.into(), &metrics, choice, [old.letter, new.letter], &mut pairs);
    }
    comparison.means = means(&pairs, &metrics, choice);
    let is_empty = comparison.scenes.iter().all(SceneComparison::is_empty);
    if let (true, 0, 0, Some(filter)) =
        (is_empty, comparison.equal, comparison.below_threshold, &choice.filter)
    {
        let filter = filter.as_str().to_owned();
        return Err(CompareError::NothingMatches { filter, among: names() });
    }
    Ok(comparison)
}

fn side(named: Named<'_>) -> Side {
    Side {
        letter: named.letter.into(),
        path: named.path.into(),
        git_revision: named.run.tool.git_revision.clone(),
        cpu: named.run.machine.cpu.clone(),
    }
}

/// The metrics that can be compared, or every reason why none can.
fn metrics(choice: &Choice, differing: &[Difference]) -> Result<Vec<&'static Metric>, Vec<String>> {
    let reasons = |concerns: Concerns| {
        let of = differing.iter().filter(move |d| d.concerns == concerns);
        of.map(|d| d.what.clone()).collect::<Vec<_>>()
    };
    if choice.is_forced {
        return Ok(choice.metrics.clone());
    }
    let all = reasons(Concerns::Everything);
    let left: Vec<_> = choice
        .metrics
        .iter()
        .filter(|m| !differing.iter().any(|d| m.is_concerned(d.concerns)))
        .copied()
        .collect();
    match all.is_empty() && !left.is_empty() {
        true => Ok(left),
        false => Err([Concerns::Everything, Concerns::Seconds, Concerns::Ratios]
            .into_iter()
            .flat_map(reasons)
            .collect()),
    }
}

impl Comparison {
    /// Compares the rows of a scene; those that can be compared are appended to `pairs`.
    fn add_scene<'r>(
        &mut self,
        scenes: [&'r SceneRecord; 2],
        metrics: &[&'static Metric],
        choice: &Choice,
        letters: [&str; 2],
        pairs: &mut Vec<Pair<'r>>,
    ) {
        let [old, new] = scenes;
        let name = &old.name;
        let mut out =
            SceneComparison { scene: name.clone(), entries: Vec::new(), left_out: Vec::new() };
        let other = |rows: &'r [RowRecord], row: &RowRecord| {
            rows.iter().find(|r| r.structure == row.structure && r.settings == row.settings)
        };
        let has_ratios = choice.is_forced || other_reference(scenes).is_none();
        let gone = old.rows.iter().filter(|row| other(&new.rows, row).is_none());
        let finds_row =
            |row: &RowRecord| metrics.iter().any(|m| choice.finds(name, &row.label(), m.name));
        for row in new.rows.iter().chain(gone).filter(|row| finds_row(row)) {
            let (before, after) = match (other(&old.rows, row), other(&new.rows, row)) {
                (Some(before), Some(after)) => (before, after),
                (before, _) => {
                    let letter = if before.is_some() { letters[0] } else { letters[1] };
                    out.leave_out(row, format!("only in {letter}"));
                    continue;
                }
            };
            let bad: Vec<String> = [(before, letters[0]), (after, letters[1])]
                .iter()
                .filter(|(r, _)| !r.verdict.is_timed())
                .map(|(r, letter)| format!("{} in {letter}", r.verdict.name()))
                .collect();
            if !bad.is_empty() {
                out.leave_out(row, bad.join(", "));
                continue;
            }
            if answers_changed([before, after]) {
                self.answers_changed.push(format!("{name}: {}", row.label()));
            }
            if before.verdict != after.verdict {
                let [a, b] = [before, after].map(|row| row.verdict.name());
                let why = format!("{a} in {}, {b} in {}, compared", letters[0], letters[1]);
                out.leave_out(row, why);
            }
            let mut other_rays = Vec::new();
            let mut is_paired = false;
            let is_asked = |metric: &&&'static Metric| {
                (has_ratios || !metric.is_to_reference())
                    && choice.finds(name, &row.label(), metric.name)
            };
            for metric in metrics.iter().filter(is_asked) {
                let rays = [before, after].map(|row| metric.rays(row));
                if rays[0] != rays[1] {
                    other_rays.push(metric.name);
                    if !choice.is_forced {
                        continue;
                    }
                }
                // the reference is its own measure
                if metric.is_to_reference() && before.is_reference && after.is_reference {
                    continue;
                }
                is_paired = true;
                if let Some(entry) = Entry::of(metric, scenes, [before, after], choice.margin) {
                    self.show(entry, choice, &mut out.entries);
                }
            }
            if !other_rays.is_empty() {
                let names = other_rays.join(", ");
                let what = if choice.is_forced { "compared by --force" } else { "not compared" };
                out.leave_out(row, format!("{names} over other rays, {what}"));
            }
            if is_paired {
                pairs.push((scenes, [before, after]));
            }
        }
        self.scenes.push(out);
    }

    /// Shows an entry, or counts it.
    fn show(&mut self, entry: Entry, choice: &Choice, shown: &mut Vec<Entry>) {
        if entry.outcome == Outcome::Equal && !choice.shows_equal {
            self.equal += 1;
        } else if choice.threshold.is_some_and(|percent| !entry.changed_by_more(percent)) {
            self.below_threshold += 1;
        } else {
            shown.push(entry);
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
        self.left_out.push(LeftOut { structure, settings, why });
    }
}

impl LeftOut {
    /// Structure and settings.
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
