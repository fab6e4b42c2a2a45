//! Comparisons as tables, for the terminal and in Markdown.

use std::fmt::Write as _;
use std::io::{self, Write};

use crate::comparison::entry::{ComparisonOutcome, Entry};
use crate::comparison::pairing::grouped;
use crate::comparison::{Comparison, SceneComparison, Side};
use measurement::record::label;
use presentation::csv::{estimate, number, written};
use presentation::json::FormatError;
use presentation::markdown::{escaped, push_table};
use presentation::numbers;
use presentation::table::{Cell, Style, Table};
use presentation::text::Screen;
use statistics::estimate::Estimate;
use statistics::verdict::Change;

const HEADER: [&str; 7] = ["structure", "metric", "old", "new", "ratio [95%]", "p", "outcome"];

/// Columns kept when not all fit.
const FIRST: [&str; 5] = ["metric", "ratio [95%]", "outcome", "new", "old"];

pub const GLOSSARY: &[&str] = &[
    "old, new: exact values, or medians over the rounds. ratio: new over old, of medians with the \
     95% interval of Bonett and Price (2020); below 1 is faster, or less. p: the probability of \
     rounds this unlike by chance (Mann and Whitney), corrected for the number of tests (Holm 1979).",
    "no difference: the whole interval lies within the equivalence margin (--margin, 5%). faster, slower: \
     it does not contain 1 (nor reach below the A/A floor, where there is one), and p is below 0.05. \
     inconclusive: all else; more rounds, or fewer rows (-f).",
    "p does not account for drift between two runs: measure again before relying on a \
     difference, or use `rtbench check --against`.",
    "All scenes: geometric means of the ratios, over the scenes that both runs have the row in. \
     The reference's own ratio is 1 by definition and not shown.",
];

pub fn write(out: &mut dyn Write, comparisons: &[Comparison], screen: Screen) -> io::Result<()> {
    for comparison in comparisons {
        let facts = facts(comparison);
        screen.write_notes(out, &facts.iter().map(String::as_str).collect::<Vec<_>>())?;
        writeln!(out)?;
        for table in tables(comparison, true) {
            screen.write_fitted(out, &table, &FIRST)?;
        }
    }
    screen.write_notes(out, GLOSSARY)
}

/// The same in Markdown.
pub fn to_markdown(comparisons: &[Comparison]) -> String {
    let mut text = "# rtbench comparison\n\n".to_owned();
    for comparison in comparisons {
        for fact in facts(comparison) {
            let _ = writeln!(text, "- {}", escaped(&fact));
        }
        text.push('\n');
        for table in tables(comparison, false) {
            push_table(&mut text, &table);
        }
    }
    for line in GLOSSARY {
        let _ = writeln!(text, "{line}\n");
    }
    text
}

/// Both sides, and what is to be kept in mind.
fn facts(comparison: &Comparison) -> Vec<String> {
    let side = |Side { letter, path, git_revision, cpu }: &Side| {
        let revision = git_revision.as_deref().unwrap_or("unknown");
        let cpu = cpu.as_deref().unwrap_or("unknown");
        format!("{letter}: {path} (rtbench at {revision:.12}, {cpu})")
    };
    let mut lines = vec![side(&comparison.old), side(&comparison.new)];
    lines.extend(comparison.notes.iter().cloned());
    let (equal, below) = (comparison.equal, comparison.below_threshold);
    if equal > 0 {
        lines.push(format!("equal exact figures: {equal}, not shown (use -m all)"));
    }
    if below > 0 {
        lines.push(format!("figures that did not change beyond the threshold: {below}, not shown"));
    }
    if comparison.scenes.iter().all(|s| s.is_empty()) {
        lines.push("nothing to show".into());
    }
    lines.extend(comparison.answers_changed.iter().map(|row| {
        format!("ANSWERS CHANGED: {row}: hits differ for the same rays, though each run found its own correct")
    }));
    lines
}

/// One table per scene, and that of the means.
fn tables(comparison: &Comparison, indent: bool) -> Vec<Table> {
    let sides = format!("{} / {}", comparison.new.letter, comparison.old.letter);
    let scenes = comparison.scenes.iter().filter(|scene| !scene.is_empty());
    let mut tables: Vec<_> = scenes.map(|scene| scene_table(scene, &sides, indent)).collect();
    if !comparison.means.is_empty() {
        tables.push(mean_table(comparison, &sides, indent));
    }
    tables
}

fn scene_table(scene: &SceneComparison, sides: &str, indent: bool) -> Table {
    let mut previous = String::new();
    let rows = scene.entries.iter().map(|entry| {
        let change = &entry.change;
        let label = entry.label();
        let is_again = indent && label == previous;
        previous.clone_from(&label);
        vec![
            if is_again { String::new() } else { label }.into(),
            metric(entry).into(),
            value(entry, change.old).into(),
            value(entry, change.new).into(),
            ratio(entry.outcome, change.ratio).into(),
            change.p.map_or_else(|| "-".to_owned(), probability).into(),
            outcome(entry.outcome, change.ratio),
        ]
    });
    Table {
        title: format!("{}: {sides}", scene.scene),
        header: HEADER.to_vec(),
        rows: rows.collect(),
        notes: left_out(scene),
    }
}

