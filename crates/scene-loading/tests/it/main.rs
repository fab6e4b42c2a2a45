//! All integration tests of the crate, as one program: each more would be linked on its own.

mod animation;
mod far_scenes;
mod fuzz_seeds;
mod gltf_file;
mod gltf_leniency;
mod gltf_pose;
mod hard_cases;
mod hostile;
mod load_catalogue;
mod load_damaged;
mod load_effects;
mod load_gltf;
mod load_meshes;
mod load_nff;
mod load_obj;
mod load_pbrt;
mod load_textures;
mod nff_text;
mod procedural;
mod view;

use std::path::{Path, PathBuf};

use scene_loading::second_opinion::{SecondOpinion, second_opinion};
use scene_loading::source::formats::{ReadOptions, load_scene};
use scene_loading::{LoadError, Scene, SceneCatalogue, SceneRef, Shape};

/// The scene of a file.
fn load(path: &Path) -> Result<Scene, LoadError> {
    load_scene(path, ReadOptions::default())
}

/// A file by its path, as the catalogue finds it.
fn resolved(path: &Path) -> Result<SceneRef, LoadError> {
    let names = [path.to_str().unwrap().to_owned()];
    Ok(SceneCatalogue::embedded()?.resolve(&names)?.remove(0))
}

/// A folder with these files, named by their paths in it. It lasts as long as the first value.
fn folder<T: AsRef<[u8]>>(files: &[(&str, T)]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_path_buf();
    for (name, bytes) in files {
        let file = path.join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, bytes).unwrap();
    }
    (folder, path)
}

/// The triangles that another reader counts, and how it differs.
fn asked(path: &Path, bytes: Vec<u8>) -> (u64, Vec<String>) {
    let opinion = second_opinion(path, bytes).unwrap();
    let SecondOpinion::Asked { triangles, differences, .. } = opinion else {
        panic!("{opinion:?}");
    };
    (triangles, differences)
}

/// Breaks a text by a replacement, each time another one: the error must begin with the file and
/// place, and have a part.
fn check_faults(
    text: &str,
    file: &str,
    parse: impl Fn(&str) -> Result<Scene, LoadError>,
    faults: &[(&str, &str, &str, &str)],
) {
    for (from, to, place, part) in faults {
        assert!(text.contains(from), "{from}: {text}");
        let error = parse(&text.replacen(from, to, 1)).expect_err(to).to_string();
        let is_at = error.starts_with(&format!("{file}{place}"));
        assert!(is_at && error.contains(part), "{from} -> {to}: {error}");
    }
}

/// The texts of its warnings, without the folder of files that are in memory alone.
fn warnings(scene: &Scene) -> Vec<String> {
    scene.warnings.iter().map(|w| w.0.replace("no-such-folder/", "")).collect()
}

/// The only warning of a scene.
fn warning(scene: &Scene) -> &str {
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    &warning.0
}

fn shapes(scene: &Scene) -> Vec<Shape> {
    scene.primitives.iter().map(|p| p.shape).collect()
}

/// The corners of a scene of triangles without normals.
fn triangles(scene: &Scene) -> Vec<[u32; 3]> {
    let of = |shape: Shape| match shape {
        Shape::Triangle { v } => v,
        other => panic!("{other:?}"),
    };
    scene.primitives.iter().map(|p| of(p.shape)).collect()
}
