//! The fixed inputs of the fuzz targets (`fuzz/seeds`), once each: those that a fuzzer starts from,
//! and those that it found.

use std::path::{Path, PathBuf};

use glam::DVec3;
use scene_loading::animation;
use scene_loading::gltf::parse_gltf;
use scene_loading::info::{SceneInfo, validate};
use scene_loading::nff::parse_nff;
use scene_loading::obj::{ObjOptions, parse_materials, parse_obj};
use scene_loading::pbrt::parse_pbrt;
use scene_loading::ply::parse_ply;
use scene_loading::scene_file::{SceneFile, Source};
use scene_loading::source::formats::{ReadOptions, parse_scene};
use scene_loading::stl::parse_stl;
use scene_loading::tessellate::triangulate;
use scene_loading::tray_racing::parse_tray_racing;
use scene_loading::triangle_soup::parse_triangle_soup;
use scene_loading::{FilePlace, LoadError, Scene};

/// The inputs of a target.
fn seeds(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds").join(target);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{target}");
    files.into_iter().map(|file| (file.clone(), std::fs::read(&file).unwrap())).collect()
}

/// How many load; an error must name the file and be no panic.
fn replay(target: &str, parse: impl Fn(&Path, Vec<u8>) -> Result<Scene, LoadError>) -> usize {
    let mut loaded = 0;
    for (file, bytes) in seeds(target) {
        match parse(Path::new("a.x"), bytes) {
            Ok(scene) => {
                loaded += 1;
                let _ = validate(&scene);
                let _ = SceneInfo::of(&scene).to_string();
            }
            Err(error) => {
                let text = error.to_string();
                let is_good = text.starts_with("a.x") && !text.contains("panic");
                assert!(is_good, "{}: {text}", file.display());
            }
        }
    }
    loaded
}

#[test]
fn obj() {
    for triangulate in [false, true] {
        let options = ObjOptions { triangulate };
        assert!(replay("obj", |path, bytes| parse_obj(path, bytes, options)) >= 4);
    }
}

#[test]
fn mtl() {
    let parse = |path: &Path, bytes| {
        parse_materials(path, bytes).map(|materials| Scene { materials, ..Scene::default() })
    };
    assert!(replay("mtl", parse) >= 2);
}

#[test]
fn gltf() {
    assert!(replay("gltf", |path, bytes| parse_gltf(path, &bytes)) >= 11);
}

/// The last frame of an animation, which a file with that ending holds.
fn last_frame(ending: &str, bytes: Vec<u8>) -> Result<Scene, LoadError> {
    let mut animation = animation::parse(Path::new(&format!("a.x.{ending}")), bytes)?;
    animation.frame(animation.frames() - 1)
}

#[test]
fn moving_gltf() {
    assert!(replay("moving_gltf", |_, bytes| last_frame("gltf", bytes)) >= 4);
}

#[test]
fn moving_aff() {
    assert!(replay("moving_aff", |_, bytes| last_frame("aff", bytes)) >= 3);
}

#[test]
fn nff() {
    let parse = |path: &Path, bytes: Vec<u8>| parse_nff(path, &String::from_utf8_lossy(&bytes));
    assert!(replay("nff", parse) >= 1);
}

#[test]
fn ply() {
    for triangulate in [false, true] {
        assert!(replay("ply", |path, bytes| parse_ply(path, &bytes, triangulate)) >= 3);
    }
}

#[test]
fn stl() {
    assert!(replay("stl", parse_stl) >= 3);
}

#[test]
fn triangle_soup() {
    assert!(replay("triangle_soup", |path, bytes| parse_triangle_soup(path, &bytes)) >= 1);
}

#[test]
fn pbrt() {
    for triangulate in [false, true] {
        let parse = |path: &Path, bytes: Vec<u8>| match parse_pbrt(path, bytes, triangulate) {
            // of a file that another names
            Err(LoadError::Io { .. }) => {
                Err(LoadError::NoPrimitives { place: FilePlace::file(path), expected: "file" })
            }
            other => other,
        };
        assert!(replay("pbrt", parse) >= 1);
    }
}

#[test]
fn tray_racing() {
    // no model is there
    let parse =
        |path: &Path, bytes| parse_tray_racing(path, bytes, false, |_| Ok(Scene::default()));
    assert_eq!(replay("tray_racing", parse), 0);
}

#[test]
fn packed() {
    let parse = |_: &Path, bytes: Vec<u8>| {
        let ending = if bytes.starts_with(&[0x1f]) { "gz" } else { "zst" };
        parse_scene(Path::new(&format!("a.x.obj.{ending}")), bytes, ReadOptions::default())
    };
    assert!(replay("packed", parse) >= 2);
}

#[test]
fn polygon() {
    for (file, bytes) in seeds("polygon") {
        let corners = bytes.as_chunks().0.iter().map(|&[x, y]| [f64::from(x), f64::from(y)]);
        let outline: Vec<DVec3> = corners.map(|[x, y]| DVec3::new(x, y, 0.1 * x)).collect();
        let triangles = triangulate(&outline).unwrap();
        assert!(triangles.len() <= outline.len() - 2, "{}", file.display());
        assert!(triangles.iter().all(|[a, b, c]| a != b && b != c && c != a));
    }
}

#[test]
fn scene_file() {
    let path = Path::new("a.json");
    let mut loaded = 0;
    for (_, bytes) in seeds("scene_file") {
        let Ok(file) = SceneFile::parse(path, &String::from_utf8_lossy(&bytes)) else { continue };
        let Source::Shapes(shapes) = &file.source else { continue };
        let Ok(mut scene) = file.inline(path, shapes) else { continue };
        loaded += usize::from(file.apply(path, &mut scene).is_ok());
    }
    assert!(loaded >= 2);
}
