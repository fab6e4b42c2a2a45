//! Scenes far from the origin of their coordinates, and that no other is moved.

use std::fmt::Write;
use std::path::Path;

use glam::{DVec3, Vec3};
use scene_loading::animation::{ANIMATED, open};
use scene_loading::info::SceneInfo;
use scene_loading::procedural::generators;
use scene_loading::{LoadError, LoadedScene, Scene, SceneCatalogue};
use serde_json::json;

use crate::gltf_file::File;
use crate::{folder, resolved};

/// A place in UTM coordinates, metres.
const FAR: DVec3 = DVec3::new(448_000.0, 5_411_000.0, 0.0);

/// Triangles of tents half a metre wide, a few metres apart, above sea level.
fn tents() -> Vec<[DVec3; 3]> {
    let mut all = Vec::new();
    for i in 0..40 {
        let at = DVec3::new(f64::from(i % 7) * 3.2, f64::from(i / 7) * 2.9, 12.4);
        let point = |x: f64, y: f64, z: f64| at + DVec3::new(x, y, z);
        let [a, b, c] = [point(0.11, 0.07, 0.0), point(0.61, 0.07, 0.0), point(0.36, 0.57, 0.0)];
        let top = point(0.36, 0.31, 0.43);
        all.extend([[a, b, top], [b, c, top], [c, a, top]]);
    }
    all
}

fn numbers(p: DVec3) -> String {
    format!("{:.2} {:.2} {:.2}", p.x, p.y, p.z)
}

fn obj(by: DVec3) -> String {
    let mut text = String::new();
    for corners in tents() {
        for p in corners {
            writeln!(text, "v {}", numbers(p + by)).unwrap();
        }
        text += "f -3 -2 -1\n";
    }
    text
}

fn ply(by: DVec3) -> String {
    let tents = tents();
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        3 * tents.len(),
        tents.len()
    );
    for p in tents.iter().flatten() {
        writeln!(text, "{}", numbers(*p + by)).unwrap();
    }
    for i in 0..tents.len() {
        writeln!(text, "3 {} {} {}", 3 * i, 3 * i + 1, 3 * i + 2).unwrap();
    }
    text
}

fn stl(by: DVec3) -> String {
    let mut text = String::from("solid tents\n");
    for corners in tents() {
        text += "facet normal 0 0 0\nouter loop\n";
        for p in corners {
            writeln!(text, "vertex {}", numbers(p + by)).unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid tents\n"
}

fn pbrt(by: DVec3) -> String {
    let [eye, at, light, ..] = places(by);
    let mut text = format!("LookAt {eye} {at} 0 0 1\nCamera \"perspective\"\nWorldBegin\n");
    writeln!(text, "LightSource \"point\" \"point3 from\" [{light}]").unwrap();
    let at = numbers(by);
    writeln!(text, "Translate {at}").unwrap();
    for corners in tents() {
        let points = corners.map(numbers).join(" ");
        text += &format!(
            "Shape \"trianglemesh\" \"point3 P\" [{points}] \"integer indices\" [0 1 2]\n"
        );
    }
    text
}

/// Eye, point in the middle of the image, light, ball, the ends of a cone, corners of a square.
const PLACES: [[f64; 3]; 10] = [
    [9.0, -20.0, 20.0],
    [9.0, 9.0, 12.0],
    [0.0, 0.0, 50.0],
    [3.5, 4.25, 12.0],
    [8.0, 4.25, 12.0],
    [8.0, 4.75, 13.5],
    [0.0, 0.0, 11.0],
    [20.0, 0.0, 11.0],
    [20.0, 20.0, 11.0],
    [0.0, 20.0, 11.0],
];

fn places(by: DVec3) -> [String; 10] {
    PLACES.map(|place| numbers(by + DVec3::from(place)))
}

fn nff(by: DVec3) -> String {
    let [eye, at, light, ball, base, apex, a, b, c, d] = places(by);
    format!(
        "v\nfrom {eye}\nat {at}\nup 0 0 1\nangle 45\nhither 1\nresolution 8 8\nl {light}\n\
         f 1 1 1 1 0 0 0 1\ns {ball} 0.25\nc {base} 0.5 {apex} 0.25\np 4\n{a}\n{b}\n{c}\n{d}\n"
    )
}

fn scene_file(by: DVec3) -> String {
    let [eye, at, light, ball, base, apex, a, b, c, _] = places(by).map(|p| p.replace(' ', ","));
    let disc = numbers(by + DVec3::new(1.0, 2.0, 50.0)).replace(' ', ",");
    format!(
        r#"{{"name": "a", "title": "t", "why": "w", "materials": {{"m": {{}}}},
        "camera": {{"from": [{eye}], "at": [{at}], "up": [0, 0, 1], "angle": 40, "shutter": 1}},
        "lights": [{{"position": [{light}]}}, {{"position": [{disc}], "radius": 0.5}}],
        "source": {{"shapes": [
          {{"sphere": {{"center": [{ball}], "radius": 0.25, "material": "m", "velocity": [1, 0, 0]}}}},
          {{"cone": {{"base": [{base}], "base_radius": 0.5, "apex": [{apex}], "apex_radius": 0, "material": "m"}}}},
          {{"polygon": {{"vertices": [[{a}], [{b}], [{c}]], "material": "m"}}}}
        ]}}}}"#
    )
}

