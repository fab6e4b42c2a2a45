//! Sequences of files.

use std::path::Path;

use glam::DVec3;
use scene_loading::LoadError;
use scene_loading::animation::open;

/// A folder with a triangle file of each name, moved along x by its place in the list.
fn folder(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (i, name) in names.iter().enumerate() {
        let text = if name.ends_with(".ply") {
            format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                 property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                 end_header\n{i} 0 0\n{} 0 0\n{i} 1 0\n3 0 1 2\n",
                i + 1
            )
        } else {
            format!("v {i} 0 0\nv {} 0 0\nv {i} 1 0\n{}", i + 1, "f 1 2 3\n".repeat(i + 1))
        };
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn named(folder: &Path, pattern: &str) -> String {
    folder.join(pattern).to_str().unwrap().to_owned()
}

#[test]
fn frames_are_files_in_the_order_of_their_numbers() {
    let names = ["w008.obj", "w009.obj", "w010.obj", "w11.obj", "w0011.obj", "v011.obj", "w12.ply"];
    let folder = folder(&names);
    let mut animation = open(&named(folder.path(), "w%03d.obj")).unwrap();
    assert_eq!((animation.name(), animation.frames()), ("w%03d", 3));
    // the last first: the camera is that of the first all the same
    let last = animation.frame(2).unwrap();
    let first = animation.frame(0).unwrap();
    assert_eq!((first.primitives.len(), last.primitives.len()), (1, 3));
    assert_eq!((first.vertices[0], last.vertices[0]), (DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0)));
    assert_eq!((first.camera, first.lights.clone()), (last.camera, last.lights));
    assert_eq!((first.name.as_str(), first.lights.len()), ("w%03d", 1));
    let error = animation.frame(3).unwrap_err();
    assert!(matches!(error, LoadError::IndexOutOfRange { .. }), "{error}");
}

#[test]
fn numbers_without_zeros_and_other_endings() {
    let folder = folder(&["9.ply", "10.ply", "11.ply", "009.ply", "a.ply", "99999999999.ply"]);
    let mut animation = open(&named(folder.path(), "%d.ply")).unwrap();
    assert_eq!(animation.frames(), 3);
    assert_eq!(animation.frame(1).unwrap().vertices[0].x, 1.0);
}

#[test]
fn missing_frames_are_named() {
    let folder = folder(&["a1.obj", "a2.obj", "a5.obj"]);
    let error = open(&named(folder.path(), "a%d.obj")).err().unwrap();
    assert!(matches!(error, LoadError::MissingFrame { .. }));
    let text = error.to_string();
    assert!(text.contains("a3.obj is missing") && text.contains("a5.obj exists"), "{text}");
}

#[test]
fn invalid_sequences_are_errors() {
    let folder = folder(&["a1.obj", "a2.txt"]);
    let error = |pattern: &str| open(&named(folder.path(), pattern)).err().unwrap();
    assert!(matches!(error("b%d.obj"), LoadError::NoFrames { .. }));
    assert!(matches!(error("a%d.txt"), LoadError::UnknownFormat { .. }));
    assert!(matches!(error("no/a%d.obj"), LoadError::Io { .. }));
    for bad in ["a%s.obj", "a%d%d.obj", "a%4d.obj", "a%010d.obj", "a%.obj", "a.obj"] {
        assert!(matches!(error(bad), LoadError::UnknownScene { .. }), "{bad}");
    }
    // a broken frame is the loader's error
    std::fs::write(folder.path().join("a2.obj"), "v 0 0 x\n").unwrap();
    let mut animation = open(&named(folder.path(), "a%d.obj")).unwrap();
    assert!(animation.frame(0).is_ok());
    let text = animation.frame(1).unwrap_err().to_string();
    assert!(text.contains("a2.obj:1"), "{text}");
}
