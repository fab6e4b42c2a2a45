//! Completions, manual pages, the doctor, and suggestions for misspelt names.

use std::time::Duration;

use accel_core::occluders;
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SteppingClock;
use measurement::system::world::World;

use crate::common::{Folder, PLANTED, run, run_in_world, run_stepping};

#[test]
fn completions_and_pages_have_the_commands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let ended = run(&format!("generate completions {shell}"));
        assert_eq!((ended.code, ended.err.as_str()), (0, ""), "{shell}");
        for part in ["rtbench", "merge", "shard"] {
            assert!(ended.out.contains(part), "{shell}: {part}");
        }
    }
    let top = run("generate man");
    assert!(top.out.starts_with(".ie") && top.out.contains("Exit codes"), "{}", top.out);
    let page = run("generate man run");
    assert!(page.out.contains("\\-\\-shard"), "{}", page.out);
    let folder = Folder::new();
    assert_eq!(run(&format!("generate man -o {}/man", folder.path())).code, 0);
    for page in ["rtbench.1", "rtbench-run.1", "rtbench-scenes-info.1"] {
        assert!(folder.text(&format!("man/{page}")).contains(".TH"), "{page}");
    }
}

#[test]
fn the_doctor_says_what_each_finding_means() {
    let ended = run_stepping("doctor --format json");
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    let diagnosis: serde_json::Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!(diagnosis["noise"]["spread"], 0.0, "the clock of the test is even");
    let findings = diagnosis["findings"].as_array().unwrap();
    for name in
        ["governor", "boost", "load", "cores", "memory", "virtual machine", "instructions", "noise"]
    {
        let found = findings.iter().find(|f| f["name"] == name);
        let found = found.unwrap_or_else(|| panic!("{name}: {findings:?}"));
        assert_eq!(found["level"] == "warning", found["advice"].is_string(), "{found}");
        assert!(found["meaning"].as_str().is_some_and(|m| m.len() > 20), "{found}");
    }
    let text = run_stepping("doctor");
    assert!(text.out.contains("noise") && text.out.contains("may disturb measurements"));
}

#[test]
fn a_program_compiled_below_its_processor_says_so_once() {
    let told = |features: &[&'static str], arguments: &str| {
        let clock = SteppingClock::new(Duration::from_millis(1));
        let processor_features = features.to_vec();
        let world = World { processor_features, ..World::fixed() };
        run_in_world(&PLANTED, occluders::REGISTRY, &InstalledScenes, &clock, &world, arguments)
    };
    let said = "compiled without bmi2, lzcnt, which this processor has";
    let (more, run) = (["avx2", "bmi2", "lzcnt"], "run tetra:1 tetra:2 --quick -s uniform-grid");
    for command in [run, "sweep tetra:1 --quick -s uniform-grid -p density --values 1,2"] {
        let ended = told(&more, command);
        assert_eq!((ended.code, ended.err.matches(said).count()), (0, 1), "{}", ended.err);
        assert!(ended.err.contains("target-cpu=x86-64-v3"), "{}", ended.err);
    }
    assert!(!told(&more, &format!("{run} -q")).err.contains("compiled"));
    assert!(!told(&["avx2", "fma"], run).err.contains("compiled"), "nothing is unused");
    let diagnosis = told(&more, "doctor").out;
    assert!(diagnosis.contains("compiled without bmi2, lzcnt"), "{diagnosis}");
    assert!(diagnosis.contains("to do: take the binary for x86-64-v3"), "{diagnosis}");
}

#[test]
fn misspelt_names_are_answered_with_the_right_ones() {
    for (arguments, meant) in [
        ("rnu tetra:1", "run"),
        ("run tetra:1 --round 3", "--rounds"),
        ("run terta", "tetra"),
        ("run sdp", "spd"),
        ("run tetra:1 -s octre", "octree"),
        ("run tetra:1 -s kd-tree:max-laef=3", "max-leaf"),
        ("run tetra:1 --rays shadwo", "shadow"),
        ("run tetra:1 --reference obvhs-cwbhv", "obvhs-cwbvh"),
        ("sweep tetra:1 -s uniform-grid -p densty --values 1", "density"),
        ("list structurs", "structures"),
        ("generate man mrege", "merge"),
        ("generate schema run-recrod", "run-record"),
        ("generate completions bsh", "bash"),
        ("accuracy triangel-test", "triangle-test"),
        ("accuracy --scene blals", "balls"),
        ("compare-tracers tetra:1 --tracers whited", "whitted"),
        ("compare-tracers tetra:1 --without sphere", "spheres"),
        ("render tetra:1 -o /dev/null.png --shadows light-bufer", "light-buffer"),
        ("verify --cases grdi", "grid"),
        ("verify -s octre", "octree"),
        ("reproduce havran1999 --scenes blals", "balls"),
        ("reproduce havran1999 --structures unifrom", "uniform"),
        ("reproduce zachmann2007 --scenes tere", "tree"),
        ("scenes info tetrra", "tetra"),
    ] {
        let ended = crate::common::run_with(
            accel_core::structures::REGISTRY,
            &measurement::scenes::InstalledScenes,
            &measurement::system::clock::SystemClock::default(),
            arguments,
        );
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        let quoted = ["'", "`"].map(|q| format!("{q}{meant}{q}"));
        let said = ended.err.contains("did you mean") || ended.err.contains("similar");
        let is_meant = quoted.iter().any(|q| ended.err.contains(q.as_str()));
        assert!(said && is_meant, "{arguments}: expected {meant}: {}", ended.err);
    }
}
