//! Scenes far from the origin, through commands: what is measured is as near it, what is shown is
//! far.

use std::fmt::Write;

use accel_core::structures::{Entry, REGISTRY};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

use crate::common::{Ended, Folder, run_with};

fn run(arguments: &str) -> Ended {
    let all: &[Entry] = REGISTRY;
    run_with(all, &InstalledScenes, &SystemClock::default(), arguments)
}

/// Boxes half a metre wide, their lower corners on a lattice, moved by whole metres.
fn boxes(x: i64, y: i64) -> String {
    let mut text = String::new();
    for i in 0..100i64 {
        let (left, front) = (x + 2 * (i % 10), y + 2 * (i / 10));
        for corner in 0..8 {
            let half = |bit: i64| if corner >> bit & 1 == 1 { "5" } else { "0" };
            writeln!(text, "v {left}.{} {front}.{} 0.{}", half(0), half(1), half(2)).unwrap();
        }
        for face in [
            "-8 -6 -5 -7",
            "-4 -3 -1 -2",
            "-8 -7 -3 -4",
            "-6 -2 -1 -5",
            "-8 -4 -2 -6",
            "-7 -5 -1 -3",
        ] {
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let corners: Vec<&str> = face.split(' ').collect();
                writeln!(text, "f {} {} {}", corners[a], corners[b], corners[c]).unwrap();
            }
        }
    }
    text
}

const FAR: (i64, i64) = (448_000, 5_411_000);

#[test]
fn every_counter_is_that_of_the_scene_near_the_origin() {
    let folder = Folder::new();
    let rows = "brute-force,uniform-grid,hashed-grid,octree,kd-tree,kay-kajiya,wide-bvh,obvhs-cwbvh:adapter=robust";
    let [near, far] = [(0, 0), FAR].map(|(x, y)| {
        let path = format!("{}/a.obj", folder.path());
        std::fs::write(&path, boxes(x, y)).unwrap();
        let out = format!("{}/{x}", folder.path());
        let ended = run(&format!(
            "run {path} -s {rows} --size 24 --rounds 1 --light {},{},30 -o {out}",
            x + 3,
            y - 4
        ));
        assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
        let record = std::fs::read_to_string(format!("{out}/results.json")).unwrap();
        serde_json::from_str::<measurement::record::RunRecord>(&record).unwrap()
    });
    let [near, far] = [&near.scenes[0], &far.scenes[0]];
    assert_eq!((near.origin, far.origin), (None, Some([448_000.0, 5_411_000.0, 0.0])));
    assert_eq!(near.rays, far.rays);
    assert_ne!(near.sha256, far.sha256);
    assert!(far.rows.len() >= 8);
    for (near, far) in near.rows.iter().zip(&far.rows) {
        assert_eq!(near.label(), far.label());
        assert_eq!((&near.stats, &near.work), (&far.stats, &far.work), "{}", far.label());
        assert!(
            far.mismatches == 0 && far.answers_sha256 == near.answers_sha256,
            "{}",
            far.label()
        );
    }
}

#[test]
fn pictures_and_rays_are_in_the_coordinates_of_the_file() {
    let folder = Folder::new();
    let path = format!("{}/a.obj", folder.path());
    std::fs::write(&path, boxes(FAR.0, FAR.1)).unwrap();
    let picture = format!("{}/a.svg", folder.path());
    let ended = run(&format!("show {path} -s uniform-grid --slice x=448004.25 -o {picture}"));
    assert_eq!((ended.code, ended.err.contains("f32")), (0, false), "{}", ended.err);
    let svg = std::fs::read_to_string(&picture).unwrap();
    assert!(svg.contains("x = 448004.25"), "the slice is named");
    // from above onto the box whose lower corner is at (4, 6): its top is half a metre high
    let ended =
        run(&format!("show {path} -s kd-tree --ray 448004.25,5411006.2,9.5:448004.25,5411006.2,0"));
    assert!(ended.out.contains("parameter of the ray: 9;"), "{}", ended.out);
    let ended = run(&format!("scenes info {path}"));
    assert!(
        ended.out.contains("[448000, 5411000, 0] to [448018.5, 5411018.5, 0.5]"),
        "{}",
        ended.out
    );
    assert!(ended.out.contains("shift       by [-448000, -5411000, 0]"), "{}", ended.out);
}

#[test]
fn f64_answers_scenes_that_no_shift_of_the_origin_helps() {
    let folder = Folder::new();
    let path = format!("{}/a.obj", folder.path());
    let outlier = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n";
    std::fs::write(&path, boxes(FAR.0, FAR.1) + outlier).unwrap();
    let view =
        "--camera 448009,5410970,30:448009,5411009,0:30 --up 0,0,1 --light 448009,5410990,50";
    let [single, double] = ["f32", "f64"].map(|precision| {
        run(&format!(
            "run {path} -s uniform-grid,kd-tree,wide-bvh --precision {precision} --size 24 --rounds 1 {view}"
        ))
    });
    let says =
        "primitives are smaller than the padding of boxes in f32: coordinates are up to 54110";
    assert_eq!(single.err.matches(says).count(), 1, "{}", single.err);
    assert!(single.err.contains("--precision f64"), "{}", single.err);
    assert_eq!(double.code, 0, "{}{}", double.out, double.err);
    let is_wrong = double.out.lines().any(|line| line.ends_with("wrong"));
    assert!(!double.err.contains("f32") && !is_wrong, "{}", double.err);
}