/// Tents of one mesh, twice, the second 30 m and a little to the right: a place that f32 does not
/// have far away.
fn gltf(by: DVec3) -> String {
    let points: Vec<Vec3> = tents().into_iter().flatten().map(|p| p.as_vec3()).collect();
    let (min, max) = points
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let mut file = File::new();
    let numbers: Vec<f32> = points.iter().flat_map(Vec3::to_array).collect();
    let positions = file.floats("VEC3", &numbers);
    file.json["accessors"][positions]["min"] = json!(min.to_array());
    file.json["accessors"][positions]["max"] = json!(max.to_array());
    file.attributes()["POSITION"] = json!(positions);
    let places = [by, by + DVec3::new(30.0, 0.125, 0.0)];
    let node = |place: DVec3| json!({"mesh": 0, "translation": place.to_array()});
    file.json["nodes"] = json!(places.map(node));
    file.json.as_object_mut().unwrap().remove("animations");
    file.text()
}

fn written(name: &str, text: &str) -> LoadedScene {
    let (_folder, path) = folder(&[(name, text)]);
    resolved(&path.join(name)).unwrap().load().unwrap()
}

/// Every point that a scene has.
fn points(scene: &Scene) -> Vec<DVec3> {
    let camera = [scene.camera.from, scene.camera.at];
    let lights = scene.lights.iter().map(|light| light.position);
    let spheres = scene.spheres.iter().map(|sphere| sphere.center);
    let cones = scene.cones.iter().flat_map(|cone| [cone.base, cone.apex]);
    let instances = scene.instances.iter().map(|i| i.placement.translation);
    let all = camera.into_iter().chain(lights).chain(spheres).chain(cones).chain(instances);
    all.chain(scene.vertices.iter().copied()).collect()
}

