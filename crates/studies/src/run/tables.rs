//! The tables of a run, before any markup: text and Markdown differ only in how they draw them.

use crate::run::columns::{self, RATIO, RowOf};
use measurement::rays::order::Orders;
use measurement::record::query::{self, Query};
use measurement::record::{
    AnsweredRays, FloorRecord, RowRecord, RunRecord, SceneRecord, SummaryRow, Verdict, WorkRecord,
    label, reference,
};
use presentation::column::headed;
use presentation::numbers;
use presentation::table::{Cell, Style, Table, dash};

/// The columns of [`columns::columns`] that a scene's table has, in its order.
const HEADS: [&str; 19] = [
    "N_IN", "N_V", "N_EV", "N_OIV", "N_IT", "N_TS", "N_ETS", "N_EETS", "MiB", "rays", "build ms",
    "trace ms", "image ms", RATIO, "primary", "shadow", "second.", "diffuse", "verdict",
];

/// The block of a scene: structures down, counters and times across. Rows of a structure beyond
/// its first are named by their settings alone when `indent` is set. `shown_rows` are rows of the
/// scene in any order.
pub fn scene_table<'r>(
    run: &RunRecord,
    scene: &SceneRecord,
    shown_rows: impl IntoIterator<Item = &'r RowRecord> + Clone,
    indent: bool,
) -> Table {
    // rates are those of rays in the order of the image
    let has = |kind: &str| {
        run.settings.order != Orders::Shuffled.name() && run.settings.rays.iter().any(|k| k == kind)
    };
    let is_shown = |head: &&str| match *head {
        "primary" | "shadow" | "diffuse" => has(head),
        "second." => has("reflected") || has("refracted"),
        _ => true,
    };
    let columns = columns::columns();
    let shown = HEADS.iter().filter(|head| is_shown(head));
    let shown: Vec<_> = shown.filter_map(|head| headed(&columns, head)).collect();
    let has_batches = scene.rows.iter().any(|row| row.query == Query::Batch);
    let mut header = vec!["structure"];
    header.extend(has_batches.then_some("query"));
    header.extend(shown.iter().map(|column| column.head));
    let all_rays = scene.distinct_rays();
    let mut name = row_names(indent);
    let rows = shown_rows.clone().into_iter().map(|row| {
        let mut cells = vec![name(&row.structure, &row.settings)];
        cells.extend(has_batches.then(|| row.query.name().to_owned().into()));
        cells.extend(shown.iter().map(|column| column.cell(&RowOf { scene, row, all_rays })));
        cells
    });
    let mut rows: Vec<Vec<Cell>> = rows.collect();
    let ratios = shown_rows.into_iter().map(|row| {
        // a ratio over shadow rays alone is none to compare with the others
        let is_comparable = row.answers == AnsweredRays::AllRays && scene.may_lead(row);
        row.ratio.filter(|_| is_comparable)
    });
    mark_best(&mut rows, header.iter().position(|h| *h == RATIO), ratios);
    Table { title: scene_title(scene), header, rows, notes: scene_notes(run, scene) }
}

/// Names rows one after the other: one below another row of its structure by its settings, where
/// they may be indented.
pub fn row_names<'r>(indent: bool) -> impl FnMut(&'r str, &'r str) -> Cell {
    let mut previous = "";
    move |structure, settings| {
        let is_below = indent && structure == previous && !settings.is_empty();
        previous = structure;
        let name = if is_below { format!("  {settings}") } else { label(structure, settings) };
        name.into()
    }
}

