//! glTF files at rest stand as they say: skins, morph targets, nodes that are not to be seen.

use std::path::Path;

use scene_loading::animation;
use scene_loading::second_opinion::second_opinion;
use serde_json::json;

use crate::gltf_file::File;

const UNIT: [[f64; 3]; 2] = [[0.0; 3], [1.0, 1.0, 0.0]];

/// One triangle whose three vertices follow a joint that doubles and lifts by 5. The mesh's own
/// node is far away.
fn skinned() -> File {
    let mut file = File::new();
    let joints = file.accessor("VEC4", 5121, 3, &[0; 12]);
    let weights = file.floats("VEC4", &[1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    *file.attributes() = json!({"POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights});
    file.json["skins"] = json!([{"joints": [1]}]);
    file.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"translation": [0, 5, 0], "scale": [2, 2, 2]}
    ]);
    file.json.as_object_mut().unwrap().remove("animations");
    file
}

#[test]
fn a_skinned_mesh_follows_its_joints_at_rest() {
    // without inverse bind matrices they are the identity
    let mut file = skinned();
    assert_eq!(file.found(), (1, [[0.0, 5.0, 0.0], [2.0, 7.0, 0.0]]));
    assert!(file.load().unwrap().instances.is_empty());
    #[rustfmt::skip]
    let inverse = file.floats("MAT4", &[
        0.5, 0., 0., 0.,  0., 0.5, 0., 0.,  0., 0., 0.5, 0.,  0., 0., 3., 0.999_999_9,
    ]);
    file.json["skins"][0]["inverseBindMatrices"] = json!(inverse);
    assert_eq!(file.found(), (1, [[0.0, 5.0, 6.0], [1.0, 6.0, 6.0]]));
}

#[test]
fn the_second_reader_follows_skins_by_itself() {
    // planted: it cannot read joints without data, so that it leaves the mesh at its node
    let mut file = skinned();
    file.json["accessors"][1].as_object_mut().unwrap().remove("bufferView");
    let vertices = file.load().unwrap().vertices;
    assert_eq!(vertices, skinned().load().unwrap().vertices);
    let opinion = second_opinion(Path::new("a.gltf"), file.text().into_bytes()).unwrap();
    let lines = opinion.lines().join("\n");
    assert!(lines.contains("bounds [0, 5, 0] to [2, 7, 0] here, [100, 0, 0]"), "{lines}");
    assert!(lines.contains("taken from our reader, so not checked: buffers"), "{lines}");
    assert!(lines.contains("gltf alone refuses the file"), "{lines}");
}

#[test]
fn all_sets_of_joints_count_and_weights_need_not_sum_to_one() {
    let mut file = skinned();
    file.json["skins"][0]["joints"] = json!([1, 2]);
    file.push("nodes", json!({"translation": [0, 0, 8]}));
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let joints = file.accessor("VEC4", 5123, 3, &[1, 0, 0, 0, 0, 0, 0, 0].repeat(3));
    // a normalized short
    let weights = file.accessor("VEC4", 5123, 3, &[0xff, 0xff, 0, 0, 0, 0, 0, 0].repeat(3));
    file.json["accessors"][weights]["normalized"] = json!(true);
    file.attributes()["JOINTS_1"] = json!(joints);
    file.attributes()["WEIGHTS_1"] = json!(weights);
    // half of (2x, 2y + 5, 0) and half of (x, y, 8)
    assert_eq!(file.found(), (1, [[0.0, 2.5, 4.0], [1.5, 4.0, 4.0]]));
}

#[test]
fn an_animation_that_holds_begins_as_the_file_at_rest() {
    let mut file = skinned();
    let (times, values) =
        (file.floats("SCALAR", &[0., 1.]), file.floats("VEC3", &[0., 5., 0., 0., 5., 0.]));
    file.json["animations"] = json!([{
        "samplers": [{"input": times, "output": values}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]
    }]);
    file.push("nodes", json!({"mesh": 0, "scale": [0, 0, 0]}));
    file.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let still = file.load().unwrap();
    let path = Path::new("a.gltf");
    let mut moving = animation::parse(path, file.text().into_bytes()).unwrap();
    let first = moving.frame(0).unwrap();
    assert_eq!((still.vertices, still.primitives), (first.vertices, first.primitives));
}

#[test]
fn default_weights_of_the_node_go_before_those_of_the_mesh() {
    let mut file = File::new();
    let aside = file.floats("VEC3", &[0., 0., 0., 2., 0., 0., 0., 0., 0.]);
    // sparse, without data of its own
    let indices = file.accessor("SCALAR", 5123, 1, &[2, 0]);
    let values = file.floats("VEC3", &[0., 4., 0.]);
    let up = file.zeros(3);
    file.json["accessors"][up]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": indices, "componentType": 5123},
        "values": {"bufferView": values}
    });
    file.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": aside}, {"POSITION": up}]);
    file.json["meshes"][0]["weights"] = json!([1, 0]);
    file.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [0, 0.5]}]);
    file.json["scenes"][0]["nodes"] = json!([0]);
    assert_eq!(file.found(), (1, [[0.0; 3], [3.0, 1.0, 0.0]]));
    file.json["scenes"][0]["nodes"] = json!([1]);
    assert_eq!(file.found(), (1, [[0.0; 3], [1.0, 3.0, 0.0]]));
    // without a weight, a mesh with targets is as any other
    file.json["nodes"] = json!([{"mesh": 0, "weights": [0, 0]}]);
    file.json["scenes"][0]["nodes"] = json!([0]);
    assert_eq!(file.found(), (1, UNIT));
    assert_eq!(file.load().unwrap().instances.len(), 1);
}

