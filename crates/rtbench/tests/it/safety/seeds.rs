//! The fixed inputs of the fuzz targets that go through this program, once each.

use std::path::{Path, PathBuf};

use accel_core::memory::MemoryLimit;
use accel_core::occluders;
use accel_core::structures::{REGISTRY, find};
use measurement::plan::measured_row::select;
use renderer::effects::{EffectPlan, RenderSettings};
use renderer::{Geometry, render_plan};
use scene_loading::scene_file::{SceneFile, Source};

use crate::common::{Folder, run};

/// The inputs of a target.
fn seeds(target: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds").join(target);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{target}");
    files
}

/// Every reader of a record ends, with a result or with an error.
#[test]
fn records() {
    for seed in seeds("records") {
        let seed = seed.display();
        for command in [
            format!("compare {seed} {seed} -m all --force"),
            format!("report {seed} -o -"),
            format!("merge {seed} {seed}"),
        ] {
            let ended = run(&command);
            assert!(ended.code <= 1 && !ended.err.contains("panic"), "{command}: {}", ended.err);
            assert!(ended.code == 0 || !ended.err.is_empty(), "{command}");
        }
    }
}

/// The first byte of each says which file it stands for.
#[test]
fn files_beside_a_record() {
    const FILES: [&str; 4] = [
        "havran1999.csv",
        "zachmann2007.csv",
        "accuracy/accuracy.json",
        "tracers/scene/tracers.json",
    ];
    for seed in seeds("beside") {
        let bytes = std::fs::read(&seed).unwrap();
        let (first, text) = bytes.split_first().unwrap();
        let folder = Folder::new();
        let file = Path::new(&folder.path()).join(FILES[usize::from(*first) % FILES.len()]);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(&file, text).unwrap();
        let record = include_bytes!("../../../../../fuzz/seeds/records/one-row.json");
        std::fs::write(format!("{}/results.json", folder.path()), record).unwrap();
        let ended = run(&format!("report {} -o -", folder.path()));
        assert!(ended.code <= 1 && !ended.err.contains("panic"), "{seed:?}: {}", ended.err);
    }
}

/// A picture of each, of few pixels, with every effect that it calls for.
#[test]
fn effects() {
    let path = Path::new("a.json");
    let mut drawn = 0;
    for seed in seeds("effects") {
        let text = String::from_utf8_lossy(&std::fs::read(&seed).unwrap()).into_owned();
        let Ok(file) = SceneFile::parse(path, &text) else { continue };
        let Source::Shapes(shapes) = &file.source else { continue };
        let Ok(mut scene) = file.inline(path, shapes) else { continue };
        if file.apply(path, &mut scene).is_err() {
            continue;
        }
        let plan = EffectPlan::of(&scene, &RenderSettings::default()).at([2, 2]);
        let Ok(geometry) = Geometry::<f32>::of(&scene) else { continue };
        let entry = find("brute-force").unwrap();
        let Ok(tracer) = entry.build(geometry.prims(), &entry.params([]).unwrap()) else {
            continue;
        };
        let image = render_plan(&scene, &*tracer, &plan).image;
        assert_eq!(image.pixels.len(), 4, "{seed:?}");
        drawn += 1;
    }
    assert!(drawn >= 2, "{drawn}");
}

/// Rows as behind `-s` in the first line, `--set` in the others: each is built in little memory, or
/// refused.
#[test]
fn settings() {
    let scene = scene_loading::nff::parse_nff(
        "a.nff".as_ref(),
        "p 3\n-2 -2 0\n2 -2 0\n0 3 0\ns 0.3 0.2 2 0.5\n",
    );
    let geometry = Geometry::<f32>::of(&scene.unwrap()).unwrap();
    let limit = MemoryLimit::new(8 << 20);
    let mut built = 0;
    for seed in seeds("settings") {
        let text = String::from_utf8_lossy(&std::fs::read(&seed).unwrap()).into_owned();
        let (rows, overrides) = text.split_once('\n').unwrap_or((&text, ""));
        let overrides: Vec<String> = overrides.lines().map(str::to_owned).collect();
        let rows = select(REGISTRY, occluders::REGISTRY, &[rows.to_owned()], &overrides);
        for row in rows.into_iter().flat_map(|(structures, _)| structures) {
            built += usize::from(
                row.entry.build(geometry.prims(), &row.params.clone().within(limit)).is_ok(),
            );
        }
    }
    assert!(built > 2, "{built}");
}
