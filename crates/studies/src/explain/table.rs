//! An explanation as tables and CSV: the factors, and structure by kernel for each kind of ray; notes
//! below them on settings that a row lacks or a scene does not support, and rows without a time.

use std::collections::BTreeSet;
use std::io::{self, Write};

use measurement::record::query::Query;
use measurement::record::{RowRecord, RunRecord, SceneRecord, Verdict};
use presentation::csv::{estimate, written};
use presentation::json::FormatError;
use presentation::numbers;
use presentation::table::{Cell, Style, Table, dash};
use presentation::text::Screen;

use crate::explain::craft::{BLOCK, DIRECT, ONE_RAY, ROBUST, SCALAR, Variant};
use crate::explain::{Explain, Explanation, Rays};
use crate::run::kind_tables::kinds;
use crate::run::output;
use crate::run::tables::{scene_notes, scene_title};

/// Columns of crafts, by [`Variant::name`].
const COLUMNS: [&str; 6] =
    ["direct", "as shipped", "scalar", "block", "scalar, batch", "block, batch"];

/// The rays that a scene is explained for: kind by kind, and all.
pub fn rays_of<'k>(run: &RunRecord, scene: &SceneRecord) -> Vec<Rays<'k>> {
    let own = kinds(run).into_iter().filter(|kind| scene.rays.get(*kind).is_some_and(|n| *n > 0));
    own.map(Rays::Kind).chain([Rays::All]).collect()
}

pub fn write(
    out: &mut dyn Write,
    explain: &Explain<'_>,
    run: &RunRecord,
    scene: &SceneRecord,
    screen: Screen,
) -> io::Result<()> {
    let tables = tables(explain, run, scene);
    tables.iter().try_for_each(|table| screen.write_fitted(out, table, &["all"]))
}

pub fn to_markdown(explain: &Explain<'_>, run: &RunRecord) -> String {
    let tables: Vec<Table> =
        run.scenes.iter().flat_map(|scene| tables(explain, run, scene)).collect();
    output::document("rtbench explain", run, &tables, GLOSSARY)
}

/// The factors, and a table for each kind of ray.
pub fn tables(explain: &Explain<'_>, run: &RunRecord, scene: &SceneRecord) -> Vec<Table> {
    let explanation = Explanation::of(explain, run, scene);
    let rays = rays_of(run, scene);
    let mut tables = vec![factors(&explanation, &rays)];
    tables.extend(rays.iter().map(|rays| by_craft(&explanation, *rays)));
    if let Some(last) = tables.last_mut() {
        last.notes = notes(explain, &explanation);
    }
    tables
}

/// Structures down, crafts across.
fn by_craft(explanation: &Explanation<'_>, rays: Rays<'_>) -> Table {
    let known: Vec<(usize, &str, &'static str)> = explanation
        .variants
        .iter()
        .enumerate()
        .filter_map(|(i, variant)| variant.as_ref().map(|v| (i, &*v.structure, v.name())))
        .collect();
    let is_there = |name: &&str| known.iter().any(|(_, _, craft)| craft == name);
    let columns: Vec<&'static str> = COLUMNS.into_iter().filter(is_there).collect();
    let mut listed = BTreeSet::new();
    let structures = known.iter().map(|(_, structure, _)| *structure);
    let structures = structures.filter(|structure| listed.insert(*structure));
    let cell_of = |structure: &str, craft: &str| {
        let found = known.iter().find(|(_, own, name)| *own == structure && *name == craft);
        let row = found.and_then(|(i, ..)| Some((*i, explanation.scene.rows.get(*i)?)));
        row.map_or_else(dash, |(i, row)| cell(row, rays, i == 0))
    };
    let line = |structure: &str| {
        let mut cells: Vec<Cell> = vec![structure.to_owned().into()];
        cells.extend(columns.iter().map(|craft| cell_of(structure, craft)));
        cells
    };
    let reference = explanation.run.settings.reference.as_str();
    Table {
        title: format!("{} rays: time over that of {reference} [95%]", rays.name()),
        header: std::iter::once("structure").chain(columns.iter().copied()).collect(),
        rows: structures.map(line).collect(),
        notes: Vec::new(),
    }
}

fn cell(row: &RowRecord, rays: Rays<'_>, is_explained: bool) -> Cell {
    if !row.verdict.is_timed() {
        return Cell { text: row.verdict.name().into(), style: Style::Bad };
    }
    let style = if is_explained { Style::Best } else { Style::Plain };
    rays.ratio(row).map_or_else(dash, |ratio| Cell { text: numbers::ratio(&ratio), style })
}

/// Factors down, kinds of rays across, the whole below.
fn factors(explanation: &Explanation<'_>, rays: &[Rays<'_>]) -> Table {
    let number = |ratio| Option::map_or_else(ratio, dash, |r| numbers::ratio(&r).into());
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for factor in &explanation.factors {
        let mut cells: Vec<Cell> = vec![factor.name.clone().into()];
        cells.extend(rays.iter().map(|rays| number(explanation.factor(factor, *rays))));
        rows.push(cells);
    }
    let row = explanation.scene.rows.first().filter(|_| !rows.is_empty());
    if let Some(row) = row {
        let mut cells: Vec<Cell> = vec![format!("whole: {}", row.label()).into()];
        cells.extend(rays.iter().map(|rays| cell(row, *rays, true)));
        rows.push(cells);
    }
    let header = kinds(explanation.run).into_iter().filter(|kind| rays.contains(&Rays::Kind(kind)));
    Table {
        title: scene_title(explanation.scene),
        header: std::iter::once("factor").chain(header).chain(["all"]).collect(),
        rows,
        notes: Vec::new(),
    }
}

