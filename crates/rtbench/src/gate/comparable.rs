//! May two records be compared at all?

use crate::record::RunRecord;

/// What keeps `now` from being compared with `base`, each in words: another target, other
/// settings, other scenes or rays. Empty where nothing does. Of `base`, scenes that `now` lacks do
/// not matter.
pub fn refusals(base: &RunRecord, now: &RunRecord) -> Vec<String> {
    let mut reasons = Vec::new();
    let mut differs = |what: &str, was: String, is: String| {
        if was != is {
            reasons.push(format!("{what}: was {was}, is {is}"));
        }
    };
    let (old, new) = (&base.settings, &now.settings);
    differs("threads", old.threads.to_string(), new.threads.to_string());
    differs("precision", old.precision.clone(), new.precision.clone());
    differs("resolution", format!("{:?}", old.resolution), format!("{:?}", new.resolution));
    differs("depth", old.max_depth.to_string(), new.max_depth.to_string());
    differs("rays", old.rays.join(" "), new.rays.join(" "));
    differs("seed", old.seed.to_string(), new.seed.to_string());
    differs("reference", old.reference.clone(), new.reference.clone());
    let (old, new) = (&base.compiler, &now.compiler);
    let known = |x: &Option<String>| x.clone().unwrap_or_else(|| "unknown".into());
    differs("target", known(&old.target), known(&new.target));
    differs("target features", old.target_features.join(" "), new.target_features.join(" "));
    differs("profile", known(&old.profile), known(&new.profile));
    differs("opt-level", known(&old.opt_level), known(&new.opt_level));
    for scene in &now.scenes {
        let Some(before) = base.scenes.iter().find(|s| s.name == scene.name) else {
            differs("scenes", format!("without {}", scene.name), format!("with {}", scene.name));
            continue;
        };
        let what = format!("sha256 of {}", scene.name);
        differs(&what, before.sha256.clone(), scene.sha256.clone());
        let what = format!("rays of {}", scene.name);
        differs(&what, format!("{:?}", before.rays), format!("{:?}", scene.rays));
    }
    reasons
}

/// What is worth a word, and no reason not to compare.
pub fn remarks(base: &RunRecord, now: &RunRecord) -> Vec<String> {
    let mut remarks = Vec::new();
    if base.machine != now.machine {
        let cpu = |m: &crate::record::Machine| m.cpu.clone().unwrap_or_else(|| "unknown".into());
        remarks.push(format!(
            "Another machine than the baseline's ({}; was {}): counters and instruction counts are \
             judged as on the same, times only as ratios to {} within each run.",
            cpu(&now.machine),
            cpu(&base.machine),
            now.settings.reference
        ));
    }
    if base.compiler.rustc != now.compiler.rustc {
        let of = |r: &RunRecord| r.compiler.rustc.clone().unwrap_or_else(|| "unknown".into());
        remarks.push(format!(
            "Another compiler than the baseline's ({}; was {}): it may change instruction counts.",
            of(now),
            of(base)
        ));
    }
    remarks
}