/// Rows that are not compared, by reason.
fn left_out(scene: &SceneComparison) -> Vec<String> {
    let by_reason = grouped(scene.left_out.iter().map(|out| (&*out.why, out.label())));
    by_reason.into_iter().map(|(why, rows)| format!("{why}: {}", rows.join(", "))).collect()
}

fn mean_table(comparison: &Comparison, sides: &str, indent: bool) -> Table {
    let mut previous = String::new();
    let rows = comparison.means.iter().map(|mean| {
        let label = label(&mean.structure, &mean.settings);
        let is_again = indent && label == previous;
        previous.clone_from(&label);
        vec![
            if is_again { String::new() } else { label }.into(),
            mean.metric.to_owned().into(),
            mean.scenes.to_string().into(),
            ratio(mean.outcome, mean.ratio).into(),
            mean.p.map_or_else(|| "-".to_owned(), probability).into(),
            outcome(mean.outcome, mean.ratio),
        ]
    });
    Table {
        title: format!("All scenes: {sides}"),
        header: vec!["structure", "metric", "scenes", "ratio [95%]", "p", "outcome"],
        rows: rows.collect(),
        notes: Vec::new(),
    }
}

/// The metric in the unit that it is shown in.
fn metric(entry: &Entry) -> String {
    match entry.unit {
        "" => entry.metric.to_owned(),
        "s" => format!("{} ms", entry.metric),
        unit => format!("{} {unit}", entry.metric),
    }
}

fn value(entry: &Entry, value: f64) -> String {
    match entry.unit {
        "s" => numbers::milliseconds(value),
        // counts are whole, rays have parts of them
        _ if !entry.is_measured() && value.fract() == 0.0 => format!("{value:.0}"),
        _ if !entry.is_measured() => format!("{value:.3}"),
        _ => numbers::short(value),
    }
}

fn ratio(outcome: ComparisonOutcome, ratio: Option<Estimate>) -> String {
    match ratio {
        None => "-".to_owned(),
        Some(ratio) if outcome.is_exact() => format!("{:.4}", ratio.median),
        Some(Estimate { median, low, high }) => format!("{median:.3} [{low:.3}, {high:.3}]"),
    }
}

fn probability(p: f64) -> String {
    if p < 0.001 { "<0.001".to_owned() } else { format!("{p:.3}") }
}

/// The outcome in words; of exact metrics with the change.
fn outcome(outcome: ComparisonOutcome, ratio: Option<Estimate>) -> Cell {
    let change = ratio.filter(|_| outcome.is_exact() && outcome.is_change());
    let change = change.map(|r| format!(" by {:.3}%", 100.0 * (r.median - 1.0).abs()));
    let style = match outcome {
        ComparisonOutcome::Slower | ComparisonOutcome::More => Style::Bad,
        ComparisonOutcome::Faster | ComparisonOutcome::Less => Style::Best,
        ComparisonOutcome::Equal | ComparisonOutcome::NoDifference => Style::Dim,
        ComparisonOutcome::Inconclusive | ComparisonOutcome::TooFewRounds => Style::Plain,
    };
    Cell { text: format!("{}{}", outcome.name(), change.unwrap_or_default()), style }
}

pub const COLUMNS: [&str; 14] = [
    "old_file",
    "new_file",
    "scene",
    "structure",
    "settings",
    "metric",
    "unit",
    "old",
    "new",
    "ratio",
    "ratio_low",
    "ratio_high",
    "p",
    "outcome",
];

/// One row per scene, row and metric; geometric means have no scene, and what was left out has no
/// metric.
pub fn to_csv(comparisons: &[Comparison]) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(COLUMNS)?;
        for comparison in comparisons {
            let files = [&*comparison.old.path, &*comparison.new.path];
            for scene in &comparison.scenes {
                for e in &scene.entries {
                    let Change { old, new, ratio, p, .. } = e.change;
                    let [old, new, p] = [Some(old), Some(new), p].map(number);
                    let [ratio, low, high] = estimate(ratio);
                    let row = [&*scene.scene, &*e.structure, &*e.settings, e.metric, e.unit];
                    let figures = [&*old, &*new, &*ratio, &*low, &*high, &*p, e.outcome.name()];
                    writer.write_record(files.iter().chain(&row).chain(&figures))?;
                }
                for out in &scene.left_out {
                    let row = [&*scene.scene, &*out.structure, &*out.settings];
                    let figures = ["", "", "", "", "", "", "", "", &*out.why];
                    writer.write_record(files.iter().chain(&row).chain(&figures))?;
                }
            }
            for mean in &comparison.means {
                let [ratio, low, high] = estimate(mean.ratio);
                let p = number(mean.p);
                let row = ["", &*mean.structure, &*mean.settings, mean.metric];
                let figures = ["", "", "", &*ratio, &*low, &*high, &*p, mean.outcome.name()];
                writer.write_record(files.iter().chain(&row).chain(&figures))?;
            }
        }
        Ok(())
    })
}