/// The difference of two points in a scene, at most.
fn apart(a: &Scene, b: &Scene) -> f64 {
    let (a, b) = (points(a), points(b));
    assert_eq!(a.len(), b.len());
    a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

type Writer = fn(DVec3) -> String;

const FORMATS: [(&str, Writer); 7] = [
    ("a.obj", obj),
    ("a.ply", ply),
    ("a.stl", stl),
    ("a.pbrt", pbrt),
    ("a.nff", nff),
    ("a.json", scene_file),
    ("a.gltf", gltf),
];

#[test]
fn a_far_scene_of_any_format_is_where_the_near_one_is() {
    for (name, text) in FORMATS {
        let [near, far] = [DVec3::ZERO, FAR].map(|by| written(name, &text(by)));
        assert_eq!((near.scene.origin, far.scene.origin), (DVec3::ZERO, FAR), "{name}");
        assert!(near.scene.fine_detail.is_none() && far.scene.fine_detail.is_none(), "{name}");
        // f64 rounds to 1e-9 at 5.4e6, twice where a transform is applied
        let off = apart(&near.scene, &far.scene);
        assert!(off < 4e-9, "{name}: {off}");
        assert_ne!(near.sha256, far.sha256, "{name}");
        // planted: without the move they are apart
        let mut unmoved = far.scene.clone();
        unmoved.vertices.iter_mut().for_each(|v| *v += FAR);
        assert!(apart(&near.scene, &unmoved) > 1e6, "{name}");
    }
}

#[test]
fn the_file_s_own_coordinates_are_shown_and_bit_for_bit_the_same() {
    let far = written("a.obj", &obj(FAR)).scene;
    let parsed: Vec<DVec3> = tents().into_iter().flatten().collect();
    for (vertex, wanted) in far.vertices.iter().zip(parsed) {
        let wanted: Vec<f64> =
            numbers(wanted + FAR).split(' ').map(|x| x.parse().unwrap()).collect();
        assert_eq!(far.to_file_coordinates(*vertex).to_array(), *wanted);
        assert_eq!(far.to_scene_coordinates(far.to_file_coordinates(*vertex)), *vertex);
    }
    let info = SceneInfo::of(&far);
    assert_eq!(info.bounds.min, DVec3::new(448_000.11, 5_411_000.07, 12.4));
    let text = info.to_string();
    assert!(text.contains("[448000.11, 5411000.07, 12.4]"), "{text}");
    assert!(text.contains("shift       by [-448000, -5411000, 0]"), "{text}");
    let near = written("a.obj", &obj(DVec3::ZERO)).scene;
    assert!(!SceneInfo::of(&near).to_string().contains("shift"));
}

#[test]
fn a_camera_and_lights_given_beside_are_in_the_file_s_coordinates() {
    let (_folder, path) = folder(&[("a.obj", obj(FAR))]);
    let mut scene = resolved(&path.join("a.obj")).unwrap();
    scene.view.camera = "448009,5410980,20:448009,5411009,12".parse().ok();
    scene.view.lights = vec!["448000,5411000,50".parse().unwrap()];
    let mut loaded = scene.load().unwrap().scene;
    let expected = (DVec3::new(9.0, -20.0, 20.0), DVec3::new(0.0, 0.0, 50.0));
    assert_eq!((loaded.camera.from, loaded.lights[0].position), expected);
    // again, to the scene as it is now: what `animate` does with each frame
    scene.view.apply(&mut loaded).unwrap();
    assert_eq!((loaded.camera.from, loaded.lights[0].position), expected);
}

/// The warnings of a scene of tents and one more triangle that speak of f32.
fn with_outlier(tents: DVec3, outlier: DVec3, size: f64) -> (Scene, Vec<String>) {
    let mut text = obj(tents);
    for corner in [DVec3::ZERO, DVec3::X, DVec3::Y] {
        writeln!(text, "v {}", numbers(outlier + corner * size)).unwrap();
    }
    let scene = written("a.obj", &(text + "f -3 -2 -1\n")).scene;
    let said = scene.warnings_in_f32().filter(|w| w.0.contains("f32"));
    let said = said.map(ToString::to_string).collect();
    (scene, said)
}

#[test]
fn one_far_outlier_leaves_the_scene_where_it_is_and_warns_once() {
    let (scene, said) = with_outlier(FAR, DVec3::ZERO, 9.0);
    assert_eq!((scene.origin, said.len()), (DVec3::ZERO, 1), "{said:?}");
    for part in ["120 of 121 primitives are distorted", "5411015", "--precision f64"] {
        assert!(said[0].contains(part), "{said:?}");
    }
    // in f64 there is nothing to warn of
    assert!(!scene.warnings.iter().any(|w| w.0.contains("f32")));
    // tents near the origin are there in f32, too, but boxes around them are not
    let (scene, said) = with_outlier(DVec3::ZERO, FAR, 9.0);
    assert_eq!((scene.origin, said.len()), (DVec3::ZERO, 1), "{said:?}");
    assert!(said[0].contains("121 of 121 primitives are smaller than the padding"), "{said:?}");
    // at hand all is well
    let (scene, said) = with_outlier(FAR, FAR, 9.0);
    assert_eq!((scene.origin, said), (FAR, Vec::new()));
    // a teapot in a stadium: most are small, and that is usual
    let (scene, said) = with_outlier(DVec3::ZERO, DVec3::ZERO, 2e4);
    assert_eq!((scene.origin, said), (DVec3::ZERO, Vec::new()));
}

#[test]
fn coordinates_stored_in_f32_are_not_too_fine() {
    let mut soup = 2u32.to_le_bytes().to_vec();
    for corner in [[4e6, 0.0, 0.0], [4e6 + 0.5, 0.0, 0.0], [4e6, 0.5, 0.0]].into_iter().chain([
        [0.0, 0.0, 0.0],
        [9e4, 0.0, 0.0],
        [0.0, 9e4, 0.0f32],
    ]) {
        soup.extend(corner.into_iter().chain([0.0]).flat_map(f32::to_le_bytes));
    }
    let (_folder, path) = folder(&[("a.bin", soup)]);
    let scene = resolved(&path.join("a.bin")).unwrap().load().unwrap().scene;
    assert_eq!((scene.primitives.len(), scene.origin), (2, DVec3::ZERO));
    assert_eq!(scene.fine_detail, None);
}

#[test]
fn frames_of_an_animation_are_moved_by_one_shift() {
    // it wanders farther than its own extent
    let files = [("f0.obj", 0.0), ("f1.obj", 50.0), ("f2.obj", 100.0)];
    let (_folder, path) = folder(&files.map(|(name, by)| (name, obj(FAR + DVec3::X * by))));
    let mut animation = open(path.join("f%d.obj").to_str().unwrap()).unwrap();
    // the last first: it has the shift of the first all the same
    let frames = [2, 0, 1].map(|i| animation.frame(i).unwrap());
    let near = written("a.obj", &obj(DVec3::ZERO)).scene;
    for (frame, by) in frames.iter().zip([100.0, 0.0, 50.0]) {
        assert_eq!(frame.origin, FAR);
        for (vertex, near) in frame.vertices.iter().zip(&near.vertices) {
            assert!(vertex.distance(*near + DVec3::X * by) < 4e-9);
        }
        assert_eq!(frame.camera, frames[0].camera);
    }
    // the light at the eye, too
    assert_eq!(frames[0].lights[0].position, frames[0].camera.from);
}

#[test]
fn built_in_scenes_are_neither_moved_nor_too_fine() {
    let catalogue = SceneCatalogue::open(Some(Path::new("../../scenes"))).unwrap();
    let described = catalogue.scenes().map(|scene| scene.name.clone());
    let names: Vec<String> = generators().map(|s| s.name.to_owned()).chain(described).collect();
    let mut seen = 0;
    for scene in catalogue.resolve(&names).unwrap() {
        let loaded = match scene.load() {
            Ok(loaded) => loaded.scene,
            Err(LoadError::NotFetched { .. }) => continue,
            Err(error) => panic!("{error}"),
        };
        seen += 1;
        assert_eq!(loaded.origin, DVec3::ZERO, "{}", scene.name);
        assert_eq!(loaded.fine_detail, None, "{}", scene.name);
    }
    assert!(seen >= 26, "{seen}");
    for entry in ANIMATED {
        let mut animation = open(entry.name).unwrap();
        for index in [0, entry.frames - 1] {
            let frame = animation.frame(index).unwrap();
            assert_eq!((frame.origin, &frame.fine_detail), (DVec3::ZERO, &None), "{}", entry.name);
        }
    }
}
