//! The same run on several machines: what each ratio is on each, and its range over them.
//!
//! A ratio within a run does not depend on how fast a machine is, but on its caches, its memory and
//! the neighbours it has: an interval of one machine promises nothing of the next. Runs must be of
//! the same program, settings and scenes; machines may be of one model, and are distinguished by
//! their order.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::journal::lines::compare;
use crate::record::merge::PartialRun;
use crate::record::ratios::{build_ratios, kind_ratios, trace_ratios};
use crate::record::{Machine, RowRecord, RunRecord, SCHEMA_VERSION, SceneRecord, Tool};
use statistics::estimate::{Estimate, geometric_mean};
use statistics::mann_whitney::samples_needed;
use statistics::series::{FEWEST_ROUNDS, Series};
use statistics::verdict::{Change, correct};

/// The probability of one false alarm among all ratios and machines.
const SIGNIFICANCE: f64 = 0.05;

/// Runs that are not the same but for their machines.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MachinesError {
    #[error("expected at least two runs, of different machines; found {found}")]
    TooFew { found: usize },
    #[error("{}: {finished} of {scenes} scenes; finish it with `rtbench run --resume`", path.display())]
    Unfinished { path: PathBuf, finished: usize, scenes: usize },
    #[error("{}: not the same run as {}: {}", path.display(), first.display(), differences.join("; "))]
    Differs { path: PathBuf, first: PathBuf, differences: Vec<String> },
}

/// A run on several machines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct MachinesRecord {
    /// Version of this schema: that of runs.
    pub schema_version: u32,
    pub tool: Tool,
    /// The command line that joined them, program first.
    pub command_line: Vec<String>,
    /// The reference row of ratios.
    pub reference: String,
    /// The machines, in the order given.
    pub machines: Vec<MachineRun>,
    /// Ratios of the means over all scenes, then of each scene.
    pub ratios: Vec<MachineRatio>,
    /// Where the rounds are too few for any ratio of a scene to differ significantly: how many can.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rounds_needed: Option<usize>,
}

/// A run on one of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct MachineRun {
    pub machine: Machine,
    /// When the run began, seconds since 1970.
    pub started_unix_s: u64,
    /// Processes in which rows were built and timed.
    pub processes: u32,
}

/// A ratio to the reference on all machines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct MachineRatio {
    /// The scene; none of means over all.
    pub scene: Option<String>,
    /// Name of the structure, without its settings.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// `build`, `trace`, or the kind of rays.
    pub quantity: String,
    /// On each machine; none where it was not timed.
    pub of_machines: Vec<Option<Estimate>>,
    /// The geometric mean over the machines.
    pub mean: f64,
    /// The least of the machines.
    pub least: f64,
    pub most: f64,
    /// Two machines differ by more than chance explains, among all that were compared.
    pub is_apart: bool,
}

/// Joins runs of several machines.
pub fn over_machines(
    runs: &[PartialRun],
    command_line: &[String],
) -> Result<MachinesRecord, MachinesError> {
    let [first, others @ ..] = runs else { return Err(MachinesError::TooFew { found: 0 }) };
    if others.is_empty() {
        return Err(MachinesError::TooFew { found: 1 });
    }
    for PartialRun { path, record } in runs {
        if !record.complete {
            return Err(MachinesError::Unfinished {
                path: path.clone(),
                finished: record.scenes.len(),
                scenes: record.planned.len(),
            });
        }
    }
    for other in others {
        let mut differences = Vec::new();
        compare("", &common(&first.record), &common(&other.record), &mut differences);
        if !differences.is_empty() {
            let (path, first) = (other.path.clone(), first.path.clone());
            return Err(MachinesError::Differs { path, first, differences });
        }
    }
    let records: Vec<&RunRecord> = runs.iter().map(|run| &run.record).collect();
    let machine = |RunRecord { machine, started_unix_s, settings, .. }: &&RunRecord| MachineRun {
        machine: machine.clone(),
        started_unix_s: *started_unix_s,
        processes: settings.processes,
    };
    let mut ratios = ratios(&records);
    let rounds_needed = mark_apart(&mut ratios);
    Ok(MachinesRecord {
        schema_version: SCHEMA_VERSION,
        tool: first.record.tool.clone(),
        command_line: command_line.to_vec(),
        reference: first.record.settings.reference.clone(),
        machines: records.iter().map(machine).collect(),
        ratios: ratios.into_iter().map(|measured| measured.ratio).collect(),
        rounds_needed,
    })
}

