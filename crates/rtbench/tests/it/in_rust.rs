//! Use from Rust programs: runs as a function, and the texts that show the template.

use std::path::Path;

use accel_core::structures::{find, uniform_grid};
use measurement::plan::error::PlanError;
use measurement::record::Verdict;
use measurement::settings::{MeasuringSettings, RunSettings};
use rtbench::error::Error;

use crate::common::{PLANTED, WRONG_ONLY};

/// Settings of a run over a scene.
fn over(scene: &str, measuring: MeasuringSettings) -> RunSettings {
    RunSettings { scenes: vec![scene.into()], measuring, ..RunSettings::default() }
}

#[test]
fn a_run_can_be_called_as_a_function() {
    let grid = find("uniform-grid").unwrap().defaults();
    let dense = grid.clone().set("density", 8).unwrap();
    let measuring = MeasuringSettings {
        reference: Some("brute-force".into()),
        rays: vec!["primary".into(), "shadow".into()],
        quick: true,
        rounds: Some(2),
        size: Some(16),
        ..MeasuringSettings::default()
    };
    let mut settings = over("tetra", measuring);
    settings.structures = vec![grid.label(), dense.label()];
    let record = rtbench::measure(&PLANTED, &settings).unwrap();
    assert!(record.complete && record.scenes.len() == 1 && record.summary.len() == 3);
    assert_eq!(record.settings.resolution, [16, 16]);
    assert_eq!(record.settings.reference, "brute-force");
    let rows = &record.scenes[0].rows;
    let labels: Vec<_> = rows.iter().map(|row| (&*row.structure, &*row.settings)).collect();
    let own = ("uniform-grid", "density=8");
    assert_eq!(labels, [("uniform-grid", ""), own, ("brute-force", "")]);
    for row in rows {
        assert_eq!(row.verdict, Verdict::Ok, "{:?}", row.example);
        assert_eq!(row.samples.len(), 2);
        assert!(row.mrays.keys().eq(["primary", "shadow"]), "{:?}", row.mrays);
    }
}

#[test]
fn a_structure_alone_is_judged_and_found_wrong() {
    // without shadow rays no occluder is a row
    let measuring = MeasuringSettings {
        rays: vec!["primary".into()],
        quick: true,
        rounds: Some(1),
        ..MeasuringSettings::default()
    };
    let record = rtbench::measure(WRONG_ONLY, &over("tetra:2", measuring)).unwrap();
    let rows = &record.scenes[0].rows;
    assert_eq!(rows.len(), 1);
    assert_eq!(rows[0].verdict, Verdict::Wrong);
    assert!(rows[0].mismatches > 0 && rows[0].example.is_some());
}

#[test]
fn impossible_settings_are_refused() {
    let base = MeasuringSettings::default;
    let larger = Some(MeasuringSettings::LARGEST_SIZE + 1);
    for (measuring, expected) in [
        (
            MeasuringSettings { rounds: Some(0), ..base() },
            "rounds: 0, expected a number from 1 to 10000",
        ),
        (
            MeasuringSettings { size: Some(0), ..base() },
            "size: 0, expected a number from 1 to 8192",
        ),
        (MeasuringSettings { size: larger, ..base() }, "size: 8193"),
        (
            MeasuringSettings { threads: 0, ..base() },
            "threads: 0, expected a number from 1 to 1024",
        ),
    ] {
        let error = rtbench::measure(&PLANTED, &over("tetra", measuring)).unwrap_err();
        let is_typed = matches!(error, Error::Plan(PlanError::OutOfRange { .. }));
        assert!(is_typed && error.to_string().starts_with(expected), "{error}");
    }
    // a structure that this registry does not have
    let mut settings = over("tetra", base());
    settings.structures = vec!["kd-tree".into()];
    let error = rtbench::measure(&PLANTED, &settings).unwrap_err();
    assert!(
        matches!(error, Error::Plan(PlanError::UnknownName { what: "structure", .. })),
        "{error}"
    );
    let error = rtbench::measure(&PLANTED, &over("nowhere", base())).unwrap_err();
    assert!(error.to_string().contains("nowhere"), "{error}");
    assert!(uniform_grid::INFO.defaults().set("density", "dense").is_err());
}

#[test]
fn the_text_shows_the_template_as_it_is() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(root.join("docs/bring-your-own.md")).unwrap();
    let main = std::fs::read_to_string(root.join("peers/rust-template/src/main.rs")).unwrap();
    assert!(text.contains(&format!("```rust\n{main}```")), "the chapter shows an older template");
}
