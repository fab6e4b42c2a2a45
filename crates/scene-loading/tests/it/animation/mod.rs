//! Scenes that move. Sequences of files; generated animations: counts, the same on every run and in
//! any order, rigid where they say so.

mod aff;
mod gltf;

use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};
use scene_loading::animation::{ANIMATED, Animation, open};
use scene_loading::source_hash::sha256_of_scene;
use scene_loading::{Instance, LoadError, Scene};

use crate::folder;

/// The corners of an instance, brought elsewhere.
fn corners(scene: &Scene, instance: &Instance, by: DAffine3) -> Vec<DVec3> {
    let ids = instance.first as usize..(instance.first + instance.count) as usize;
    let all = scene.primitives[ids].iter().flat_map(|p| scene.outline(p.shape));
    all.map(|v| by.transform_point3(v)).collect()
}

/// How far apart two lists of corners are at most.
fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// The greatest distance between where a corner is in the second frame and where the claims of both
/// say that it is, and between copies of an object.
fn claim_error(first: &Scene, other: &Scene) -> f64 {
    assert_eq!(first.instances.len(), other.instances.len());
    let mut worst: f64 = 0.0;
    for (a, b) in first.instances.iter().zip(&other.instances) {
        assert_eq!((a.object, a.first, a.count), (b.object, b.first, b.count));
        let moved = corners(first, a, b.placement * a.placement.inverse());
        worst = worst.max(apart(&moved, &corners(other, b, DAffine3::IDENTITY)));
        let model = other.instances.iter().find(|i| i.object == b.object).unwrap();
        assert_eq!(model.count, b.count);
        let of_model = corners(other, model, b.placement * model.placement.inverse());
        worst = worst.max(apart(&of_model, &corners(other, b, DAffine3::IDENTITY)));
    }
    worst
}

/// How many primitives are part of an instance; none is part of two.
fn claimed(scene: &Scene) -> usize {
    let mut ids: Vec<u32> =
        scene.instances.iter().flat_map(|i| i.first..i.first + i.count).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count);
    count
}

/// A folder with a triangle file of each name, moved along x by its place in the list.
fn sequence(names: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let text = |i: usize| {
        if names[i].ends_with(".ply") {
            format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                 property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                 end_header\n{i} 0 0\n{} 0 0\n{i} 1 0\n3 0 1 2\n",
                i + 1
            )
        } else {
            format!("v {i} 0 0\nv {} 0 0\nv {i} 1 0\n{}", i + 1, "f 1 2 3\n".repeat(i + 1))
        }
    };
    let files: Vec<_> = (0..names.len()).map(|i| (names[i], text(i))).collect();
    folder(&files)
}

fn opened(folder: &Path, pattern: &str) -> Result<Animation, LoadError> {
    open(folder.join(pattern).to_str().unwrap())
}

#[test]
fn frames_are_files_in_the_order_of_their_numbers() {
    let names = ["w008.obj", "w009.obj", "w010.obj", "w11.obj", "w0011.obj", "v011.obj", "w12.ply"];
    let (_folder, path) = sequence(&names);
    let mut animation = opened(&path, "w%03d.obj").unwrap();
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
    let (_folder, path) =
        sequence(&["9.ply", "10.ply", "11.ply", "009.ply", "a.ply", "99999999999.ply"]);
    let mut animation = opened(&path, "%d.ply").unwrap();
    assert_eq!(animation.frames(), 3);
    assert_eq!(animation.frame(1).unwrap().vertices[0].x, 1.0);
}

#[test]
fn missing_frames_are_named() {
    let (_folder, path) = sequence(&["a1.obj", "a2.obj", "a5.obj"]);
    let error = opened(&path, "a%d.obj").err().unwrap();
    assert!(matches!(error, LoadError::MissingFrame { .. }));
    let text = error.to_string();
    assert!(text.contains("a3.obj is missing") && text.contains("a5.obj exists"), "{text}");
}

#[test]
fn invalid_sequences_are_errors() {
    let (_folder, path) = sequence(&["a1.obj", "a2.txt"]);
    let error = |pattern: &str| opened(&path, pattern).err().unwrap();
    assert!(matches!(error("b%d.obj"), LoadError::NoFrames { .. }));
    assert!(matches!(error("a%d.txt"), LoadError::UnknownFormat { .. }));
    assert!(matches!(error("no/a%d.obj"), LoadError::Io { .. }));
    for bad in ["a%s.obj", "a%d%d.obj", "a%4d.obj", "a%010d.obj", "a%.obj", "a.obj"] {
        assert!(matches!(error(bad), LoadError::UnknownScene { .. }), "{bad}");
    }
    // a broken frame is the loader's error
    std::fs::write(path.join("a2.obj"), "v 0 0 x\n").unwrap();
    let mut animation = opened(&path, "a%d.obj").unwrap();
    assert!(animation.frame(0).is_ok());
    let text = animation.frame(1).unwrap_err().to_string();
    assert!(text.contains("a2.obj:1"), "{text}");
}

/// Those in which nothing is rigid.
const SOFT: [&str; 2] = ["cloth", "particles"];