/// What must be the same.
fn common(record: &RunRecord) -> Value {
    let scene = |scene: &SceneRecord| {
        let rows: Vec<String> = scene.rows.iter().map(RowRecord::label).collect();
        serde_json::json!({ "name": scene.name, "sha256": scene.sha256, "rays": scene.rays, "rows": rows })
    };
    // more or fewer processes are no other question
    let mut settings = record.settings.clone();
    settings.processes = 1;
    serde_json::json!({
        "tool": record.tool,
        "target": record.compiler.target,
        "target_features": record.compiler.target_features,
        "profile": record.compiler.profile,
        "settings": settings,
        "scenes": record.scenes.iter().map(scene).collect::<Vec<_>>(),
    })
}

/// A ratio and its rounds on each machine, by scene.
struct RatioOnMachines {
    ratio: MachineRatio,
    rounds: Vec<Vec<Series>>,
}

/// Build, trace, and each kind of rays.
type RowRatios<'r> = (Option<Estimate>, Option<Estimate>, &'r BTreeMap<String, Estimate>);

fn ratios<'r>(records: &[&'r RunRecord]) -> Vec<RatioOnMachines> {
    let Some(first) = records.first() else { return Vec::new() };
    let mut all = Vec::new();
    let mut add = |name: (Option<&str>, &str, &str),
                   of: &dyn Fn(&'r RunRecord) -> Option<RowRatios<'r>>| {
        let of: Vec<_> = records.iter().map(|record| of(record)).collect();
        let mut push = |quantity: &str, of_machines| {
            all.extend(ratio(name, quantity, of_machines, rounds_of(records, name, quantity)));
        };
        push("build", of.iter().map(|row| row.and_then(|row| row.0)).collect());
        push("trace", of.iter().map(|row| row.and_then(|row| row.1)).collect());
        for kind in of.first().into_iter().flatten().flat_map(|row| row.2.keys()) {
            push(kind, of.iter().map(|row| row.and_then(|row| row.2.get(kind).copied())).collect());
        }
    };
    for (i, row) in first.summary.iter().enumerate() {
        add((None, &row.structure, &row.settings), &|record| {
            let row = record.summary.get(i)?;
            Some((row.build_ratio, row.ratio, &row.ratio_by_kind))
        });
    }
    for (s, scene) in first.scenes.iter().enumerate() {
        for (i, row) in scene.rows.iter().enumerate() {
            add((Some(&scene.name), &row.structure, &row.settings), &|record| {
                let row = record.scenes.get(s)?.rows.get(i)?;
                Some((row.build_ratio, row.ratio, &row.ratio_by_kind))
            });
        }
    }
    all
}

/// The rounds of a ratio on each machine, a series for each scene that has the row. None for the
/// reference, which is 1 everywhere.
fn rounds_of(
    records: &[&RunRecord],
    (scene, structure, settings): (Option<&str>, &str, &str),
    quantity: &str,
) -> Vec<Vec<Series>> {
    let of_row = |row: &RowRecord, own: &SceneRecord| match quantity {
        "build" => build_ratios(own, row),
        "trace" => trace_ratios(row),
        kind => kind_ratios(row, kind),
    };
    let of_scene = |own: &SceneRecord| {
        let is_own = |row: &&RowRecord| {
            row.structure == structure && row.settings == settings && !row.is_reference
        };
        let series = own.rows.iter().find(is_own).map(|row| of_row(row, own));
        series.unwrap_or_default()
    };
    let is_asked = |own: &&SceneRecord| scene.is_none_or(|name| own.name == name);
    let of_record =
        |record: &&RunRecord| record.scenes.iter().filter(is_asked).map(of_scene).collect();
    records.iter().map(of_record).collect()
}

/// Marks the ratios that differ between two machines by more than chance explains, corrected for
/// all ratios and all pairs of machines. Returns the rounds that can be significant, where these
/// cannot.
fn mark_apart(all: &mut [RatioOnMachines]) -> Option<usize> {
    let mut tested: Vec<(usize, Change)> = Vec::new();
    let mut has_processes = false;
    for (place, RatioOnMachines { rounds, .. }) in all.iter().enumerate() {
        for (i, one) in rounds.iter().enumerate() {
            for other in rounds.iter().skip(i + 1) {
                let pairs = one.iter().zip(other).map(|(a, b)| [a, b]);
                let groups = pairs.filter(|pair| pair.iter().all(|series| !series.is_empty()));
                let groups: Vec<[&Series; 2]> = groups.collect();
                has_processes |= groups.iter().flatten().any(|series| series.has_levels());
                tested.extend(Change::of_mean(&groups).map(|change| (place, change)));
            }
        }
    }
    let samples = tested.iter().map(|(_, change)| change.samples).min().unwrap_or(0);
    let needed = FEWEST_ROUNDS.max(samples_needed(tested.len(), SIGNIFICANCE));
    let needed = (!has_processes && samples < needed).then_some(needed);
    if samples < FEWEST_ROUNDS && !has_processes {
        return needed;
    }
    correct(tested.iter_mut().map(|(_, change)| change));
    for (place, change) in tested {
        let is_apart = change.ratio.is_some_and(|ratio| !ratio.holds(1.0))
            && change.p.is_some_and(|p| p < SIGNIFICANCE);
        if let Some(measured) = all.get_mut(place).filter(|_| is_apart) {
            measured.ratio.is_apart = true;
        }
    }
    needed
}

/// None where no machine has it.
fn ratio(
    (scene, structure, settings): (Option<&str>, &str, &str),
    quantity: &str,
    of_machines: Vec<Option<Estimate>>,
    rounds: Vec<Vec<Series>>,
) -> Option<RatioOnMachines> {
    let known: Vec<Estimate> = of_machines.iter().copied().flatten().collect();
    let medians: Vec<f64> = known.iter().map(|e| e.median).collect();
    let ratio = MachineRatio {
        scene: scene.map(str::to_owned),
        structure: structure.to_owned(),
        settings: settings.to_owned(),
        quantity: quantity.to_owned(),
        mean: geometric_mean(&medians)?,
        least: medians.iter().copied().fold(f64::INFINITY, f64::min),
        most: medians.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        is_apart: false,
        of_machines,
    };
    Some(RatioOnMachines { ratio, rounds })
}

impl MachinesRecord {
    /// Pairs of runs, from 1, of which nothing in the records says that their machines are two.
    pub fn perhaps_one(&self) -> Vec<[usize; 2]> {
        let is_alike = |a: &Machine, b: &Machine| {
            let of = |m: &Machine| (m.cpu.clone(), m.threads, m.batches_by_avx512);
            of(a) == of(b)
        };
        let runs = || self.machines.iter().zip(1..);
        let pairs = runs().flat_map(|one| runs().map(move |other| (one, other)));
        let alike =
            pairs.filter(|((one, i), (other, j))| i < j && is_alike(&one.machine, &other.machine));
        alike.map(|((_, i), (_, j))| [i, j]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::made_up::run;
    use crate::record::summary::summarize;
    use statistics::random::Random;

    fn part(name: &str, grid: &[f64]) -> PartialRun {
        let rows: &[(&str, &[f64])] =
            &[("obvhs-cwbvh", &[1.0; 8][..grid.len()]), ("uniform-grid", grid)];
        let mut record = run(&[("tetra", rows), ("balls", rows)]);
        for row in record.scenes.iter_mut().flat_map(|s| &mut s.rows) {
            row.figure(1);
        }
        record.summary = summarize(&record.scenes, &record.settings);
        record.machine.cpu = Some(name.into());
        PartialRun { path: name.into(), record }
    }

    #[test]
    fn ratios_have_their_range_over_machines() {
        let times =
            |by: f64| -> Vec<f64> { (0..8).map(|i| by + 0.01 * f64::from(i % 3)).collect() };
        let parts = [part("a", &times(2.0)), part("b", &times(3.0))];
        let joined = over_machines(&parts, &[]).unwrap();
        assert_eq!(joined.machines.len(), 2);
        let of = |scene: Option<&str>, quantity: &str| {
            let asked = (scene, "uniform-grid", quantity);
            let is = |r: &&MachineRatio| (r.scene.as_deref(), &*r.structure, &*r.quantity) == asked;
            joined.ratios.iter().find(is)
        };
        for scene in [None, Some("tetra"), Some("balls")] {
            let ratio = of(scene, "trace").unwrap();
            assert!((ratio.least - 2.01).abs() < 1e-9 && (ratio.most - 3.01).abs() < 1e-9);
            assert!((ratio.mean - 6.0501f64.sqrt()).abs() < 1e-9 && ratio.is_apart, "{ratio:?}");
            assert!(of(scene, "primary").is_some() && of(scene, "build").is_some());
        }
        let alike = over_machines(&[parts[0].clone(), parts[0].clone()], &[]).unwrap();
        assert!(alike.ratios.iter().all(|r| !r.is_apart && r.least == r.most));
        assert_eq!((joined.perhaps_one(), alike.perhaps_one()), (vec![], vec![[1, 2]]));
    }

    #[test]
    fn noise_is_not_reported_as_a_difference_of_machines() {
        let mut random = Random::new(3, "two runs of one machine");
        let mut noise = |n: usize| -> Vec<f64> {
            (0..n).map(|_| 2.0 + random.next_u64() as f64 / u64::MAX as f64).collect()
        };
        let mut apart = [0; 2];
        for _ in 0..20 {
            for (place, rounds) in [(0, 3), (1, 8)] {
                let parts = [part("a", &noise(rounds)), part("a", &noise(rounds))];
                let joined = over_machines(&parts, &[]).unwrap();
                apart[place] += usize::from(joined.ratios.iter().any(|r| r.is_apart));
                // two scenes and their mean: build, trace and primary rays of one row
                assert_eq!(joined.rounds_needed, (rounds == 3).then_some(6));
            }
        }
        // three rounds say nothing; of twenty pairs of runs one may be called different
        assert!(apart[0] == 0 && apart[1] <= 3, "{apart:?}");
    }

    #[test]
    fn runs_with_other_settings_are_refused() {
        let one = part("a", &[2.0; 4]);
        let other = |plant: fn(&mut RunRecord)| {
            let mut other = part("b", &[2.0; 4]);
            plant(&mut other.record);
            over_machines(&[one.clone(), other], &[]).map(|_| ()).map_err(|e| e.to_string())
        };
        assert_eq!(other(|_| ()), Ok(()));
        assert_eq!(other(|r| r.settings.processes = 3), Ok(()));
        for (plant, said) in [
            ((|r| r.settings.seed = 7) as fn(&mut RunRecord), "settings.seed: was 1, is 7"),
            (|r| r.tool.git_revision = Some("ff".into()), "git_revision"),
            (|r| r.scenes[0].sha256 = "ef".into(), "sha256"),
            (|r| r.scenes[1].rows.truncate(1), "rows"),
            (|r| r.complete = false, "scenes; finish it"),
        ] {
            let error = other(plant).unwrap_err();
            assert!(error.contains(said), "{said}: {error}");
        }
        let error = over_machines(&[one], &[]).unwrap_err();
        assert_eq!(error, MachinesError::TooFew { found: 1 });
    }
}
