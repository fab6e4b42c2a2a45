//! Scenes without a camera or lights are usable, and a camera and lights from outside replace
//! theirs.

use std::path::Path;

use glam::DVec3;
use scene_loading::obj::{ObjOptions, parse_materials, parse_obj};
use scene_loading::view_options::UpOption;
use scene_loading::{LoadedScene, ViewOptions};

use crate::{folder, resolved};

fn warns_of_light(loaded: &LoadedScene) -> bool {
    loaded.scene.warnings.iter().any(|warning| warning.0.contains("no lights"))
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn a_scene_without_lights_gets_one_at_the_eye_and_a_warning() {
    let lit = ("c.nff", "l 1 2 3\ns 0 0 0 1\n");
    let (_folder, path) = folder(&[("a.obj", OBJ), ("b.nff", "s 0 0 0 1\n"), lit]);
    for name in ["a.obj", "b.nff"] {
        let loaded = resolved(&path.join(name)).unwrap().load().unwrap();
        let lights: Vec<DVec3> = loaded.scene.lights.iter().map(|l| l.position).collect();
        assert_eq!(lights, [loaded.scene.camera.from], "{name}");
        assert!(warns_of_light(&loaded), "{name}: {:?}", loaded.scene.warnings);
    }
    let lit = resolved(&path.join("c.nff")).unwrap().load().unwrap();
    assert!(!warns_of_light(&lit) && lit.scene.lights[0].position == DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn a_scene_file_can_ask_for_no_lights() {
    let text = |name: &str, more: &str| {
        format!(
            r#"{{"name": "{name}", "title": "t", "why": "w", "source": {{"file": "a.obj"}}{more}}}"#
        )
    };
    let dark = text("dark", r#", "lights": []"#);
    let files = [("a.obj", OBJ.to_owned()), ("dark.json", dark), ("open.json", text("open", ""))];
    let (_folder, path) = folder(&files);
    let [dark, open] =
        ["dark.json", "open.json"].map(|name| resolved(&path.join(name)).unwrap().load().unwrap());
    assert!(dark.scene.lights.is_empty() && !warns_of_light(&dark));
    assert!(open.scene.lights.len() == 1 && warns_of_light(&open));
    assert_ne!(dark.sha256, open.sha256, "a result says which");
}

#[test]
fn all_of_a_scene_without_a_camera_is_in_the_image() {
    for offset in ["0 0 0", "1000 -5 30"] {
        let [x, y, z]: [f64; 3] =
            offset.split(' ').map(|n| n.parse().unwrap()).collect::<Vec<_>>().try_into().unwrap();
        let corners = [[0., 0., 0.], [4., 0., 0.], [0., 9., 1.], [-3., 2., 7.]];
        let mut text = String::new();
        for [a, b, c] in corners {
            text += &format!("v {} {} {}\n", x + a, y + b, z + c);
        }
        text += "f 1 2 3\nf 1 3 4\nf 2 3 4\n";
        let scene = parse_obj(Path::new("a.obj"), text.into(), ObjOptions::default()).unwrap();
        let camera = scene.camera;
        let view = (camera.at - camera.from).normalize();
        let half = (camera.angle.to_radians() / 2.0).tan();
        for vertex in &scene.vertices {
            let to = *vertex - camera.from;
            let along = to.dot(view);
            let aside = (to - view * along).length();
            assert!(along > 0.0 && aside < half * along, "{vertex} is out of view");
        }
    }
}

#[test]
fn what_is_said_from_outside_replaces_view_and_lights_and_shows_in_the_hash() {
    let (_folder, path) = folder(&[("a.nff", "l 1 2 3\ns 0 0 0 1\n")]);
    let mut scene = resolved(&path.join("a.nff")).unwrap();
    let before = scene.load().unwrap();
    scene.view = ViewOptions {
        camera: "0,0,7:0,0,0:30".parse().ok(),
        up: Some(UpOption(DVec3::X)),
        lights: vec!["4,5,6:1,0,0".parse().unwrap(), "7,8,9".parse().unwrap()],
    };
    let after = scene.load().unwrap();
    assert_ne!(before.sha256, after.sha256);
    let camera = after.scene.camera;
    assert_eq!((camera.from.z, camera.angle, camera.up), (7.0, 30.0, DVec3::X));
    assert_eq!(after.scene.lights.len(), 2);
    assert_eq!(after.scene.lights[0].color, Some([1.0, 0.0, 0.0]));
    scene.view = ViewOptions { up: Some(UpOption(after.scene.camera.from)), ..scene.view };
    let error = scene.load().unwrap_err().to_string();
    assert!(error.contains("--camera, --up (scene a): camera `up`"), "{error}");
}

#[test]
fn a_material_that_reflects_and_has_no_exponent_is_a_mirror_and_no_white_disc() {
    let shine = |text: &str| {
        let text = format!("newmtl m\nKd 0 0 0\nKs 1 1 1\n{text}\n");
        let material = parse_materials(Path::new("a.mtl"), text.into()).unwrap().remove(0);
        (material.specular, material.shine)
    };
    // half a degree beside the mirrored direction nothing of a highlight is left
    let off = 0.5_f64.to_radians().cos();
    let (specular, exponent) = shine("illum 3");
    assert!(specular == 1.0 && off.powf(exponent) < 0.05, "{exponent}");
    assert_eq!(shine("illum 3\nNs 20"), (1.0, 20.0));
    assert_eq!(shine("illum 2").0, 0.0);
}
