//! What glTF asks to be ignored or taken as zero, and what is no geometry, refuses no file.

use std::path::Path;

use scene_loading::Shape;
use scene_loading::gltf::parse_gltf;
use serde_json::json;

use crate::gltf_file::File;

const UNIT: [[f64; 3]; 2] = [[0.0; 3], [1.0, 1.0, 0.0]];

/// One triangle.
fn file() -> File {
    let mut file = File::new();
    file.json["scenes"][0]["nodes"] = json!([0]);
    file.json.as_object_mut().unwrap().remove("animations");
    file
}

fn attributes(file: &mut File) -> &mut serde_json::Value {
    &mut file.json["meshes"][0]["primitives"][0]["attributes"]
}

#[test]
fn an_accessor_without_data_is_zero() {
    let mut file = file();
    let accessors = file.json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({"componentType": 5126, "count": 3, "type": "VEC3"}));
    attributes(&mut file)["NORMAL"] = json!(1);
    assert_eq!((file.found(), file.warnings()), ((1, UNIT), String::new()));
    assert!(matches!(file.load().unwrap().primitives[0].shape, Shape::Triangle { .. }));
    let zero = json!({"attributes": {"POSITION": 1}});
    file.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(zero);
    assert_eq!(file.found(), (1, UNIT));
    assert!(file.warnings().contains("1 triangles without area left out"));
}

#[test]
fn incomplete_and_empty_primitives_are_counted() {
    let mut file = file();
    let indices = file.accessor("SCALAR", 5123, 5, &[0, 0, 1, 0, 2, 0, 0, 0, 1, 0]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert_eq!(file.found(), (1, UNIT));
    assert!(file.warnings().contains("1 primitives whose last triangle lacks corners"));
    let two = file.accessor("SCALAR", 5121, 2, &[0, 1]);
    let none = json!({"componentType": 5123, "count": 0, "type": "SCALAR"});
    file.json["accessors"].as_array_mut().unwrap().push(none);
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.extend([
        json!({"attributes": {"POSITION": 0}, "indices": two + 1}),
        json!({"attributes": {"POSITION": 0}, "indices": two, "mode": 5}),
        json!({"attributes": {"NORMAL": 0}}),
        json!({"attributes": {"POSITION": 0}, "mode": 0}),
    ]);
    file.json["meshes"].as_array_mut().unwrap().push(json!({"primitives": []}));
    file.json["scenes"][0]["nodes"] = json!([0, 1]);
    file.json["nodes"][1]["mesh"] = json!(1);
    assert_eq!(file.found(), (1, UNIT));
    let said = file.warnings();
    for what in [
        "2 primitives without a triangle left out",
        "1 primitives without positions left out",
        "1 meshes of points or lines left out",
    ] {
        assert!(said.contains(what), "{what}: {said}");
    }
}

#[test]
fn numbers_that_are_no_geometry_may_be_anything() {
    let mut file = file();
    let normals = file.floats("VEC3", &[f32::NAN, 0., 0., 0., f32::INFINITY, 0., 0., 0., 1.]);
    let colours = file.floats("VEC3", &[1.; 9]);
    attributes(&mut file)["NORMAL"] = json!(normals);
    attributes(&mut file)["COLOR_0"] = json!(colours);
    file.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 0, "znear": 0.1}}]);
    file.json["nodes"][0]["camera"] = json!(0);
    let light = json!({"type": "point", "intensity": -3});
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
    file.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    assert_eq!(file.found(), (1, UNIT));
    assert!(matches!(file.load().unwrap().primitives[0].shape, Shape::Triangle { .. }));
    let said = file.warnings();
    for what in [
        "2 normals that are not finite left out",
        "1 primitives with vertex colours (COLOR_0), which are not shown",
        "a.gltf: camera 0 left out: camera angle is 0",
        "a.gltf: light 0 left out: intensity -3",
    ] {
        assert!(said.contains(what), "{what}: {said}");
    }
}

#[test]
fn a_vertex_that_is_not_finite_counts_where_it_is_used() {
    let mut file = file();
    let numbers = [0., 0., 0., 1., 0., 0., 0., 1., 0., f32::NAN, 0., 0.];
    let positions = file.floats("VEC3", &numbers);
    let indices = file.accessor("SCALAR", 5121, 3, &[0, 1, 2]);
    file.json["meshes"][0]["primitives"][0] =
        json!({"attributes": {"POSITION": positions}, "indices": indices});
    assert_eq!(file.found(), (1, UNIT));
    assert!(file.warnings().contains("1 vertices are not finite; no triangle uses them"));
    *file.bytes.iter_mut().rfind(|byte| **byte == 2).unwrap() = 3;
    assert!(file.refusal().contains("accessor 1 (positions), element 3 is NaN"));
}

#[test]
fn custom_attributes_and_missing_bounds_are_ignored() {
    let mut file = file();
    attributes(&mut file)["_BATCHID"] = json!(0);
    attributes(&mut file)["_FEATURE_ID_0"] = json!(0);
    file.json["accessors"][0].as_object_mut().unwrap().remove("min");
    file.json["accessors"][0].as_object_mut().unwrap().remove("max");
    assert_eq!((file.found(), file.warnings()), ((1, UNIT), String::new()));
    // one that is read must be there
    attributes(&mut file)["NORMAL"] = json!(9);
    assert!(file.refusal().contains("accessor index 9"));
}

#[test]
fn text_may_have_a_mark_before_it_and_base64_no_padding() {
    let mut file = file();
    file.bytes.push(0);
    let text = file.text();
    assert!(text.contains("==\""));
    let text = format!("\u{feff}{}", text.replace("==\"", "\""));
    let scene = parse_gltf(Path::new("a.gltf"), text.as_bytes()).unwrap();
    assert_eq!(scene.primitives.len(), 1);
}

#[test]
fn unknown_chunks_of_a_glb_file_are_skipped() {
    let file = file();
    let mut text = file.text().into_bytes();
    // padded by zeros, as some writers do
    text.resize(text.len().next_multiple_of(4) + 4, 0);
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let mut chunk = (data.len() as u32).to_le_bytes().to_vec();
        chunk.extend(kind);
        chunk.extend(data);
        chunk
    };
    let glb = |chunks: &[Vec<u8>]| {
        let all = chunks.concat();
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((12 + all.len() as u32).to_le_bytes());
        bytes.extend(all);
        parse_gltf(Path::new("a.glb"), &bytes).map(|scene| scene.primitives.len())
    };
    let (json, other) = (chunk(b"JSON", &text), chunk(b"ACME", &[1, 2, 3, 4]));
    assert_eq!(glb(&[json.clone(), other.clone()]).unwrap(), 1);
    // also before the data
    let mut own = file.json.clone();
    own["buffers"] = json!([{"byteLength": file.bytes.len()}]);
    let own = chunk(b"JSON", own.to_string().as_bytes());
    let data = chunk(b"BIN\0", &file.bytes);
    assert_eq!(glb(&[own.clone(), other.clone(), data.clone(), other.clone()]).unwrap(), 1);
    let error = glb(&[own, other]).unwrap_err().to_string();
    assert!(error.contains("neither a URI nor a GLB chunk"), "{error}");
    let error = glb(&[data, json]).unwrap_err().to_string();
    assert!(error.contains("the first GLB chunk: found type `BIN"), "{error}");
}
