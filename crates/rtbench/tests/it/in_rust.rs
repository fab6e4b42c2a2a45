//! Use from Rust programs: runs as a function, typed settings, the texts that show the template.

use std::path::Path;

use accel_core::structures::{brute_force, find, uniform_grid};
use measurement::plan::error::PlanError;
use measurement::record::Verdict;
use measurement::settings::{MeasuringSettings, RunSettings};
use renderer::RayKind;
use rtbench::error::Error;

use crate::common::{PLANTED, WRONG_ONLY};

#[test]
fn a_run_can_be_called_as_a_function() {
    let grid = find("uniform-grid").unwrap().defaults();
    let dense = grid.clone().set("density", 8).unwrap();
    let settings = RunSettings::default()
        .scene("tetra")
        .row(&grid)
        .row(&dense)
        .reference(&brute_force::INFO.defaults())
        .rays([RayKind::Primary, RayKind::Shadow])
        .quick()
        .rounds(2)
        .size(16);
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
    let base = RunSettings::default().scene("tetra:2").rays([RayKind::Primary]);
    let settings = base.quick().rounds(1);
    let record = rtbench::measure(WRONG_ONLY, &settings).unwrap();
    let rows = &record.scenes[0].rows;
    assert_eq!(rows.len(), 1);
    assert_eq!(rows[0].verdict, Verdict::Wrong);
    assert!(rows[0].mismatches > 0 && rows[0].example.is_some());
}

#[test]
fn impossible_settings_are_refused() {
    let base = RunSettings::default().scene("tetra");
    for (settings, expected) in [
        (base.clone().rounds(0), "rounds: 0, expected a number from 1 to 10000"),
        (base.clone().size(0), "size: 0, expected a number from 1 to 8192"),
        (base.clone().size(MeasuringSettings::LARGEST_SIZE + 1), "size: 8193"),
        (base.clone().threads(0), "threads: 0, expected a number from 1 to 1024"),
    ] {
        let error = rtbench::measure(&PLANTED, &settings).unwrap_err();
        let is_typed = matches!(error, Error::Plan(PlanError::OutOfRange { .. }));
        assert!(is_typed && error.to_string().starts_with(expected), "{error}");
    }
    // a structure that this registry does not have
    let row = base.row(&find("kd-tree").unwrap().defaults());
    let error = rtbench::measure(&PLANTED, &row).unwrap_err();
    assert!(
        matches!(error, Error::Plan(PlanError::UnknownName { what: "structure", .. })),
        "{error}"
    );
    let error = rtbench::measure(&PLANTED, &RunSettings::default().scene("nowhere")).unwrap_err();
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
