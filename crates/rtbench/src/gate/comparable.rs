//! May two records be compared at all?

use crate::comparison::differences::{Difference, differences};
use measurement::record::RunRecord;
use measurement::record::metrics::Concerns;
use measurement::record::reference;

/// What keeps `now` from being held against `base`, each in words: all that keeps two runs from being
/// compared, but for seconds, which no stage looks at. Of `base`, scenes that `now` lacks do not
/// matter.
pub fn refusals(base: &RunRecord, now: &RunRecord) -> Vec<String> {
    let refuses = |d: &Difference| matches!(d.concerns, Concerns::Everything | Concerns::Ratios);
    let different = differences(base, now).into_iter().filter(refuses).map(|d| d.what);
    let is_new = |name: &str| base.scenes.iter().all(|scene| scene.name != name);
    let new = now.scenes.iter().filter(|scene| is_new(&scene.name));
    different.chain(new.map(|s| format!("scene {}: not in the baseline", s.name))).collect()
}

/// What is worth a word, and no reason not to compare.
pub fn remarks(base: &RunRecord, now: &RunRecord) -> Vec<String> {
    let mut remarks = Vec::new();
    if base.machine != now.machine {
        let cpu =
            |m: &measurement::record::Machine| m.cpu.clone().unwrap_or_else(|| "unknown".into());
        remarks.push(format!(
            "Another machine than the baseline's ({}; was {}): counters and instruction counts are \
             judged as on the same, times only as ratios to {} within each run.",
            cpu(&now.machine),
            cpu(&base.machine),
            reference::in_words(now)
        ));
    }
    let (was, is) = (&base.settings.timed_by, &now.settings.timed_by);
    if was != is {
        remarks.push(format!(
            "Times of the baseline are {was}, now {is}: what other programs take is in one of them only."
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
