//! A run on the terminal, in Markdown and CSV.

use std::fmt::{Display, Write as _};
use std::io::{self, Write};

use measurement::rays::order::Orders;
use measurement::record::query::{self, Query};
use measurement::record::{RunRecord, SceneRecord, Settings};
use measurement::settings::Lights;
use presentation::csv::written;
use presentation::json::FormatError;
use presentation::markdown::{code, escaped, push_table};
use presentation::table::{Style, Table};
use presentation::text::{painted, wrapped};

use crate::run::few::{self, Few};
use crate::run::lines::{self, Line, Lines};
use crate::run::tables::GLOSSARY;
use crate::run::time_to_image::TimesToImage;
use crate::run::view::View;
use crate::run::{columns, kind_tables, tables};

/// The whole run: where and how it was measured, one table per scene, the summary, the symbols.
pub fn to_markdown(run: &RunRecord) -> String {
    let by_kind = run.settings.by_kind;
    let mut all: Vec<Table> = Vec::new();
    for scene in &run.scenes {
        all.push(tables::scene_table(run, scene, &scene.rows, false));
        all.extend(by_kind.then(|| kind_tables::scene_table(run, scene, &scene.rows, false)));
        all.extend(columns::foreign_table(scene));
    }
    if !run.summary.is_empty() {
        all.push(tables::summary_table(run, &run.summary, false));
        all.extend(by_kind.then(|| kind_tables::summary_table(run, false)));
        all.extend(by_kind.then(|| kind_tables::picture_table(run)));
    }
    let all: Vec<Table> = all.into_iter().map(|table| few::table(run, table)).collect();
    let glossary = GLOSSARY.iter().map(|text| few::text(run, text));
    let glossary: Vec<String> =
        Few::of(run).map(Few::heading).into_iter().chain(glossary).collect();
    with_answers("rtbench results", run, &all, &glossary, &few::text(run, &answers(run)))
}

/// Conclusions of the run, one list per scene, that of all scenes first.
fn answers(run: &RunRecord) -> String {
    let mut text = String::new();
    let overall = lines::of_run(run).filter(|_| run.scenes.len() > 1);
    for Lines { title, lines } in overall.into_iter().chain(run.scenes.iter().map(lines::of_scene))
    {
        let _ = writeln!(text, "## {}\n", escaped(&title));
        for Line { head, text: answer } in lines {
            let _ = writeln!(text, "- {}: {}", escaped(&head), escaped(&answer));
        }
        text.push('\n');
    }
    if !text.is_empty() {
        let _ = writeln!(text, "{}\n", lines::NOTE);
    }
    text
}

/// Document with machine and settings of a run, tables, and a glossary.
pub fn document(title: &str, run: &RunRecord, tables: &[Table], glossary: &[&str]) -> String {
    with_answers(title, run, tables, glossary, "")
}

fn with_answers(
    title: &str,
    run: &RunRecord,
    tables: &[Table],
    glossary: &[impl Display],
    answers: &str,
) -> String {
    let mut text = format!("# {title}\n\n");
    if let Some(shard) = &run.shard {
        let _ =
            writeln!(text, "**Part {} of the run; `rtbench merge` joins them.**\n", shard.shard());
    }
    if !run.complete {
        let (finished, all) = (run.scenes.len(), run.planned.len());
        let _ = writeln!(text, "**Incomplete: {finished} of {all} scenes.**\n");
    }
    for line in facts(run) {
        let _ = writeln!(text, "- {line}");
    }
    for warning in &run.warnings {
        let _ = writeln!(text, "- warning: {}", escaped(&warning.to_string()));
    }
    for part in &run.parts {
        let (index, command) = (part.index, part.command_line.join(" "));
        let cpu = escaped(part.machine.cpu.as_deref().unwrap_or("unknown"));
        let (command, parts) = (code(&command), run.parts.len());
        let _ = writeln!(text, "- part {index} of {parts}: {command} on {cpu}");
    }
    text.push('\n');
    text += answers;
    for table in tables {
        push_table(&mut text, table);
    }
    for line in glossary {
        let _ = writeln!(text, "{line}\n");
    }
    text
}

