//! A run on the terminal.

use std::io::{self, Write};

use crate::run::few::{self, Few};
use crate::run::lines::{self, Line, Lines};
use crate::run::view::View;
use crate::run::{columns, kind_tables, tables};
use measurement::record::query::{self, Query};
use measurement::record::{RunRecord, SceneRecord};
use presentation::table::{Style, Table};
use presentation::text::{painted, wrapped};

/// Prints the block of a scene, and where there are several what it says of this one.
pub fn write_scene(
    out: &mut dyn Write,
    run: &RunRecord,
    scene: &SceneRecord,
    view: &View,
) -> io::Result<()> {
    let is_first = run.scenes.first().is_some_and(|first| first.name == scene.name);
    if let Some(few) = Few::of(run).filter(|_| is_first) {
        view.screen.write_notes(out, &[&few.heading()])?;
        writeln!(out)?;
    }
    write(out, run, scene_table(run, scene, view), view)?;
    if run.settings.by_kind {
        let rows = view.rows(&scene.rows);
        write(out, run, kind_tables::scene_table(run, scene, rows, view.indents()), view)?;
    }
    if run.planned.len() > 1 && !scene.rows.is_empty() {
        write_lines(out, run, lines::of_scene(scene), view)?;
        writeln!(out)?;
    }
    columns::foreign_table(scene).map_or(Ok(()), |table| write(out, run, table, view))
}

/// The table of a scene with what is shown of it; what is the same below all of them stands at the
/// end.
fn scene_table(run: &RunRecord, scene: &SceneRecord, view: &View) -> Table {
    let table = tables::scene_table(run, scene, view.rows(&scene.rows), view.indents());
    let mut table = view.shown(&table).0;
    table.notes.retain(|note| note != query::NOTE);
    table
}

/// Prints the means where there are several scenes, what the symbols mean, and the answers.
pub fn write_end(out: &mut dyn Write, run: &RunRecord, view: &View) -> io::Result<()> {
    let mut heads: Vec<&str> = Vec::new();
    let mut left_out: Vec<&str> = Vec::new();
    if let Some(scene) = run.scenes.first() {
        let (table, others) = view.shown(&tables::scene_table(run, scene, &scene.rows, false));
        heads.extend(table.header);
        left_out.extend(others);
    }
    if run.scenes.len() > 1 {
        let rows = view.summary(&run.summary);
        let mut table = view.shown(&tables::summary_table(run, rows, view.indents())).0;
        table.notes.retain(|note| note != query::NOTE);
        write(out, run, table, view)?;
    }
    if run.settings.by_kind {
        if run.scenes.len() > 1 {
            write(out, run, kind_tables::summary_table(run, view.indents()), view)?;
        }
        write(out, run, kind_tables::picture_table(run), view)?;
    }
    let mut notes: Vec<String> = Vec::new();
    let batch = run.scenes.iter().flat_map(|s| &s.rows).any(|row| row.query == Query::Batch);
    notes.extend(batch.then(|| query::NOTE.to_owned()));
    notes.extend(tables::glossary_of(&heads).map(|text| few::text(run, text)));
    if !left_out.is_empty() {
        notes.push(format!("Columns left out: {}; --columns chooses.", left_out.join(", ")));
    }
    let notes: Vec<&str> = notes.iter().map(String::as_str).collect();
    view.screen.write_notes(out, &notes)?;
    if let Some(lines) = lines::of_run(run) {
        writeln!(out)?;
        write_lines(out, run, lines, view)?;
        let note = few::text(run, lines::NOTE);
        view.screen.write_notes(out, &[&note])?;
    }
    Ok(())
}

fn write(out: &mut dyn Write, run: &RunRecord, table: Table, view: &View) -> io::Result<()> {
    let table = match Few::of(run) {
        Some(few) => few.table(table),
        None => table,
    };
    view.screen.write_table(out, &table)
}

/// A question a line, the answers below one another.
fn write_lines(out: &mut dyn Write, run: &RunRecord, lines: Lines, view: &View) -> io::Result<()> {
    let lines = match Few::of(run) {
        Some(few) => few.lines(lines),
        None => lines,
    };
    let heads = lines.lines.iter().map(|line| line.head.chars().count());
    let indent = heads.max().unwrap_or(0) + 4;
    for part in wrapped(&lines.title, view.screen.width, 2) {
        writeln!(out, "{}", painted(&part, Style::Best, view.screen.colors))?;
    }
    for Line { head, text } in &lines.lines {
        let text = format!("  {head:<width$}  {text}", width = indent - 4);
        view.screen.write_item(out, &text, indent)?;
    }
    Ok(())
}
