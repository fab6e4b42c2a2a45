//! The tables of an axis.

use std::fmt::Write;

use crate::accuracy::columns::{columns, rows};
use crate::accuracy::record::{AccuracyRecord, AxisRecord, SceneOutcome};
use presentation::column;
use presentation::markdown::{escaped, push_table_with};
use presentation::table::Table;

/// The columns of [`columns`] that a table has, in its order.
const HEADS: [&str; 6] = ["variant", "time ms", "ratio [95%]", "error", "also", "stands"];

/// Explanations of the columns.
pub const GLOSSARY: &[&str] = &[
    "time: of the work named below the table, median over interleaved rounds; ratio: to the cheapest \
     variant in the same rounds, with its 95% interval (bootstrap; of several processes Student's), = where \
     it contains 1; (in parentheses): left out; not a variant, may take less time than the cheapest; error: by the axis' metric, where it is a rate in 10^6 with its count, and with the bound 3/trials where \
     nothing was wrong.",
    "front: no other variant is as accurate and as fast, and better in one of both; ~front: \
     beaten only by variants whose time is not significantly different; ref: the variant (or one of its answers) \
     that the others are compared with.",
];

/// The table of an axis on a scene.
pub fn table(axis: &AxisRecord, scene: &SceneOutcome) -> Table {
    let mut notes = vec![
        format!("Timed: {}. Judged: {}.", scene.timed, scene.judged),
        format!("Error: {}. Reference: {}.", axis.metric, axis.reference),
    ];
    if scene.reference_error > 0.0 {
        notes.push(format!("The reference's own error: {:.2e}.", scene.reference_error));
    }
    notes.extend(scene.faults.iter().map(|fault| format!("FAULT: {fault}.")));
    Table {
        title: format!("{}: {}", axis.axis, scene.place()),
        notes,
        ..column::table(&columns(), &HEADS, rows(axis, scene))
    }
}

/// All tables in Markdown, with where and how they were made.
pub fn to_markdown(run: &AccuracyRecord) -> String {
    let mut text = String::from("# What accuracy costs in time: all variants\n\n");
    push_facts(&mut text, run);
    for axis in &run.axes {
        for scene in &axis.scenes {
            push_table(&mut text, &table(axis, scene));
        }
    }
    for line in GLOSSARY {
        let _ = writeln!(text, "{line}\n");
    }
    text
}

/// Appends a table with its title and notes.
pub(super) fn push_table(text: &mut String, table: &Table) {
    push_table_with(text, table, |column| (1..=3).contains(&column));
}

/// Machine and settings of a run.
pub fn facts(run: &AccuracyRecord) -> [String; 5] {
    let unknown = || "unknown".to_owned();
    let AccuracyRecord { machine, compiler, tool, .. } = run;
    [
        format!("command: {}", run.command_line.join(" ")),
        format!(
            "machine: {}, {} threads, {}",
            machine.cpu.clone().unwrap_or_else(unknown),
            machine.threads,
            machine.os
        ),
        format!(
            "compiler: {}, opt-level {}",
            compiler.rustc.clone().unwrap_or_else(unknown),
            compiler.opt_level.clone().unwrap_or_else(unknown)
        ),
        format!(
            "rtbench {} at {}",
            tool.version,
            tool.git_revision.clone().unwrap_or_else(unknown)
        ),
        format!(
            "seed {}, {}{} rounds, one thread; {} in all",
            run.seed,
            if run.processes > 1 {
                format!("{} processes of ", run.processes)
            } else {
                String::new()
            },
            run.rounds,
            took(run.took_s)
        ),
    ]
}

/// Appends the facts as a list.
pub(super) fn push_facts(text: &mut String, run: &AccuracyRecord) {
    for fact in facts(run) {
        let _ = writeln!(text, "- {}", escaped(&fact));
    }
    text.push('\n');
}

/// A time in words.
pub fn took(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole / 60 {
        0 => format!("{whole} s"),
        minutes => format!("{minutes} min {} s", whole % 60),
    }
}
