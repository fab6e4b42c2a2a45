//! What makes the figures of a run less certain than they look, found in its own record.
//!
//! The reference row stands for the machine: it is the same work in every round, so what its times
//! do beyond that is the machine's doing. Every warning has a threshold, documented where it is
//! defined, that a machine left alone stays below, and ends in advice.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::record::{RunRecord, SceneRecord};
use crate::statistics::outliers::quantile;
use crate::statistics::{mann_whitney, median};
use crate::world::Load;

/// Rounds from which the spread and the drift of a scene are judged.
const FEWEST_ROUNDS: usize = 5;
/// Largest interquartile range of the reference's times, as a part of their median, that is not
/// noise; of several scenes the one in the middle. Recorded runs of the standard scenes on a virtual
/// machine have 0.05 when it is quiet, 0.16 beside other work.
const QUIET_SPREAD: f64 = 0.15;
/// Largest change of the reference's times from the first to the second half of the rounds that is
/// not called drift, and the probability of chance below which it is.
const STEADY: (f64, f64) = (0.1, 0.01);
/// Fewest rounds that are not too few: 5 hold the median in 94% of all cases, 4 in 88%.
const ENOUGH_ROUNDS: usize = 5;
/// Largest part of the machine's processors that others may keep busy.
const SPARE: f64 = 0.25;
/// Shortest time that others' work is judged over: ticks of a processor, a second on Linux.
const FEWEST_TICKS: u64 = 100;
/// Most bytes of the process that may be in swap, and that all may read back during the run.
const SWAP_BYTES: u64 = 1 << 20;
/// Bytes of a page of memory on x86-64; elsewhere pages are larger.
const PAGE_BYTES: u64 = 4096;

/// Something that makes figures less certain than they look. Printed, it ends in advice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Warning {
    /// The reference's times are spread widely: more than [`QUIET_SPREAD`].
    NoisyMachine {
        /// Their interquartile range, as a part of the median.
        spread: f64,
    },
    /// The intervals rest on fewer than [`ENOUGH_ROUNDS`] rounds; not said of a quick run, which is
    /// a first look.
    TooFewRounds {
        /// How many there were.
        rounds: u64,
    },
    /// The reference became slower or faster from the first to the second half of the rounds, by
    /// more than [`STEADY`] allows.
    Drift {
        /// The later times over the earlier ones.
        change: f64,
        /// How the clock is governed, where that is told.
        governor: Option<String>,
    },
    /// Other programs, or other guests of the host, used more than [`SPARE`] of the machine.
    OtherLoad {
        /// Processors they kept busy, on average.
        processors: f64,
        /// Of how many.
        of: u64,
        /// Mean number of runnable processes in the run's last minute.
        load_average: Option<f64>,
    },
    /// Memory was short: more than [`SWAP_BYTES`] of the process in swap, or read back from it.
    Swap {
        /// Bytes of the process in swap at the end.
        own_bytes: u64,
        /// Bytes that all programs read back during the run.
        read_bytes: u64,
    },
    /// In some scenes the reference was not built, or is wrong, and ratios are to another row.
    OtherReference {
        /// The reference of the run.
        reference: String,
        /// The row in its place, by scene.
        instead: BTreeMap<String, String>,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoisyMachine { spread } => write!(
                f,
                "noisy machine: the reference's times are spread by {:.0}% of their median; trust \
                 ratios and their intervals, not seconds, or end other programs and add --rounds",
                100.0 * spread
            ),
            Self::TooFewRounds { rounds } => {
                // the least and the largest of n samples are on one side of the median in two of
                // 2^n cases
                let held = 1.0 - 2.0 * 0.5f64.powf(*rounds as f64);
                write!(
                    f,
                    "too few rounds: intervals of {rounds} hold the median in {:.0}% of all cases, \
                     not 95%; use --rounds 6 or more, or --time-budget",
                    100.0 * held
                )
            }
            Self::Drift { change, governor } => {
                let (by, how) = match *change > 1.0 {
                    true => (change - 1.0, "slower"),
                    false => (1.0 / change - 1.0, "faster"),
                };
                let governed = governor.as_ref().map(|g| format!(" (governor: {g})"));
                write!(
                    f,
                    "drift: the reference became {:.0}% {how} from the first to the second half of \
                     the rounds, as when a clock is scaled{}; fix the clock's rate, let the machine \
                     cool, or trust ratios alone",
                    100.0 * by,
                    governed.unwrap_or_default()
                )
            }
            Self::OtherLoad { processors, of, load_average } => {
                let average = load_average.map(|l| format!(" (load average {l:.2})"));
                write!(
                    f,
                    "other load: other programs or guests kept {processors:.1} of {of} processors \
                     busy{}; end them, or measure again when they are over",
                    average.unwrap_or_default()
                )
            }
            Self::Swap { own_bytes, read_bytes } => write!(
                f,
                "swap: {} MiB of this process are swapped out, {} MiB were read back during the \
                 run; end other programs, or measure smaller scenes",
                own_bytes >> 20,
                read_bytes >> 20
            ),
            Self::OtherReference { reference, instead } => {
                let each: Vec<_> =
                    instead.iter().map(|(scene, row)| format!("{row} in {scene}")).collect();
                write!(
                    f,
                    "other reference: {reference} gave nothing to compare with; ratios are to {}, \
                     and means over scenes join them: compare scene by scene, or name a reference \
                     that serves every scene (--reference)",
                    each.join(", ")
                )
            }
        }
    }
}

