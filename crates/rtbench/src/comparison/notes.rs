//! Caveats of a comparison.

use crate::comparison::choice::{ComparisonSettings, NamedRun};
use crate::comparison::differences::{Difference, other_reference};
use crate::comparison::pairing::Pairing;
use measurement::record::metrics::DifferenceScope;

/// Caveats of comparing two runs.
pub fn notes(
    old: NamedRun<'_>,
    new: NamedRun<'_>,
    pairing: &Pairing<'_>,
    choice: &ComparisonSettings,
    differing: &[Difference],
) -> Vec<String> {
    let mut said = Vec::new();
    for Difference { what, concerns } in differing {
        let consequence = match (concerns, choice.is_forced) {
            (DifferenceScope::Nothing, _) => "",
            (_, true) => "; compared by --force",
            (DifferenceScope::Seconds, _) => {
                "; times in seconds are not compared (except with --force), ratios and counters are"
            }
            (DifferenceScope::Ratios, _) => {
                "; ratios to the reference are not compared (except with --force)"
            }
            (DifferenceScope::Everything, false) => "",
        };
        said.push(format!("{what}{consequence}"));
    }
    for scenes in pairing.scenes.iter().map(|pair| pair.scenes) {
        let Some([a, b]) = other_reference(scenes) else { continue };
        let what = if choice.is_forced { "compared by --force" } else { "not compared" };
        let (in_a, in_b, scene) = (old.letter, new.letter, &scenes[0].name);
        said.push(format!("scene {scene}: ratios to {a} in {in_a}, to {b} in {in_b}, {what}"));
    }
    for NamedRun { letter, run, .. } in [old, new] {
        if !run.complete || run.scenes.len() < run.planned.len() {
            let (finished, all) = (run.scenes.len(), run.planned.len());
            said.push(format!("{letter} is incomplete: {finished} of {all} scenes"));
        }
        if run.settings.quick {
            said.push(format!("{letter} is a quick run: few rounds, a first look"));
        }
        said.extend(run.warnings.iter().map(|warning| format!("{letter}: {warning}")));
    }
    for (named, scenes) in [old, new].into_iter().zip(&pairing.only) {
        if !scenes.is_empty() {
            let names: Vec<&str> = scenes.iter().map(|s| s.name.as_str()).collect();
            said.push(format!("only in {}: {}", named.letter, names.join(", ")));
        }
    }
    said
}
