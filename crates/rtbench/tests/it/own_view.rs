//! Scenes without lights, and a camera and lights from the command line: what is measured, recorded
//! and repeated.

use crate::common::{Folder, run_stepping};

/// A folder with an OBJ file without camera and lights; its path.
fn plate() -> (Folder, String) {
    let folder = Folder::new();
    let path = format!("{}/plate.obj", folder.path());
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n").unwrap();
    (folder, path)
}

const OPTIONS: &str = "--quick --size 16 --rounds 1 -s uniform-grid,brute-force";

#[test]
fn a_scene_without_camera_and_lights_is_lit_and_says_so() {
    let (folder, plate) = plate();
    let out = Folder::new();
    let ended = run_stepping(&format!("run {plate} {OPTIONS} -o {}/run", out.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.contains("no lights: added one at the eye"), "{}", ended.err);
    let record = out.text("run/results.json");
    let record: measurement::record::RunRecord = serde_json::from_str(&record).unwrap();
    assert!(record.settings.view.is_empty());
    assert!(record.scenes[0].rays["shadow"] > 0 && record.scenes[0].rays["primary"] > 0);
    let image = format!("{}/a.png", folder.path());
    let ended = run_stepping(&format!("render {plate} --size 8 -j 1 -o {image}"));
    assert!(ended.code == 0 && ended.err.contains("no lights"), "{}", ended.err);
    let lit = std::fs::read(&image).unwrap();
    let ended = run_stepping(&format!(
        "render {plate} --size 8 -j 1 --light 0,0,-9 -o {image} --overwrite"
    ));
    assert!(ended.code == 0 && !ended.err.contains("no lights"), "{}", ended.err);
    assert_ne!(lit, std::fs::read(&image).unwrap(), "a light behind it shows nothing");
}

#[test]
fn given_views_are_recorded_repeated_and_compared() {
    let (_folder, plate) = plate();
    let out = Folder::new();
    let path = |name: &str| format!("{}/{name}", out.path());
    let view = "--camera 0.5,0.5,4:0.5,0.5,0:30 --up=0,-1,0 --light -1,2,3:1,0.5,0 --light 4,5,6";
    let ended = run_stepping(&format!("run {plate} {OPTIONS} {view} -o {}", path("one")));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let record: measurement::record::RunRecord =
        serde_json::from_str(&out.text("one/results.json")).unwrap();
    let expected =
        "--camera=0.5,0.5,4:0.5,0.5,0:30 --up=0,-1,0 --light=-1,2,3:1,0.5,0 --light=4,5,6";
    assert_eq!(record.settings.view.to_string(), expected);
    // the same scene is loaded when the run is resumed, and another one is refused
    let again = run_stepping(&format!("run --resume {}", path("one")));
    assert_eq!(again.code, 0, "{}", again.err);
    let other = run_stepping(&format!("run --resume {} --light 7,8,9", path("one")));
    assert!(other.code != 0 && other.err.contains("settings.view"), "{}", other.err);
    let plain = run_stepping(&format!("run {plate} {OPTIONS} -o {}", path("two")));
    assert_eq!(plain.code, 0, "{}", plain.err);
    let compared = run_stepping(&format!("compare {} {}", path("one"), path("two")));
    let said = compared.out + &compared.err;
    assert!(said.contains("view: --camera=0.5,0.5,4"), "{said}");
}

#[test]
fn invalid_views_are_usage_errors() {
    for (arguments, said) in [
        ("--camera 1,2,3", "FROM:AT"),
        ("--camera 1,2,3:1,2,3", "same point"),
        ("--camera 1,2,3:0,0,0:200", "180"),
        ("--up 0,0,0", "0,0,0"),
        ("--light 1,2", "X,Y,Z"),
        ("--light 1,2,3:1", "X,Y,Z"),
    ] {
        let ended = run_stepping(&format!("run tetra:1 {arguments}"));
        assert!(ended.code == 2 && ended.err.contains(said), "{arguments}: {}", ended.err);
    }
    let ended = run_stepping("scenes info tetra:1 --camera 0,5,0:0,0,0 --up 0,1,0");
    assert!(ended.code == 1 && ended.err.contains("camera `up`"), "{}", ended.err);
}
