//! The same run on several machines: what each ratio is on each, and its range over them.
//!
//! A ratio within a run does not depend on how fast a machine is, but on its caches, its memory and the
//! neighbours it has: an interval of one machine promises nothing of the next. Runs must be of the
//! same program, settings and scenes; machines may be of one model, and are told apart by their order.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::journal::lines::compare;
use crate::record::merge::Part;
use crate::record::{Machine, RowRecord, RunRecord, SCHEMA_VERSION, SceneRecord, Tool};
use statistics::estimate::{Estimate, geometric_mean};

/// Runs that are not the same but for their machines.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MachinesError {
    /// There is nothing to compare.
    #[error("expected two runs at least, of different machines; found {found}")]
    TooFew {
        /// Runs that were named.
        found: usize,
    },
    /// It was broken off.
    #[error("{}: {finished} of {scenes} scenes; finish it with `rtbench run --resume`", path.display())]
    Unfinished {
        /// The file or folder.
        path: PathBuf,
        /// Scenes that are finished.
        finished: usize,
        /// Scenes that it was to have.
        scenes: usize,
    },
    /// It is another run than the first.
    #[error("{}: not the same run as {}: {}", path.display(), first.display(), differences.join("; "))]
    Differs {
        /// The file or folder.
        path: PathBuf,
        /// The one it differs from.
        first: PathBuf,
        /// What differs: `settings.seed: was 1, is 2`.
        differences: Vec<String>,
    },
}

/// A run on several machines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct MachinesRecord {
    /// Version of this schema: that of runs.
    pub schema_version: u32,
    /// The program.
    pub tool: Tool,
    /// The command line that joined them, program first.
    pub command_line: Vec<String>,
    /// The reference row of ratios.
    pub reference: String,
    /// The machines, in the order given.
    pub machines: Vec<MachineRun>,
    /// Ratios of the means over all scenes, then of each scene.
    pub ratios: Vec<MachineRatio>,
}

/// A run on one of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct MachineRun {
    /// The machine.
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
    /// Structure.
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
    /// The largest.
    pub most: f64,
    /// Two machines have intervals without a common point: the machine decides, and not chance.
    pub is_apart: bool,
}

/// Joins runs of several machines.
///
/// # Errors
/// [`MachinesError`].
pub fn over_machines(
    runs: &[Part],
    command_line: &[String],
) -> Result<MachinesRecord, MachinesError> {
    let [first, others @ ..] = runs else { return Err(MachinesError::TooFew { found: 0 }) };
    if others.is_empty() {
        return Err(MachinesError::TooFew { found: 1 });
    }
    for Part { path, record } in runs {
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
    let machine = |record: &&RunRecord| MachineRun {
        machine: record.machine.clone(),
        started_unix_s: record.started_unix_s,
        processes: record.settings.processes,
    };
    Ok(MachinesRecord {
        schema_version: SCHEMA_VERSION,
        tool: first.record.tool.clone(),
        command_line: command_line.to_vec(),
        reference: first.record.settings.reference.clone(),
        machines: records.iter().map(machine).collect(),
        ratios: ratios(&records),
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

fn ratios(records: &[&RunRecord]) -> Vec<MachineRatio> {
    let Some(first) = records.first() else { return Vec::new() };
    let mut all = Vec::new();
    for (i, row) in first.summary.iter().enumerate() {
        let name = (None, row.structure.as_str(), row.settings.as_str());
        let of = |read: &dyn Fn(&crate::record::SummaryRow) -> Option<Estimate>| {
            records.iter().map(|r| read(r.summary.get(i)?)).collect::<Vec<_>>()
        };
        all.extend(ratio(name, "build", of(&|row| row.build_ratio)));
        all.extend(ratio(name, "trace", of(&|row| row.ratio)));
        for kind in row.ratio_by_kind.keys() {
            all.extend(ratio(name, kind, of(&|row| row.ratio_by_kind.get(kind).copied())));
        }
    }
    for (s, scene) in first.scenes.iter().enumerate() {
        for (i, row) in scene.rows.iter().enumerate() {
            let name = (Some(scene.name.as_str()), row.structure.as_str(), row.settings.as_str());
            let of = |read: &dyn Fn(&RowRecord) -> Option<Estimate>| {
                let row = |r: &&RunRecord| read(r.scenes.get(s)?.rows.get(i)?);
                records.iter().map(row).collect::<Vec<_>>()
            };
            all.extend(ratio(name, "build", of(&|row| row.build_ratio)));
            all.extend(ratio(name, "trace", of(&|row| row.ratio)));
            for kind in row.ratio_by_kind.keys() {
                all.extend(ratio(name, kind, of(&|row| row.ratio_by_kind.get(kind).copied())));
            }
        }
    }
    all
}

/// None where no machine has it.
fn ratio(
    (scene, structure, settings): (Option<&str>, &str, &str),
    quantity: &str,
    of_machines: Vec<Option<Estimate>>,
) -> Option<MachineRatio> {
    let known: Vec<Estimate> = of_machines.iter().copied().flatten().collect();
    let medians: Vec<f64> = known.iter().map(|e| e.median).collect();
    let highest_low = known.iter().map(|e| e.low).fold(f64::NEG_INFINITY, f64::max);
    let lowest_high = known.iter().map(|e| e.high).fold(f64::INFINITY, f64::min);
    Some(MachineRatio {
        scene: scene.map(str::to_owned),
        structure: structure.to_owned(),
        settings: settings.to_owned(),
        quantity: quantity.to_owned(),
        mean: geometric_mean(&medians)?,
        least: medians.iter().copied().fold(f64::INFINITY, f64::min),
        most: medians.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        is_apart: highest_low > lowest_high,
        of_machines,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::made_up::run;
    use crate::record::summary::summarize;

    fn part(name: &str, grid: &[f64]) -> Part {
        let rows: &[(&str, &[f64])] = &[("obvhs-cwbvh", &[1.0; 4]), ("uniform-grid", grid)];
        let mut record = run(&[("tetra", rows), ("balls", rows)]);
        for row in record.scenes.iter_mut().flat_map(|s| &mut s.rows) {
            row.figure(1);
        }
        record.summary = summarize(&record.scenes, &record.settings);
        record.machine.cpu = Some(name.into());
        Part { path: name.into(), record }
    }

    #[test]
    fn ratios_have_their_range_over_machines() {
        let parts = [part("a", &[2.0, 2.1, 1.9, 2.0]), part("b", &[3.0, 3.1, 2.9, 3.0])];
        let joined = over_machines(&parts, &[]).unwrap();
        assert_eq!(joined.machines.len(), 2);
        let of = |scene: Option<&str>, quantity: &str| {
            joined.ratios.iter().find(|r| {
                r.scene.as_deref() == scene
                    && r.structure == "uniform-grid"
                    && r.quantity == quantity
            })
        };
        for scene in [None, Some("tetra"), Some("balls")] {
            let ratio = of(scene, "trace").unwrap();
            assert!((ratio.least - 2.0).abs() < 1e-9 && (ratio.most - 3.0).abs() < 1e-9);
            assert!((ratio.mean - 6.0f64.sqrt()).abs() < 1e-9 && ratio.is_apart, "{ratio:?}");
            assert!(of(scene, "primary").is_some() && of(scene, "build").is_some());
        }
        let alike = over_machines(&[parts[0].clone(), parts[0].clone()], &[]).unwrap();
        assert!(alike.ratios.iter().all(|r| !r.is_apart && r.least == r.most));
    }

    #[test]
    fn what_is_not_the_same_run_is_refused() {
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
