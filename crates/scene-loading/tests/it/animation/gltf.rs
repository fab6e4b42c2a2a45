//! Animations of glTF files, with what is expected worked out by hand.

use std::path::Path;

use glam::DVec3;
use scene_loading::animation::{Animation, parse};
use scene_loading::{LoadError, Scene};
use serde_json::{Value, json};

use super::{claim_error, claimed};
use crate::gltf_file::File;

impl File {
    /// Adds a channel for a node.
    fn channel(&mut self, node: usize, path: &str, how: &str, times: &[f32], values: &[f32]) {
        let kind = match path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let (input, output) = (self.floats("SCALAR", times), self.floats(kind, values));
        let animation = &mut self.json["animations"][0];
        let samplers = animation["samplers"].as_array_mut().unwrap();
        samplers.push(json!({"input": input, "output": output, "interpolation": how}));
        let sampler = samplers.len() - 1;
        let channels = animation["channels"].as_array_mut().unwrap();
        channels.push(json!({"sampler": sampler, "target": {"node": node, "path": path}}));
    }

    fn open(&self) -> Result<Animation, LoadError> {
        parse(Path::new("moves.gltf"), self.text().into_bytes())
    }

    /// The frame at 1 of 2 seconds, and the first.
    fn frames(&self) -> [Scene; 2] {
        let mut animation = self.open().unwrap();
        assert_eq!((animation.frames(), animation.name()), (51, "moves"));
        let middle = animation.frame(25).unwrap();
        [middle, animation.frame(0).unwrap()]
    }

    /// Description of the fault.
    fn error(&self) -> String {
        let scene = self.open().and_then(|mut animation| animation.frame(1));
        let text = scene.expect_err(&self.json.to_string()).to_string();
        assert!(text.contains("moves.gltf: ") && !text.contains("panic"), "{text}");
        text
    }
}

fn near(a: DVec3, b: [f64; 3]) {
    assert!(a.distance(DVec3::from_array(b)) < 1e-6, "{a} instead of {b:?}");
}

#[test]
fn nodes_are_moved_turned_and_scaled() {
    let mut file = File::new();
    file.channel(1, "translation", "LINEAR", &[0., 2.], &[0., 0., 5., 8., 0., 5.]);
    let half = 0.5_f32.sqrt();
    // a quarter turn about z; the longer arc is written, the shorter is gone
    file.channel(1, "rotation", "LINEAR", &[0., 2.], &[0., 0., 0., 1., 0., 0., -half, -half]);
    file.channel(1, "scale", "STEP", &[0., 0.9, 2.], &[1., 1., 1., 2., 2., 2., 3., 3., 3.]);
    let [middle, first] = file.frames();
    let eighth = 2.0 * 0.5_f64.sqrt();
    near(middle.vertices[3], [4.0, 0.0, 5.0]);
    near(middle.vertices[4], [4.0 + eighth, eighth, 5.0]);
    near(middle.vertices[5], [4.0 - eighth, eighth, 5.0]);
    near(middle.vertices[1], [1.0, 0.0, 0.0]);
    // claims: two instances of one object, rigid but for the scale, which is claimed as well
    assert_eq!(claimed(&first), 2);
    assert_eq!(first.instances[0].object, first.instances[1].object);
    assert!(claim_error(&first, &middle) < 1e-12);
    let mut bad = middle.clone();
    bad.instances[1].placement.translation.x += 1e-9;
    assert!(claim_error(&first, &bad) > 1e-10, "a planted fault");
    // no camera in the file: that of the first frame; a light at its eye
    assert_eq!((middle.camera, &middle.lights), (first.camera, &first.lights));
    assert_eq!(middle.lights.len(), 1);
}

#[test]
fn keys_hold_before_the_first_and_behind_the_last() {
    let mut file = File::new();
    file.channel(0, "translation", "LINEAR", &[0.5, 1.5], &[1., 0., 0., 3., 0., 0.]);
    file.channel(1, "translation", "LINEAR", &[0., 2.], &[0., 0., 5., 0., 0., 5.]);
    let mut animation = file.open().unwrap();
    for (index, x) in [(0, 1.0), (12, 1.0), (25, 2.0), (38, 3.0), (50, 3.0)] {
        near(animation.frame(index).unwrap().vertices[0], [x, 0.0, 0.0]);
    }
}

#[test]
fn splines_bend_by_their_tangents() {
    let mut file = File::new();
    // leaves 0 at 2 units per second, arrives at 4 at rest: 0.125 * 2 s * 2 + 0.5 * 4 in the middle
    #[rustfmt::skip]
    let values = [
        9., 9., 9.,  0., 0., 0.,  2., 0., 0.,
        0., 0., 0.,  4., 0., 0.,  9., 9., 9.,
    ];
    file.channel(0, "translation", "CUBICSPLINE", &[0., 2.], &values);
    let [middle, first] = file.frames();
    near(first.vertices[0], [0.0, 0.0, 0.0]);
    near(middle.vertices[0], [2.5, 0.0, 0.0]);
}