fn frame(name: &str, index: u32) -> Scene {
    open(name).unwrap().frame(index).unwrap()
}

#[test]
fn counts_are_what_is_generated() {
    for entry in ANIMATED {
        for size in [1, 2, 3, entry.default_size] {
            let mut animation = (entry.open)(size);
            assert_eq!(animation.frames(), entry.frames);
            for index in [0, 3] {
                let scene = animation.frame(index).unwrap();
                assert_eq!(scene.primitives.len() as u64, (entry.count)(size), "{}", entry.name);
                assert!(scene.is_triangles_only() && !scene.lights.is_empty());
                assert_eq!(scene.name, animation.name());
            }
        }
        let usual = (entry.count)(entry.default_size);
        assert!((9_000..=180_000).contains(&usual), "{}: {usual}", entry.name);
        let [most, more] = [0, 1].map(|more| (entry.count)(entry.max_size + more));
        assert!(most < 20_000_000 && more > 19_900_000, "{}: {most} {more}", entry.name);
        assert!((20..=60).contains(&entry.frames));
    }
    assert!(ANIMATED.windows(2).all(|pair| pair[0].name < pair[1].name));
}

#[test]
fn frames_are_the_same_in_any_order() {
    for entry in ANIMATED {
        let name = format!("{}:3", entry.name);
        let mut forward = open(&name).unwrap();
        let hashes: Vec<String> =
            (0..8).map(|i| sha256_of_scene(&forward.frame(i).unwrap())).collect();
        for index in [7, 2, 5, 0] {
            assert_eq!(sha256_of_scene(&forward.frame(index).unwrap()), hashes[index as usize]);
            assert_eq!(sha256_of_scene(&frame(&name, index)), hashes[index as usize], "{name}");
        }
        assert_ne!(hashes[0], hashes[7], "{name} stands still");
    }
}

#[test]
fn claimed_rigid_motions_are_rigid() {
    for entry in ANIMATED {
        let mut animation = open(&format!("{}:4", entry.name)).unwrap();
        let first = animation.frame(0).unwrap();
        if SOFT.contains(&entry.name) {
            assert!(first.instances.is_empty());
            continue;
        }
        assert_eq!(claimed(&first), first.primitives.len(), "{}", entry.name);
        for index in 1..entry.frames {
            let scene = animation.frame(index).unwrap();
            let error = claim_error(&first, &scene);
            assert!(error < 1e-12, "{} {index}: {error}", entry.name);
        }
        // planted fault: a part that is not where it is said to be
        let mut bad = animation.frame(5).unwrap();
        bad.instances.last_mut().unwrap().placement.translation.x += 1e-9;
        assert!(claim_error(&first, &bad) > 1e-10, "{}", entry.name);
    }
}

#[test]
fn static_parts_stay_and_little_of_the_city_moves() {
    let mut city = open("city").unwrap();
    let [a, b] = [0, 30].map(|i| city.frame(i).unwrap());
    let corners = |scene: &Scene, id: usize| scene.outline(scene.primitives[id].shape);
    let moves = (0..a.primitives.len()).filter(|&id| corners(&a, id) != corners(&b, id)).count();
    assert!(moves > 0 && moves * 100 < a.primitives.len(), "{moves} of {}", a.primitives.len());
}

#[test]
fn the_wall_is_whole_before_it_is_hit_and_spreads() {
    let mut wall = open("wall:20").unwrap();
    let reach = |scene: &Scene| {
        // without the ground
        let bricks = scene.vertices[4..].iter().fold(DVec3::ZERO, |most, v| most.max(v.abs()));
        [bricks.y, scene.vertices[4..].iter().map(|v| v.z).fold(f64::INFINITY, f64::min)]
    };
    let reaches: Vec<[f64; 2]> = (0..50).map(|i| reach(&wall.frame(i).unwrap())).collect();
    assert!(reaches[0][0] < 0.06 && reaches[49][0] > 1.0, "{reaches:?}");
    assert!(reaches[0][1] > 0.0, "{reaches:?}");
    let landed = wall.frame(49).unwrap();
    let below = landed.vertices.iter().filter(|v| v.z < -1e-9).count();
    assert_eq!(below, 0, "{:?}", landed.bounds());
}

#[test]
fn unknown_names_and_sizes_are_errors() {
    let error = open("marbels").err().unwrap();
    assert!(matches!(error, LoadError::UnknownScene { .. }));
    let text = error.to_string();
    assert!(text.contains("did you mean `marbles`") && text.contains("walker"), "{text}");
    for bad in ["marbles:0", "marbles:x", "marbles:", "cloth:791", "wall:4294967296"] {
        let error = open(bad).err().unwrap();
        assert!(matches!(error, LoadError::Procedural { .. }), "{bad}: {error}");
    }
    assert_eq!(open("marbles:7").unwrap().name(), "marbles:7");
    assert_eq!(open("marbles:110").unwrap().name(), "marbles");
    let error = open("cloth:2").unwrap().frame(50).unwrap_err().to_string();
    assert_eq!(error, "cloth:2: frame index 50 is out of range: there are 50, counted from 0");
}