/// Marks the smallest ratio of the column.
fn mark_best(
    rows: &mut [Vec<Cell>],
    column: Option<usize>,
    ratios: impl Iterator<Item = Option<statistics::estimate::Estimate>>,
) {
    let best = ratios
        .enumerate()
        .filter_map(|(i, ratio)| Some((i, ratio?.median)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some((row, _)), Some(column)) = (best, column)
        && let Some(cell) = rows.get_mut(row).and_then(|r| r.get_mut(column))
    {
        cell.style = Style::Best;
    }
}

pub fn scene_title(scene: &SceneRecord) -> String {
    let rays: Vec<String> = scene.rays.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
    format!("{}: {} primitives; rays: {}", scene.name, scene.primitives, rays.join(", "))
}

/// Notes on a scene's rows, and on how their answers were judged.
pub fn scene_notes(run: &RunRecord, scene: &SceneRecord) -> Vec<String> {
    let oracle = &scene.oracle;
    let mut notes = vec![match &oracle.reference {
        Some(reference) => format!(
            "Answers compared ray by ray, {reference} asked first. f64 brute force decided every ray on \
             which rows differ and a sample of {} rays, {} of them borderline.",
            oracle.checked, oracle.borderline
        ),
        None if scene.rays.is_empty() => format!("{}.", scene.source),
        None => {
            "f64 brute force refuted every structure that could be asked first; on its sample rows \
                 were compared with brute force."
                .into()
        }
    }];
    notes.extend(reference_note(run, scene));
    if scene.rows.iter().any(|row| row.query == Query::Batch) {
        notes.push(query::NOTE.into());
    }
    notes.extend(outlier_note(scene));
    notes.extend(scene.rows.iter().filter_map(levels_note));
    notes.extend(oracle.refused.iter().map(|r| format!("Not asked first: {r}")));
    for row in &scene.rows {
        let name = row.label();
        let saved = row.work.as_ref().and_then(WorkRecord::saved_part);
        let saved = saved
            .map(|part| format!("{name}: the mailbox saved {:.1}% of the tests", part * 100.0));
        notes.extend(saved);
        notes.extend(on_demand_note(row));
        notes.extend(shadow_note(row));
        notes.extend(plugin_note(row));
        let reasons = [&row.error, &row.example, &row.known_defect];
        match row.verdict {
            Verdict::Ok => {}
            v if !v.is_judged() => {
                let reason = row.error.as_deref().unwrap_or(row.verdict.name());
                // what refuses names itself
                let own = reason.strip_prefix(&row.structure).and_then(|r| r.strip_prefix(": "));
                notes.push(format!("{name}: {}", own.unwrap_or(reason)));
            }
            _ => {
                let said: Vec<&str> = reasons.iter().filter_map(|r| r.as_deref()).collect();
                notes.push(format!("{name}: {}", said.join("; ")));
            }
        }
    }
    notes
}

/// Names the row that replaced the run's reference.
fn reference_note(run: &RunRecord, scene: &SceneRecord) -> Option<String> {
    let planned = &run.settings.reference;
    let own = reference::of_scene(scene).filter(|own| own != planned)?;
    let row = scene.rows.iter().find(|row| row.label() == *planned)?;
    Some(format!("Ratios are to {own}, as {planned} is {} here.", row.verdict.name()))
}

/// Number of outlier rounds, and the rows with most of them.
fn outlier_note(scene: &SceneRecord) -> Option<String> {
    let count = |row: &RowRecord| [row.outliers.build, row.outliers.trace].map(|[a, b]| a + b);
    let rows = || scene.rows.iter().filter(|row| !row.samples.is_empty());
    let [builds, traces] =
        rows().map(count).fold([0, 0], |[a, b], [builds, traces]| [a + builds, b + traces]);
    let samples: usize = rows().map(|row| row.samples.len()).sum();
    let most = rows().max_by_key(|row| count(row).iter().sum::<u64>())?;
    (builds + traces > 0).then(|| {
        format!(
            "Outliers (Tukey), included in all figures: {builds} builds, {traces} traces of \
             {samples}; most of {}.",
            most.label()
        )
    })
}

/// The levels of a row whose processes disagree.
fn levels_note(row: &RowRecord) -> Option<String> {
    let levels = row.levels?;
    let [low, high] = if row.is_reference {
        [levels.low, levels.high].map(|s| format!("{} ms", numbers::milliseconds(s)))
    } else {
        [levels.low, levels.high].map(numbers::short)
    };
    Some(format!(
        "Two levels: {} takes {low} in some processes and {high} in others; its interval does \
         not show this.",
        row.label()
    ))
}

fn process_notes(run: &RunRecord) -> impl Iterator<Item = String> {
    let processes = run.settings.processes;
    let many = (processes > 1).then(|| {
        format!(
            "{processes} processes: figures are geometric means of their medians, intervals those of \
             Student over them."
        )
    });
    many.into_iter().chain(run.floor.as_ref().map(FloorRecord::in_words))
}

/// Rays of a batch, for what the border of a process costs.
const BATCH: f64 = 1e5;
/// Share of a single-threaded row's time that other threads may take without a note.
const SPINNING: f64 = 0.05;

/// Origin of a plugin row, the cost of its process, and how often its own test differs.
fn plugin_note(row: &RowRecord) -> Option<String> {
    let plugin = row.plugin.as_ref()?;
    let digest = plugin.sha256.get(..12).unwrap_or_default();
    let mut note =
        format!("{}: plugin {} {} ({digest}), ", row.label(), plugin.file, plugin.version);
    note += if plugin.own_process { "in a separate process" } else { "in this process" };
    if plugin.own_process {
        let calls = plugin.empty_call_s * 1e6;
        note += &format!("; an empty call takes {calls:.0} us, not included in times");
        let seconds = row.trace_s.map(|s| s.median * BATCH / row.rays.max(1) as f64);
        if let Some(seconds) = seconds.filter(|s| *s > 0.0) {
            let part = 100.0 * plugin.empty_call_s / seconds;
            note += &format!(": {part:.2}% of a batch of 10^5 rays");
        }
    }
    if plugin.other_threads > SPINNING {
        let part = 100.0 * plugin.other_threads;
        note += &format!(
            "; {part:.0}% of its time was used by threads beyond -j (included: do they spin?)"
        );
    }
    note += if plugin.own_test {
        "; its own triangle test"
    } else {
        "; rtbench's triangle test, compared bit by bit"
    };
    if plugin.own_test {
        let (edges, checked) = (plugin.edge_mismatches, row.checked_rays);
        note += &format!(": {edges} of {checked} answers differ at edges");
    }
    if let Some(remark) = &plugin.note {
        note += &format!("; {remark}");
    }
    Some(note)
}

/// Rays that the figures of an occluder cover.
fn shadow_note(row: &RowRecord) -> Option<String> {
    (row.answers == AnsweredRays::ShadowRays).then(|| {
        let label = row.label();
        format!("{label}: answers shadow rays only; its trace time and ratio are over these")
    })
}

/// Note on a lazily built structure: the share never built, and the time of the first image.
fn on_demand_note(row: &RowRecord) -> Option<String> {
    let pending = row.stats.as_ref()?.pending_cells?;
    let first = match row.first_image_s() {
        Some(s) => format!("; first image {} ms after the start", numbers::milliseconds(s)),
        None => String::new(),
    };
    Some(format!("{}: {pending} cells were never divided{first}", row.label()))
}

/// The means over all scenes; `shown_rows` are rows of the summary in any order.
pub fn summary_table<'r>(
    run: &RunRecord,
    shown_rows: impl IntoIterator<Item = &'r SummaryRow> + Clone,
    indent: bool,
) -> Table {
    let has_batches = run.summary.iter().any(|row| row.batch_scenes > 0);
    let mut header = vec!["structure"];
    header.extend(has_batches.then_some("query"));
    header.extend(["scenes", "trace ratio [95%]", "build ratio [95%]", "verdict"]);
    let mut name = row_names(indent);
    let rows = shown_rows.clone().into_iter().map(|row| {
        let mut cells = vec![name(&row.structure, &row.settings)];
        cells.extend(has_batches.then(|| Query::over_scenes(row.batch_scenes, row.scenes).into()));
        cells.push(row.scenes.to_string().into());
        cells.extend([row.ratio, row.build_ratio].map(|estimate| match estimate {
            _ if row.verdict == Verdict::Wrong => {
                Cell { text: row.verdict.name().into(), style: Style::Bad }
            }
            Some(e) => numbers::ratio(&e).into(),
            None => dash(),
        }));
        cells.push(summary_verdict(row));
        cells
    });
    let mut rows: Vec<Vec<Cell>> = rows.collect();
    let ratios = shown_rows.into_iter().map(|r| {
        let is_comparable = r.answers == AnsweredRays::AllRays && r.may_lead(&run.scenes);
        r.ratio.filter(|_| is_comparable)
    });
    mark_best(&mut rows, header.iter().position(|h| *h == "trace ratio [95%]"), ratios);
    let reference = reference::of_means(&run.scenes, &run.settings.reference);
    let scenes = reference::scenes_over(&run.scenes, &reference);
    let mut notes = vec![format!("Ratios to {reference}: geometric means over {scenes} scene(s).")];
    notes.extend(left_out(run));
    notes.extend(process_notes(run));
    if has_batches {
        notes.push(query::NOTE.into());
    }
    Table { title: "All scenes".into(), header, rows, notes }
}