pub const GLOSSARY: &[&str] = &[
    "Ratios of times for the same rays in the same rounds, with their 95% intervals; below 1 is faster, = \
     where the interval contains 1. direct: a library as its authors use it; all others: our setup of rays \
     and the watertight test, one triangle at a time (scalar) or eight (block), rays one by one or those \
     of a batch together (batch).",
    "structure: another structure, all else equal. kernel, query: the same structure, queried \
     differently. adapter: the cost of right answers: padded boxes, robust setup of rays, our \
     test. A factor measured both before and after another one is the geometric mean of both.",
];

const CSV_COLUMNS: [&str; 10] = [
    "scene",
    "rays",
    "part",
    "name",
    "structure",
    "craft",
    "ratio",
    "ratio_low",
    "ratio_high",
    "verdict",
];

/// All finished scenes: of each kind of ray the rows, the factors and the whole.
pub fn to_csv(explain: &Explain<'_>, run: &RunRecord) -> Result<String, FormatError> {
    written(|writer| {
        writer.write_record(CSV_COLUMNS)?;
        for scene in &run.scenes {
            let explanation = Explanation::of(explain, run, scene);
            for rays in rays_of(run, scene) {
                let mut write = |words: [&str; 4], ratio, verdict: &str| {
                    let words = [scene.name.as_str(), rays.name()].into_iter().chain(words);
                    let [median, low, high] = estimate(ratio);
                    let numbers = [&*median, &*low, &*high, verdict];
                    writer.write_record(words.chain(numbers))
                };
                for (row, variant) in scene.rows.iter().zip(&explanation.variants) {
                    let Some(variant) = variant else { continue };
                    let words = ["row", &row.label(), &variant.structure, variant.name()];
                    write(words, rays.ratio(row), row.verdict.name())?;
                }
                for factor in &explanation.factors {
                    let ratio = explanation.factor(factor, rays);
                    write(["factor", &factor.name, "", ""], ratio, "")?;
                }
                let whole = scene.rows.first().filter(|_| !explanation.factors.is_empty());
                if let Some(row) = whole {
                    let words = ["whole", &row.label(), "", ""];
                    write(words, rays.ratio(row), row.verdict.name())?;
                }
            }
        }
        Ok(())
    })
}

fn notes(explain: &Explain<'_>, explanation: &Explanation<'_>) -> Vec<String> {
    let (run, scene) = (explanation.run, explanation.scene);
    let mut notes = Vec::new();
    let has_direct = explain.variants.iter().any(|variant| variant.adapter == DIRECT);
    if scene.only_triangles == Some(false) {
        notes.push(
            "The scene has primitives other than static triangles, which blocks do not support: \
             the only kernel here is scalar."
                .to_owned(),
        );
    }
    if has_direct && (scene.only_triangles == Some(false) || run.settings.precision != "f32") {
        notes.push(
            "obvhs's own triangles serve triangles at rest in f32 alone: here its traversal calls our \
             tests (as-shipped)."
                .to_owned(),
        );
    }
    let mut listed = BTreeSet::new();
    let structures = explain.variants.iter().map(|variant| &*variant.structure);
    let structures = structures.filter(|structure| listed.insert(*structure));
    let lacks = |structure: &str| lacks(structure, &explain.variants, scene.only_triangles);
    notes.extend(structures.filter_map(lacks));
    for factor in explanation.factors.iter().filter(|factor| factor.axes.len() > 1) {
        notes.push(format!("No row separates these factors: {}.", factor.name));
    }
    let ends = [0, explain.plan.baseline];
    for row in ends.into_iter().filter_map(|end| scene.rows.get(end)) {
        if !row.verdict.is_timed() {
            notes.push(format!("Nothing is explained: {} is {}.", row.label(), row.verdict.name()));
        }
    }
    let [row, reference] = ends.map(|end| explanation.variants.get(end));
    if row == reference {
        notes.push("Nothing is explained: in this scene both rows are the same.".to_owned());
    }
    for (row, nominal) in scene.rows.iter().zip(&explain.variants) {
        let is_alone = nominal.query != ONE_RAY && row.query == Query::OneRay;
        if row.verdict.is_timed() && is_alone {
            notes.push(format!("{}: its rays are traced one by one here.", row.label()));
        }
    }
    for row in &scene.rows {
        if row.verdict == Verdict::WrongAsShipped {
            let (wrong, asked, label) = (row.mismatches, row.checked_rays, row.label());
            notes.push(format!("{label}: {wrong} of {asked} answers are wrong (known defect)."));
        }
    }
    if let Some(stride) = scene.rows.iter().map(|row| row.stride).max().filter(|stride| *stride > 1)
    {
        notes.push(format!("All rows are timed on one ray in {stride}: one of them is slow."));
    }
    notes.extend(scene_notes(run, scene));
    notes
}

/// The settings that a structure has not; nothing where it has both.
fn lacks(structure: &str, variants: &[Variant], only_triangles: Option<bool>) -> Option<String> {
    let own = || variants.iter().filter(|v| v.structure == structure && v.adapter == ROBUST);
    let has = |kernel| own().any(|v| v.kernel == kernel);
    let is_mixed = only_triangles == Some(false);
    let mut lacking = Vec::new();
    match (has(SCALAR), has(BLOCK)) {
        (true, false) if structure.contains("mailbox=") => {
            lacking.push("no kernel=block (its mailbox needs the other)");
        }
        (true, false) if !is_mixed => lacking.push("no kernel=block"),
        (false, true) if !is_mixed => lacking.push("no kernel=scalar"),
        _ => {}
    }
    if own().all(|v| v.query == ONE_RAY) {
        lacking.push("no query=batch");
    }
    (!lacking.is_empty()).then(|| format!("{structure} has {}.", lacking.join(", ")))
}
