//! What is to be kept in mind with a comparison.

use crate::comparison::choice::{Choice, Named};
use crate::comparison::differences::{Difference, other_reference, scenes_of_both};
use measurement::record::metrics::Concerns;

/// What is to be said of two runs that are compared all the same.
pub fn notes(
    old: Named<'_>,
    new: Named<'_>,
    choice: &Choice,
    differing: &[Difference],
) -> Vec<String> {
    let mut said = Vec::new();
    for Difference { what, concerns } in differing {
        let consequence = match (concerns, choice.is_forced) {
            (Concerns::Nothing, _) => "",
            (_, true) => "; compared by --force",
            (Concerns::Seconds, _) => {
                "; times in seconds are not compared (--force does), ratios and counters are"
            }
            (Concerns::Ratios, _) => "; ratios to the reference are not compared (--force does)",
            (Concerns::Everything, false) => "",
        };
        said.push(format!("{what}{consequence}"));
    }
    for (before, after) in scenes_of_both(old.run, new.run) {
        let Some([a, b]) = other_reference([before, after]) else { continue };
        let what = if choice.is_forced { "compared by --force" } else { "not compared" };
        let (in_a, in_b, scene) = (old.letter, new.letter, &before.name);
        said.push(format!("scene {scene}: ratios to {a} in {in_a}, to {b} in {in_b}, {what}"));
    }
    for Named { letter, run, .. } in [old, new] {
        if !run.complete || run.scenes.len() < run.planned.len() {
            let (finished, all) = (run.scenes.len(), run.planned.len());
            said.push(format!("{letter} is incomplete: {finished} of {all} scenes"));
        }
        if run.settings.quick {
            said.push(format!("{letter} is a quick run: few rounds, a first look"));
        }
        said.extend(run.warnings.iter().map(|warning| format!("{letter}: {warning}")));
    }
    for (one, other) in [(old, new), (new, old)] {
        let has = |name: &str| other.run.scenes.iter().any(|s| s.name == name);
        let only: Vec<&str> =
            one.run.scenes.iter().map(|s| s.name.as_str()).filter(|name| !has(name)).collect();
        if !only.is_empty() {
            said.push(format!("only in {}: {}", one.letter, only.join(", ")));
        }
    }
    said
}