#[test]
fn rotations_may_be_shorts() {
    let mut file = File::new();
    file.channel(0, "rotation", "STEP", &[0., 2.], &[0.; 8]);
    let shorts = [0_i16, 0, i16::MAX, 0, 0, 0, 0, i16::MAX];
    let bytes: Vec<u8> = shorts.iter().flat_map(|x| x.to_le_bytes()).collect();
    let output = file.accessor("VEC4", 5122, 2, &bytes);
    file.json["accessors"][output]["normalized"] = json!(true);
    file.json["animations"][0]["samplers"][0]["output"] = json!(output);
    let [middle, _] = file.frames();
    near(middle.vertices[1], [-1.0, 0.0, 0.0]);
}

#[test]
fn vertices_follow_their_joints() {
    let mut file = File::new();
    // the first node has the skin; what it is moved by itself does not count
    let joints = file.accessor("VEC4", 5121, 3, &[0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]);
    #[rustfmt::skip]
    let weights = file.floats("VEC4", &[0.5, 0.5, 0., 0.,  0., 0., 0., 0.,  0.25, 0., 0., 0.]);
    #[rustfmt::skip]
    let inverse = file.floats("MAT4", &[
        1., 0., 0., 0.,  0., 1., 0., 0.,  0., 0., 1., 0.,  0., 0., 0., 1.,
        1., 0., 0., 0.,  0., 1., 0., 0.,  0., 0., 1., 0.,  0., -1., 0., 1.,
    ]);
    *file.attributes() = json!({"POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights});
    file.json["skins"] = json!([{"joints": [2, 3], "inverseBindMatrices": inverse}]);
    file.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"children": [2]},
        {"children": [3]},
        {"translation": [0, 1, 0]}
    ]);
    // the second joint rises from 1 to 9
    file.channel(3, "translation", "LINEAR", &[0., 2.], &[0., 1., 0., 0., 9., 0.]);
    let [middle, first] = file.frames();
    near(first.vertices[0], [0.0, 0.0, 0.0]);
    near(first.vertices[2], [0.0, 1.0, 0.0]);
    // by half of 4, not at all (no weights: the first joint), wholly (the weight is made 1)
    near(middle.vertices[0], [0.0, 2.0, 0.0]);
    near(middle.vertices[1], [1.0, 0.0, 0.0]);
    near(middle.vertices[2], [0.0, 5.0, 0.0]);
    assert!(middle.instances.is_empty() && middle.primitives.len() == 1);

    let mut bad = file.clone();
    bad.json["skins"][0]["joints"] = json!([2]);
    assert!(bad.error().contains("skin 0: found joint 1 of vertex 0, expected one of 1"));
    bad.json["skins"][0]["joints"] = json!([2, 3, 1]);
    assert!(bad.error().contains("2 matrices for 3 joints"));
    bad.json["skins"][0]["joints"] = json!([2, 3]);
    // where there is nothing to follow, the mesh stays at its node
    let warning = |file: &File| {
        let scene = file.open().unwrap().frame(1).unwrap();
        near(scene.to_file_coordinates(scene.vertices[1]), [101.0, 0.0, 0.0]);
        scene.warnings[0].to_string()
    };
    bad.json["nodes"][1]["children"] = json!([]);
    assert!(warning(&bad).contains("joints that are not in the scene"));
    bad.json["nodes"][1]["children"] = json!([2]);
    bad.attributes().as_object_mut().unwrap().remove("WEIGHTS_0");
    assert!(warning(&bad).contains("has no JOINTS_0 and WEIGHTS_0"));
}

#[test]
fn morph_targets_are_added_by_their_weights() {
    let mut file = File::new();
    let up = file.floats("VEC3", &[0., 0., 4., 0., 0., 0., 0., 0., 0.]);
    let aside = file.floats("VEC3", &[0., 0., 0., 2., 0., 0., 0., 0., 0.]);
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": up}, {"POSITION": aside}]);
    file.json["meshes"][0]["weights"] = json!([0, 0.5]);
    file.channel(0, "weights", "LINEAR", &[0., 2.], &[0., 0., 1., 3.]);
    let [middle, first] = file.frames();
    near(first.vertices[0], [0.0, 0.0, 0.0]);
    near(middle.vertices[0], [0.0, 0.0, 2.0]);
    near(middle.vertices[1], [4.0, 0.0, 0.0]);
    // the second node has the weights of the mesh; both may change their shape
    near(middle.vertices[4], [2.0, 0.0, 5.0]);
    assert!(middle.instances.is_empty());

    file.json["accessors"][up]["count"] = json!(2);
    assert!(file.error().contains("2 elements, expected 3, as many as vertices"));
}

