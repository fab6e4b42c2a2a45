//! Records of runs that never were, for unit tests.

use serde_json::json;

use crate::record::settings::TIME_OF_DAY;
use crate::record::{RowRecord, RunRecord, SCHEMA_VERSION, Sample, SceneRecord, Settings};
use crate::system::world::World;

/// Rows of a scene: a label and times.
pub type Rows<'a> = &'a [(&'a str, &'a [f64])];

/// A run over scenes whose rows, the reference first, took those times in their rounds. A build
/// takes a tenth of the time.
pub fn run(scenes: &[(&str, Rows<'_>)]) -> RunRecord {
    let world = World::fixed();
    RunRecord {
        schema_version: SCHEMA_VERSION,
        tool: world.tool.clone(),
        command_line: vec!["rtbench".into(), "run".into()],
        started_unix_s: (world.unix_seconds)(),
        machine: (world.machine)(),
        compiler: world.compiler.clone(),
        settings: Settings {
            seed: 1,
            threads: 1,
            precision: "f32".into(),
            resolution: [16, 16],
            max_depth: 4,
            rays: vec!["primary".into()],
            reference: scenes
                .iter()
                .flat_map(|s| s.1)
                .map(|r| r.0.into())
                .next()
                .unwrap_or_default(),
            order: "scanline".into(),
            lights: "each".into(),
            processes: 1,
            timed_by: TIME_OF_DAY.into(),
            ..Settings::default()
        },
        scenes: scenes.iter().map(|(name, rows)| scene(name, rows)).collect(),
        planned: scenes.iter().map(|(name, _)| (*name).into()).collect(),
        complete: true,
        ..RunRecord::default()
    }
}

fn scene(name: &str, rows: Rows<'_>) -> SceneRecord {
    let reference = rows.first().map_or(&[][..], |row| row.1);
    let row = |(i, (label, times)): (usize, &(&str, &[f64]))| -> RowRecord {
        let (structure, settings) = label.split_once(' ').unwrap_or((label, ""));
        let row = json!({
            "structure": structure, "settings": settings, "is_reference": i == 0,
            "verdict": "ok", "checked_rays": 256, "mismatches": 0, "answers_sha256": "ab",
            "shape": {"n_in": 1, "n_v": 2, "n_ev": 0, "n_oiv": 4, "memory_bytes": 64},
            "work": {"rays": 256, "intersection_tests": 512, "traversal_steps": 256,
                     "elementary_steps": 128, "empty_elementary_steps": 0},
            "stride": 1, "rays": 256, "rays_by_kind": {"primary": 256}, "mrays": {}, "samples": [],
        });
        let mut row: RowRecord = serde_json::from_value(row).unwrap();
        row.samples = times
            .iter()
            .enumerate()
            .map(|(round, &seconds)| Sample {
                process: 0,
                round: round as u32,
                position: i as u32,
                build_s: seconds / 10.0,
                trace_s: [("primary".to_owned(), seconds)].into(),
                reference_trace_s: reference.get(round).copied(),
                reference_build_s: reference.get(round).map(|s| s / 10.0),
                reference_by_kind: (reference.get(round).into_iter())
                    .map(|s| ("primary".to_owned(), *s))
                    .collect(),
            })
            .collect();
        row
    };
    SceneRecord {
        name: name.into(),
        sha256: "cd".into(),
        source: "made up".into(),
        primitives: 4,
        geometry_bytes: 144,
        only_triangles: Some(true),
        rays: [("primary".to_owned(), 256)].into(),
        rows: rows.iter().enumerate().map(row).collect(),
        ..SceneRecord::default()
    }
}
