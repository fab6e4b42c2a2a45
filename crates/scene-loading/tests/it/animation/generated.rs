//! Generated animations: counts, the same on every run and in any order, rigid where they say so.

use glam::DVec3;
use scene_loading::animation::{ANIMATED, open};
use scene_loading::source_hash::sha256_of_scene;
use scene_loading::{LoadError, Scene};

use super::{claim_error, claimed};

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
