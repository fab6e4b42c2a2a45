//! `rtbench animate` end to end: rows, updates, exports, errors.

use accel_core::structures::REGISTRY;

use crate::common::{Ended, Folder, PLANTED, run_with};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

type Row = std::collections::HashMap<String, String>;

fn frames(folder: &Folder) -> Vec<Row> {
    csv::Reader::from_reader(folder.text("frames.csv").as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("CSV that parses back")
}

/// With all structures there are.
fn run(arguments: &str) -> Ended {
    run_with(REGISTRY, &InstalledScenes, &SystemClock::default(), arguments)
}

#[test]
fn rows_are_updated_from_frame_to_frame_and_right_in_each() {
    let folder = Folder::new();
    let rows = "uniform-grid,uniform-grid:update=incremental,wide-bvh:update=refit,\
                instanced-bvh:update=instances,recursive-grid";
    let ended = run(&format!(
        "animate city:1 --frames 0..4 -s {rows} --size 24 --rounds 2 -j 2 -o {}",
        folder.path()
    ));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let rows = frames(&folder);
    // five frames, five rows, one thread and two
    assert_eq!(rows.len(), 5 * 5 * 2);
    for row in &rows {
        assert_eq!((row["mismatches_of_all_frames"].as_str(), row["rounds"].as_str()), ("0", "2"));
        let number = |name: &str| row[name].parse::<f64>().unwrap_or(f64::NAN);
        assert!(number("update_s") > 0.0 && number("trace_s") > 0.0 && number("bytes") > 0.0);
        let is_first = row["frame"] == "0";
        assert_eq!(row["moved"].is_empty(), is_first);
        let is_updated = row["settings"].contains("update=") && !is_first;
        assert_eq!(row["updated"], if is_updated { "2" } else { "0" }, "{row:?}");
        // quality and counters are the same for any number of threads
        assert_eq!(row["n_it"].is_empty(), row["threads"] == "2");
    }
    assert!(ended.out.contains("has the most frames per second"), "{}", ended.out);
    assert!(ended.out.contains("anew and refitting (wide-bvh update=refit)"), "{}", ended.out);
    let svg = folder.text("animate.svg");
    assert!(roxmltree::Document::parse(&svg).is_ok() && svg.contains("city:1: update"));
    assert!(folder.text("animate.md").contains("frames 0 to 4"));
    let record: serde_json::Value =
        serde_json::from_str(&folder.text("animation.json")).expect("JSON");
    assert_eq!(record["complete"], true);
    let strip = std::fs::read(format!("{}/strip.png", folder.path())).unwrap();
    assert_eq!(&strip[..4], b"\x89PNG");
    // nothing is written over it
    let again = format!("animate city:1 --frames 0 --size 8 -o {}", folder.path());
    assert_eq!(run(&again).code, 1);
}

#[test]
fn every_update_method_is_the_default() {
    let folder = Folder::new();
    let ended =
        run(&format!("animate marbles:1 --frames 0..1 --quick --size 8 -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let rows = frames(&folder);
    let has = |structure: &str, settings: &str| {
        rows.iter().any(|row| row["structure"] == structure && row["settings"] == settings)
    };
    for (structure, settings) in [
        ("kd-tree", ""),
        ("wide-bvh", ""),
        ("wide-bvh", "update=refit"),
        ("obvhs-bvh2", "update=refit"),
        ("uniform-grid", "update=incremental"),
        ("hashed-grid", "update=incremental"),
        ("instanced-grid", "update=instances"),
    ] {
        assert!(has(structure, settings), "{structure} {settings}");
    }
    assert!(!has("brute-force", ""));
}

#[test]
fn a_wrong_row_is_wrong_and_never_fast() {
    let clock = SystemClock::default();
    let folder = Folder::new();
    let arguments = format!(
        "animate marbles:1 --frames 0..2 -s dropper,obvhs-cwbvh --size 16 --rounds 1 -o {}",
        folder.path()
    );
    let ended = run_with(&PLANTED, &InstalledScenes, &clock, &arguments);
    assert_eq!(ended.code, 4, "{}{}", ended.out, ended.err);
    for row in frames(&folder) {
        let is_planted = row["structure"] == "dropper";
        assert_eq!(row["update_s"].is_empty(), is_planted, "{row:?}");
        assert_eq!(row["mismatches_of_all_frames"] == "0", !is_planted);
    }
    assert!(ended.out.contains("dropper: frame 0: "), "{}", ended.out);
    assert!(ended.out.contains("obvhs-cwbvh has the most frames per second"), "{}", ended.out);
}

#[test]
fn invalid_animation_requests_are_errors_with_reasons() {
    for (arguments, code, said) in [
        ("marble", 2, "did you mean `marbles`?"),
        ("marbles:0", 2, "marbles"),
        ("marbles:1 --frames 3..99999", 2, "numbered from 0"),
        ("marbles:1 --frames 4..3", 2, "expected the first and the last frame"),
        ("marbles:1 --time-budget 3s", 2, "--time-budget"),
        ("marbles:1 -s unifrom-grid", 2, "did you mean 'uniform-grid'?"),
        ("marbles:1 -s kd-tree:update=refit", 2, "kd-tree has no parameter 'update'"),
        ("nowhere/frame%03d.obj", 1, "nowhere"),
    ] {
        let ended = run(&format!("animate {arguments}"));
        assert_eq!(ended.code, code, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
    }
}
