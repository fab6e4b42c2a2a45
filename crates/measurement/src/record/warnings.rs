//! Finds in a record what makes its figures less certain than they look.
//!
//! The reference row stands for the machine: it is the same work in every round, so what its times
//! do beyond that is the machine's doing.

use std::collections::BTreeMap;

use crate::record::reference::elsewhere;
use crate::record::warning::{QUIET_SPREAD, SPARE, STEADY, SWAP_BYTES};
use crate::record::{Load, RunRecord, SceneRecord, Warning};
use statistics::estimate::{median, quantile};
use statistics::mann_whitney;
use statistics::series::FEWEST_ROUNDS;

/// Shortest time that others' work is judged over: ticks of a processor, a second on Linux.
const FEWEST_TICKS: u64 = 100;
/// Bytes of a page of memory on x86-64; elsewhere pages are larger.
const PAGE_BYTES: u64 = 4096;

/// All that is to be said of a run that is over.
pub fn of(run: &RunRecord) -> Vec<Warning> {
    let machine = [noise(run), rounds(run), drift(run), other_load(&run.load), swap(&run.load)];
    machine.into_iter().chain([other_reference(run)]).flatten().collect()
}

fn other_reference(run: &RunRecord) -> Option<Warning> {
    let reference = run.settings.reference.clone();
    let other = |(scene, row): (&str, String)| (scene.to_owned(), row);
    let instead: BTreeMap<_, _> = elsewhere(&run.scenes, &reference).map(other).collect();
    (!instead.is_empty()).then_some(Warning::OtherReference { reference, instead })
}

/// Times of the reference row, by round; none where they are too few to be judged.
fn of_reference(scene: &SceneRecord) -> Option<Vec<f64>> {
    let row = scene.rows.iter().find(|r| r.is_reference)?;
    let times: Vec<f64> = row.samples.iter().map(|s| s.total_trace_s()).collect();
    let is_usable = times.len() >= FEWEST_ROUNDS && median(&times)? > 0.0;
    is_usable.then_some(times)
}

fn noise(run: &RunRecord) -> Option<Warning> {
    let spread = |scene: &SceneRecord| {
        let mut times = of_reference(scene)?;
        times.sort_by(f64::total_cmp);
        Some((quantile(&times, 0.75) - quantile(&times, 0.25)) / median(&times)?)
    };
    let spreads: Vec<f64> = run.scenes.iter().filter_map(spread).collect();
    let spread = median(&spreads).filter(|spread| *spread > QUIET_SPREAD)?;
    Some(Warning::NoisyMachine { spread })
}

fn rounds(run: &RunRecord) -> Option<Warning> {
    let rows = run.scenes.iter().flat_map(|s| &s.rows).filter(|r| !r.samples.is_empty());
    let fewest = rows.map(|r| r.samples.len()).min()?;
    let is_too_few = fewest < FEWEST_ROUNDS && !run.settings.quick;
    is_too_few.then_some(Warning::TooFewRounds { rounds: fewest as u64 })
}

fn drift(run: &RunRecord) -> Option<Warning> {
    let (mut early, mut late) = (Vec::new(), Vec::new());
    for scene in &run.scenes {
        let Some(times) = of_reference(scene) else { continue };
        let Some(middle) = median(&times) else { continue };
        // scenes are joined as parts of their medians
        let parts = || times.iter().map(|t| t / middle);
        let half = times.len() / 2;
        early.extend(parts().take(half));
        late.extend(parts().rev().take(half));
    }
    let change = median(&late)? / median(&early)?;
    let (most, chance) = STEADY;
    let is_drift = change.ln().abs() > (1.0 + most).ln()
        && mann_whitney::p_value(&early, &late).is_some_and(|p| p < chance);
    is_drift.then(|| Warning::Drift { change, governor: run.machine.governor.clone() })
}

fn other_load([before, after]: &[Load; 2]) -> Option<Warning> {
    let (old, new) = (before.ticks?, after.ticks?);
    let of = new.processors.max(1);
    let passed = new.all.checked_sub(old.all)? as f64 / of as f64;
    let busy = new.busy.checked_sub(old.busy)?;
    let others = busy.saturating_sub(new.own.saturating_sub(old.own));
    let processors = others as f64 / passed;
    let is_much = passed >= FEWEST_TICKS as f64 && processors > SPARE * of as f64;
    is_much.then_some(Warning::OtherLoad { processors, of, load_average: after.average })
}