#[test]
fn what_moves_too_many_vertices_is_refused() {
    let mut file = File::new();
    let zeros = file.zeros(1 << 20);
    let target = json!({"POSITION": zeros});
    file.json["meshes"][0] = json!({
        "primitives": [{"attributes": {"POSITION": zeros}, "targets": vec![target; 600]}],
        "weights": vec![1; 600]
    });
    assert!(file.refusal().contains("vertices that morph targets and joints move"));
    let mut file = skinned();
    file.json["skins"][0]["joints"] = json!(vec![1; (1 << 20) + 1]);
    assert!(file.refusal().contains("the number of joints"));
}

#[test]
fn what_is_not_to_be_seen_is_left_out_and_counted() {
    let mut file = File::new();
    assert_eq!(file.found().0, 2);
    for hidden in [
        json!({"mesh": 0, "scale": [0, 0, 0]}),
        json!({"mesh": 0, "matrix": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 0, 0, 1]}),
        json!({"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}}),
    ] {
        file.json["nodes"][1] = hidden;
        assert_eq!(file.found(), (1, UNIT));
        let said = file.warnings();
        assert_eq!(said, "a.gltf: 1 meshes that are scaled to nothing or not visible left out\n");
    }
    // what is below it, too; a node without a mesh is nothing to speak of
    file.json["nodes"] = json!([{"mesh": 0}, {"scale": [0, 0, 0], "children": [2]}, {"mesh": 0}]);
    assert_eq!(file.found(), (1, UNIT));
    file.json["nodes"] = json!([{"mesh": 0}, {"scale": [0, 0, 0]}]);
    assert_eq!((file.found(), file.warnings()), ((1, UNIT), String::new()));
    // all of it
    file.json["nodes"] = json!([{"mesh": 0, "scale": [0, 0, 0]}, {}]);
    assert!(file.refusal().contains("no primitives"));
}

#[test]
fn a_matrix_may_be_rounded() {
    let mut file = File::new();
    let row = |w: f64| json!([2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1e-8, 0, 0, 0, w]);
    file.json["nodes"] = json!([{"mesh": 0, "matrix": row(0.999_999_9)}, {}]);
    assert_eq!(file.found(), (1, [[0.0; 3], [2.0, 1.0, 0.0]]));
    file.json["nodes"][0]["matrix"] = row(0.99);
    assert!(file.refusal().contains("last row"));
}
