//! What scene files say of effects, and what they must not say.

use std::path::Path;

use glam::DVec3;
use scene_loading::scene_file::SceneFile;
use scene_loading::{LoadError, Scene};

/// A scene file with these parts, each on a line of its own from line 4 on.
fn json(parts: &[&str]) -> String {
    let mut lines = vec!["{", r#""name": "a", "title": "t","#, r#""why": "w","#];
    lines.extend(parts);
    lines.join("\n") + "}"
}

const BALL: &str = r#""materials": {"m": {}}, "source": {"shapes": [
{"sphere": {"center": [0, 0, 0], "radius": 1, "material": "m"}}]}"#;

fn load(parts: &[&str]) -> Result<Scene, LoadError> {
    let (_folder, path) = crate::folder(&[("a.json", json(parts))]);
    Ok(crate::resolved(&path.join("a.json"))?.load()?.scene)
}

#[test]
fn shapes_materials_lights_and_motion_come_from_the_file() {
    let scene = load(&[
        r#""source": {"shapes": ["#,
        r#"{"sphere": {"center": [0, 1, 0], "radius": 1, "material": "b", "velocity": [1, 0, 0]}},"#,
        r#"{"cone": {"base": [0,0,0], "base_radius": 1, "apex": [0,1,0], "apex_radius": 0, "material": "a"}},"#,
        r#"{"polygon": {"vertices": [[0,0,0],[1,0,0],[0,1,0]], "material": "a"}}]},"#,
        r#""materials": {"a": {"specular": 0.5, "roughness": 0.25}, "b": {}},"#,
        r#""motion": [{"material": "a", "velocity": [0, 2, 0]}],"#,
        r#""camera": {"from": [0,0,9], "at": [0,0,0], "up": [0,1,0], "angle": 40,"#,
        r#"  "aperture": 0.5, "focal_distance": 8, "shutter": 2},"#,
        r#""lights": [{"position": [1,2,3], "radius": 0.5}, {"position": [1,2,3], "radius": 0}],"#,
        r#""effects": {"shadow": 7}"#,
    ])
    .unwrap();
    assert_eq!(scene.primitives.len(), 3);
    assert_eq!(scene.materials[scene.primitives[0].material as usize].name, "b");
    assert_eq!(scene.materials[0].roughness, 0.25);
    let velocities: Vec<DVec3> = (0..4).map(|id| scene.velocity(id)).collect();
    assert_eq!(velocities, [DVec3::X, DVec3::Y * 2.0, DVec3::Y * 2.0, DVec3::ZERO]);
    assert_eq!(scene.lights.iter().map(|l| l.radius).collect::<Vec<_>>(), [0.5, 0.0]);
    let camera = scene.camera;
    assert_eq!((camera.aperture, camera.focal_distance, camera.shutter), (0.5, Some(8.0), 2.0));
    assert_eq!((scene.samples.shadow, scene.samples.focal), (Some(7), None));
    // the ball's way counts: it starts at 0 and ends at 2
    assert_eq!((scene.bounds().min.x, scene.bounds().max.x), (-1.0, 3.0));
}

#[test]
fn bad_values_are_errors_that_name_file_and_line() {
    let camera = |more: &str| {
        format!(
            r#","camera": {{"from": [0,0,9], "at": [0,0,0], "up": [0,1,0], "angle": 40, {more}}}"#
        )
    };
    let cases = [
        (r#","lights": [{"position": [0,0,0], "radius": -1}]"#.to_owned(), "at least 0"),
        (r#","lights": [{"position": [0,0,0], "radius": NaN}]"#.to_owned(), "expected value"),
        (r#","lights": [{"position": [0,0,0], "radius": 1e999}]"#.to_owned(), "out of range"),
        (camera(r#""aperture": -0.1"#), "at least 0"),
        (camera(r#""shutter": -1"#), "at least 0"),
        (camera(r#""focal_distance": 0"#), "above 0"),
        (camera(r#""focal": 3"#), "unknown field"),
        (r#","motion": [{"material": "m", "speed": 3}]"#.to_owned(), "unknown field"),
        (r#","effects": {"shadow": 0}"#.to_owned(), "1 to 65536"),
        (r#","effects": {"shadow": 65537}"#.to_owned(), "1 to 65536"),
        (r#","effects": {"bloom": 1}"#.to_owned(), "unknown field"),
    ];
    for (part, said) in cases {
        let text = json(&[BALL, &part]);
        let error = SceneFile::parse(Path::new("dir/a.json"), &text).unwrap_err();
        assert!(matches!(error, LoadError::Json { .. }), "{error}");
        let message = error.to_string();
        // two lines of the ball come before
        assert!(
            message.starts_with("dir/a.json:6:") && message.contains(said),
            "{part}: {message}"
        );
    }
    for shape in [
        r#"{"sphere": {"center": [0,0,0], "radius": -1, "material": "m"}}"#,
        r#"{"cone": {"base": [0,0,0], "base_radius": -1, "apex": [0,1,0], "apex_radius": 0, "material": "m"}}"#,
        r#"{"torus": {}}"#,
    ] {
        let text = json(&[&format!(r#""source": {{"shapes": [{shape}]}}"#)]);
        let error = SceneFile::parse(Path::new("dir/a.json"), &text).unwrap_err();
        assert!(error.to_string().starts_with("dir/a.json:4:"), "{error}");
    }
    let rough = json(&[r#""materials": {"m": {"roughness": 1.5}}, "source": {"spd": "balls"}"#]);
    assert!(SceneFile::parse(Path::new("dir/a.json"), &rough).is_err());
}

#[test]
fn names_that_do_not_fit_are_typed_errors() {
    let ball = |material: &str| {
        format!(
            r#""materials": {{"m": {{}}}}, "source": {{"shapes": [
            {{"sphere": {{"center": [0,0,0], "radius": 1, "material": "{material}"}}}}]}}"#
        )
    };
    assert!(load(&[&ball("m")]).is_ok());
    let error = load(&[&ball("n")]).unwrap_err().to_string();
    assert!(error.contains("`n`") && error.contains("a material of this file: m"), "{error}");
    let motion = r#","motion": [{"material": "x", "velocity": [1, 0, 0]}]"#;
    let error = load(&[&ball("m"), motion]).unwrap_err().to_string();
    assert!(error.contains("the name of a material: m"), "{error}");
    let empty = r#""source": {"shapes": []}"#;
    assert!(matches!(load(&[empty]).unwrap_err(), LoadError::NoPrimitives { .. }));
    let flat = r#""materials": {"m": {}}, "source": {"shapes": [
        {"polygon": {"vertices": [[0,0,0],[1,0,0]], "material": "m"}}]}"#;
    assert!(load(&[flat]).unwrap_err().to_string().contains("2 vertices"));
}

#[test]
fn triangles_of_a_moving_ball_move_with_it() {
    let scene = load(&[
        r#""source": {"shapes": ["#,
        r#"{"sphere": {"center": [0, 0, 0], "radius": 1, "material": "m"}},"#,
        r#"{"sphere": {"center": [5, 0, 0], "radius": 1, "material": "m", "velocity": [0, 1, 0]}}]},"#,
        r#""materials": {"m": {}}, "tessellate": {"resolution": 1}"#,
    ])
    .unwrap();
    let moving = |id: usize| scene.velocity(id as u32) != DVec3::ZERO;
    let half = scene.primitives.len() / 2;
    assert!(half > 4 && (0..half).all(|id| !moving(id)) && (half..2 * half).all(moving));
}