fn facts(run: &RunRecord) -> Vec<String> {
    let (machine, compiler, settings) = (&run.machine, &run.compiler, &run.settings);
    let known = |text: &Option<String>| text.clone().unwrap_or_else(|| "unknown".to_owned());
    let mut clock = String::new();
    if let Some(governor) = &machine.governor {
        let _ = write!(clock, ", governor {governor}");
    }
    if let Some(boost) = machine.boost {
        let _ = write!(clock, ", boost {}", if boost { "on" } else { "off" });
    }
    if machine.batches_by_avx512 == Some(true) {
        clock.push_str(", wide nodes and batches by AVX-512");
    }
    if let Some(when) = &machine.huge_pages {
        let _ = write!(clock, ", huge pages: {when}");
    }
    let averages = run.load.map(|load| load.average);
    if let [Some(before), Some(after)] = averages {
        let _ = write!(clock, ", load average {before:.2} before, {after:.2} after");
    }
    let (cpu, mib) = (known(&machine.cpu), machine.memory_bytes.unwrap_or(0) >> 20);
    let (rustc, target) = (known(&compiler.rustc), known(&compiler.target));
    let (level, features) = (known(&compiler.opt_level), compiler.target_features.join(" "));
    let Settings { resolution: [w, h], max_depth, precision, threads, seed, .. } = settings;
    let mut facts = vec![
        format!("machine: {cpu}, {} threads, {mib} MiB, {}{clock}", machine.threads, machine.os),
        format!("compiler: {rustc}, {target}, opt-level {level}, features {features}"),
        format!("rtbench {} at {}", run.tool.version, known(&run.tool.git_revision)),
        format!("image {w}x{h}, depth {max_depth}, {precision}, {threads} thread(s), seed {seed}"),
    ];
    if settings.order != Orders::Scanline.name() || settings.lights != Lights::Each.name() {
        let Settings { order, lights, .. } = settings;
        facts.push(format!("rays in order: {order}; shadow rays to lights: {lights}"));
    }
    if !settings.view.is_empty() {
        facts.push(format!("view and lights of all scenes: {}", settings.view));
    }
    let command = format!("command: {}", code(&run.command_line.join(" ")));
    std::iter::once(command).chain(facts.iter().map(|fact| escaped(fact))).collect()
}

/// All finished scenes: [`columns::columns`], and behind them those of
/// [`kind_tables::csv_columns`].
pub fn to_csv(run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        let kinds = kind_tables::kinds(run);
        let more = kind_tables::csv_columns(&kinds);
        writer.write_record(columns::keys().map(str::to_owned).chain(more))?;
        for scene in &run.scenes {
            let times = TimesToImage::of(scene);
            for row in scene.rows.iter().chain(&scene.foreign) {
                let more = kind_tables::csv_fields(&kinds, row, &times);
                writer.write_record(columns::fields(scene, row).into_iter().chain(more))?;
            }
        }
        Ok(())
    })
}

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
    view.screen.write_table(out, &few::table(run, table))
}

/// A question a line, the answers below one another.
fn write_lines(out: &mut dyn Write, run: &RunRecord, lines: Lines, view: &View) -> io::Result<()> {
    let heads = lines.lines.iter().map(|line| line.head.chars().count());
    let indent = heads.max().unwrap_or(0) + 4;
    for part in wrapped(&lines.title, view.screen.width, 2) {
        writeln!(out, "{}", painted(&part, Style::Best, view.screen.colors))?;
    }
    for Line { head, text } in &lines.lines {
        let text = few::text(run, text);
        let text = format!("  {head:<width$}  {text}", width = indent - 4);
        view.screen.write_item(out, &text, indent)?;
    }
    Ok(())
}