#[test]
fn vanished_nodes_keep_their_triangles_and_claim_no_copies() {
    let mut file = File::new();
    file.channel(1, "scale", "LINEAR", &[0., 2.], &[1., 1., 1., -1., -1., -1.]);
    let [middle, first] = file.frames();
    assert_eq!((middle.primitives.len(), first.primitives.len()), (2, 2));
    near(middle.vertices[4], [0.0, 0.0, 5.0]);
    assert_eq!((claimed(&first), claimed(&middle)), (1, 1));
}

#[test]
fn a_camera_that_moves_does() {
    let mut file = File::new();
    file.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}
    ]);
    file.json["nodes"] = json!([{"mesh": 0}, {"camera": 0}]);
    file.channel(1, "translation", "LINEAR", &[0., 2.], &[0., 0., 9., 0., 0., 5.]);
    let [middle, first] = file.frames();
    assert_eq!((first.camera.from.z, middle.camera.from.z), (9.0, 7.0));
}

#[test]
fn numbers_of_frames_are_limited_to_2_to_1500() {
    for (end, frames) in [(0.0, 2), (0.01, 2), (1.0, 26), (1e6, 1500)] {
        let mut file = File::new();
        match end {
            0.0 => file.channel(0, "translation", "LINEAR", &[0.], &[0.; 3]),
            _ => file.channel(0, "translation", "LINEAR", &[0., end], &[0.; 6]),
        }
        let mut animation = file.open().unwrap();
        assert_eq!(animation.frames(), frames);
        animation.frame(frames - 1).unwrap();
        assert!(matches!(animation.frame(frames), Err(LoadError::IndexOutOfRange { .. })));
    }
}

#[test]
fn broken_samplers_and_channels_are_refused() {
    let moved = || {
        let mut file = File::new();
        file.channel(0, "translation", "LINEAR", &[0., 2.], &[0., 0., 0., 1., 1., 1.]);
        file
    };
    let change = |pointer: &str, value: Value| {
        let mut file = moved();
        *file.json.pointer_mut(pointer).unwrap() = value;
        file.error()
    };
    let sampler = "/animations/0/samplers/0";
    let says = |text: String, what: &str| assert!(text.contains(what), "{text}");
    says(change("/accessors/2/count", json!(1)), "3 numbers for 2 times, expected 6 (Linear)");
    says(change(&format!("{sampler}/interpolation"), json!("CUBICSPLINE")), "expected 18 (Cubic");
    says(change(&format!("{sampler}/input"), json!(2)), "Vec3 of F32, expected Scalar of F32");
    says(change(&format!("{sampler}/output"), json!(1)), "Scalar of F32, expected Vec3 of F32");
    says(change(&format!("{sampler}/output"), json!(77)), "gltf reports");
    says(change(&format!("{sampler}/interpolation"), json!("LINAER")), "moves.gltf");
    let channel = "/animations/0/channels/0";
    says(change(&format!("{channel}/sampler"), json!(1)), "moves.gltf");
    says(change(&format!("{channel}/target"), json!({"node": 9, "path": "scale"})), "node 9");
    says(change(&format!("{channel}/target"), json!({"node": 0, "path": "colour"})), "moves.gltf");
    let weights = json!({"node": 0, "path": "weights"});
    says(change(&format!("{channel}/target"), weights), "a node without morph targets");
    says(
        change("/nodes/0", json!({"mesh": 0, "matrix": [1,0,0,0,0,1,0,0,0,0,1,0,0,0,1,1]})),
        "matrix although",
    );
    says(change("/animations/0/channels", json!([])), "moves.gltf");
    says(change("/animations", json!([])), "no animations");
    for (times, what) in [
        ([2., 2.], "key 1 at 2.0 behind 2.0, expected times that ascend"),
        ([1., 0.], "times that ascend"),
        ([0., f32::NAN], "element 1 is NaN"),
        ([f32::INFINITY, 0.], "element 0 is inf"),
    ] {
        let mut file = File::new();
        file.channel(0, "translation", "LINEAR", &times, &[0.; 6]);
        says(file.error(), what);
    }
    let mut file = File::new();
    file.channel(0, "scale", "LINEAR", &[0., 2.], &[1., 1., 1., f32::NAN, 1., 1.]);
    says(file.error(), "accessor 2 (keys), element 1 is NaN");
    let mut file = File::new();
    file.channel(0, "rotation", "LINEAR", &[0., 2.], &[0.; 8]);
    says(file.error(), "a rotation of 0, 0, 0, 0");
    // a sampler that two channels use for different things
    let mut file = moved();
    let other = json!({"sampler": 0, "target": {"node": 1, "path": "rotation"}});
    file.json["animations"][0]["channels"].as_array_mut().unwrap().push(other);
    says(file.error(), "a sampler of 3 numbers, expected one of 4");
}