fn swap([before, after]: &[Load; 2]) -> Option<Warning> {
    let own_bytes = after.swapped_bytes.unwrap_or(0);
    let read = |from: u64, to: u64| to.saturating_sub(from).saturating_mul(PAGE_BYTES);
    let pages = before.pages_swapped_in.zip(after.pages_swapped_in);
    let read_bytes = pages.map_or(0, |(from, to)| read(from, to));
    let is_much = own_bytes.max(read_bytes) > SWAP_BYTES;
    is_much.then_some(Warning::Swap { own_bytes, read_bytes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Ticks, made_up};

    /// A run whose reference took those times, a scene each.
    fn run(scenes: &[&[f64]]) -> RunRecord {
        let rows: Vec<_> = scenes.iter().map(|times| [("obvhs-cwbvh", *times)]).collect();
        let scenes: Vec<_> = rows.iter().map(|rows| ("tetra", &rows[..])).collect();
        made_up::run(&scenes)
    }

    fn only(run: &RunRecord) -> String {
        let found = of(run);
        assert_eq!(found.len(), 1, "{found:?}");
        let text = serde_json::to_string(&found[0]).unwrap();
        let back: Warning = serde_json::from_str(&text).unwrap();
        assert_eq!(back, found[0]);
        back.to_string()
    }

    const QUIET: [f64; 6] = [1.0, 1.01, 0.99, 1.02, 0.98, 1.0];

    #[test]
    fn quiet_runs_have_no_warnings() {
        assert_eq!(of(&run(&[&QUIET, &QUIET])), []);
        assert_eq!(of(&run(&[])), []);
        // one noisy scene of three is no noisy machine
        assert_eq!(of(&run(&[&QUIET, &[1.0, 2.0, 1.0, 2.0, 1.0, 2.0], &QUIET])), []);
    }

    #[test]
    fn planted_noise_is_found() {
        let said = only(&run(&[&[1.0, 1.3, 1.0, 1.3, 1.3, 1.0]]));
        assert!(said.starts_with("noisy machine: ") && said.ends_with("add --rounds"), "{said}");
    }

    #[test]
    fn too_few_rounds_are_found_except_in_a_first_look() {
        let mut few = run(&[&QUIET, &[1.0, 1.0, 1.0]]);
        assert!(only(&few).contains("the range of 3 holds the median in 75% of all cases"));
        few.settings.quick = true;
        assert_eq!(of(&few), []);
        assert_eq!(of(&run(&[&QUIET[..5]])), []);
    }

    #[test]
    fn a_planted_drift_is_found_and_its_governor_named() {
        // spread by less than what is called noise
        let slower = [1.0, 1.01, 1.0, 1.02, 1.13, 1.14, 1.14, 1.13];
        let mut run = run(&[&slower, &slower]);
        run.machine.governor = Some("powersave".into());
        let said = only(&run);
        assert!(said.contains("became 13% slower"), "{said}");
        assert!(said.contains("governor: powersave"), "{said}");
        for scene in &mut run.scenes {
            scene.rows[0].samples.reverse();
        }
        assert!(only(&run).contains("became 13% faster"));
    }

    #[test]
    fn planted_load_of_others_is_found() {
        let ticks = |all, busy, own| Some(Ticks { processors: 4, all, busy, own });
        let mut run = run(&[&QUIET]);
        run.load[0].ticks = ticks(1000, 500, 10);
        // four processors for 1000 ticks each: this process one, others 1.5
        run.load[1] =
            Load { ticks: ticks(5000, 3000, 1010), average: Some(2.5), ..Load::default() };
        let said = only(&run);
        assert!(said.contains("kept 1.5 of 4 processors busy (load average 2.50)"), "{said}");
        run.load[1].ticks = ticks(5000, 2400, 1010);
        assert_eq!(of(&run), []);
        // too short to say
        run.load[1].ticks = ticks(1200, 700, 10);
        assert_eq!(of(&run), []);
    }

    #[test]
    fn planted_substitute_references_are_warned_of() {
        let mut run = run(&[&QUIET, &QUIET]);
        run.settings.reference = "irregular-grid".into();
        run.scenes.truncate(1);
        let said = only(&run);
        let expected = "irregular-grid was not built or is wrong, so ratios are to obvhs-cwbvh in \
                        tetra;";
        assert!(said.contains(expected), "{said}");
    }

    #[test]
    fn planted_swapping_is_found() {
        let mut run = run(&[&QUIET]);
        run.load[1].swapped_bytes = Some(5 << 20);
        assert!(only(&run).contains("swap: 5 MiB of this process"));
        run.load = [100, 612].map(|n| Load { pages_swapped_in: Some(n), ..Load::default() });
        assert!(only(&run).contains("2 MiB were read back"));
        run.load[1].pages_swapped_in = Some(110);
        assert_eq!(of(&run), []);
    }
}