/// All that is to be said of a run that is over.
pub fn of(run: &RunRecord) -> Vec<Warning> {
    let machine = [noise(run), rounds(run), drift(run), other_load(&run.load), swap(&run.load)];
    machine.into_iter().chain([other_reference(run)]).flatten().collect()
}

fn other_reference(run: &RunRecord) -> Option<Warning> {
    let reference = run.settings.reference.clone();
    let other = |scene: &SceneRecord| {
        let row = scene.rows.iter().find(|row| row.is_reference)?.label();
        (row != reference).then(|| (scene.name.clone(), row))
    };
    let instead: BTreeMap<_, _> = run.scenes.iter().filter_map(other).collect();
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
    let is_too_few = fewest < ENOUGH_ROUNDS && !run.settings.quick;
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
    use crate::test_record;
    use crate::world::Ticks;

    /// A run whose reference took those times, a scene each.
    fn run(scenes: &[&[f64]]) -> RunRecord {
        let rows: Vec<_> = scenes.iter().map(|times| [("obvhs-cwbvh", *times)]).collect();
        let scenes: Vec<_> = rows.iter().map(|rows| ("tetra", &rows[..])).collect();
        test_record::run(&scenes)
    }

    fn only(run: &RunRecord) -> String {
        let found = of(run);
        assert_eq!(found.len(), 1, "{found:?}");
        let back: Warning =
            serde_json::from_str(&serde_json::to_string(&found[0]).unwrap()).unwrap();
        assert_eq!(back, found[0]);
        back.to_string()
    }

    const QUIET: [f64; 6] = [1.0, 1.01, 0.99, 1.02, 0.98, 1.0];

    #[test]
    fn a_quiet_run_shows_none() {
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
        assert!(only(&few).contains("intervals of 3 hold the median in 75% of all cases"));
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
        assert!(
            said.contains("became 13% slower") && said.contains("governor: powersave"),
            "{said}"
        );
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
    fn a_planted_stand_in_is_named() {
        let mut run = run(&[&QUIET, &QUIET]);
        run.settings.reference = "irregular-grid".into();
        run.scenes.truncate(1);
        let said = only(&run);
        let expected = "irregular-grid gave nothing to compare with; ratios are to obvhs-cwbvh in \
                        tetra,";
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