/// Scenes that means leave out, as their ratios are to another row.
pub fn left_out(run: &RunRecord) -> Option<String> {
    let reference = reference::of_means(&run.scenes, &run.settings.reference);
    let others = reference::elsewhere(&run.scenes, &reference).map(reference::in_scene);
    let others: Vec<String> = others.collect();
    let listed = || {
        format!("Means leave out scenes whose ratios are to another row: {}.", others.join(", "))
    };
    (!others.is_empty()).then(listed)
}

fn summary_verdict(row: &SummaryRow) -> Cell {
    let text = match row.verdict {
        Verdict::Ok if row.answers == AnsweredRays::ShadowRays => {
            return "ok (shadow rays)".to_owned().into();
        }
        Verdict::Ok => return "ok".to_owned().into(),
        v if !v.is_judged() => format!("{} in {} scenes", v.name(), row.not_built_scenes),
        v => format!("{}: {} rays in {} scenes", v.name(), row.mismatches, row.wrong_scenes),
    };
    Cell { text, style: Style::Bad }
}

/// Column heads with one line that explains them.
const SYMBOLS: [(&[&str], &str); 4] = [
    (
        &["N_IN", "N_V", "N_EV", "N_OIV", "N_IT", "N_TS", "N_ETS", "N_EETS"],
        "N_IN hierarchical cells, N_V elementary cells, N_EV empty ones, N_OIV references in cells; \
         per ray: N_IT intersection tests, N_TS traversal steps, N_ETS elementary steps, N_EETS \
         steps into empty cells (Havran and Sixta 1999).",
    ),
    (
        &["build ms", "trace ms", "image ms"],
        "build, trace: medians over the rounds, one sample each per round; trace is the time for the \
         rays of the column beside it. image: the whole picture through the renderer, once.",
    ),
    (
        &[RATIO, "trace ratio [95%]"],
        "ratio: trace time divided by the reference's for the same rays in the same round, with its \
         95% bootstrap interval; below 1 is faster; = where the interval contains 1: no significant \
         difference.",
    ),
    (
        &["primary", "shadow", "second.", "diffuse"],
        "primary, shadow, second., diffuse: millions of rays per second of one kind (second.: \
         reflected and refracted).",
    ),
];

pub const GLOSSARY: &[&str] = &[SYMBOLS[0].1, SYMBOLS[1].1, SYMBOLS[2].1, SYMBOLS[3].1];

/// Explanations of the symbols in shown columns.
pub fn glossary_of<'h>(heads: &'h [&'h str]) -> impl Iterator<Item = &'static str> + 'h {
    let is_shown = |(of, _): &&(&[&str], &str)| of.iter().any(|head| heads.contains(head));
    SYMBOLS.iter().filter(is_shown).map(|(_, text)| *text)
}
