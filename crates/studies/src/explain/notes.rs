//! Notes below the tables of an explanation: settings that a row lacks or a scene does not support,
//! rows without a time.

use crate::explain::craft::{Adapter, CodeDifferences, Kernel, QueryMode, Variant};
use crate::explain::{Explain, Explanation};
use crate::run::tables::scene_notes;
use measurement::record::Verdict;
use measurement::record::query::Query;

pub fn of(explain: &Explain<'_>, explanation: &Explanation<'_>) -> Vec<String> {
    let (run, scene) = (explanation.run, explanation.scene);
    let mut notes = Vec::new();
    let has = |is: fn(&CodeDifferences) -> bool| explain.variants.iter().any(|v| is(&v.craft));
    let has_direct = has(|craft| craft.adapter == Adapter::Direct);
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
    let mut structures: Vec<&str> = Vec::new();
    for variant in &explain.variants {
        if !structures.contains(&&*variant.structure) {
            structures.push(&variant.structure);
            notes.push(lacks(&variant.structure, &explain.variants, scene.only_triangles));
        }
    }
    notes.retain(|note| !note.is_empty());
    for factor in explanation.factors.iter().filter(|factor| factor.step.axes.len() > 1) {
        notes.push(format!("No row separates these factors: {}.", factor.name));
    }
    let ends = [explain.row, explain.plan.baseline];
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
        let is_alone = nominal.craft.query != QueryMode::OneRay && row.query == Query::OneRay;
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
fn lacks(structure: &str, variants: &[Variant], only_triangles: Option<bool>) -> String {
    let own = || {
        variants.iter().filter(|v| v.structure == structure && v.craft.adapter == Adapter::Robust)
    };
    let has = |kernel| own().any(|v| v.craft.kernel == kernel);
    let is_mixed = only_triangles == Some(false);
    let mut lacking = Vec::new();
    match (has(Kernel::Scalar), has(Kernel::Block)) {
        (true, false) if structure.contains("mailbox=") => {
            lacking.push("no kernel=block (its mailbox needs the other)");
        }
        (true, false) if !is_mixed => lacking.push("no kernel=block"),
        (false, true) if !is_mixed => lacking.push("no kernel=scalar"),
        _ => {}
    }
    if own().all(|v| v.craft.query == QueryMode::OneRay) {
        lacking.push("no query=batch");
    }
    if lacking.is_empty() {
        return String::new();
    }
    format!("{structure} has {}.", lacking.join(", "))
}
