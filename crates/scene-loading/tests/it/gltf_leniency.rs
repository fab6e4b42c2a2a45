//! What refuses no glTF file: what the format asks to be ignored or taken as zero, what is no
//! geometry, and extensions: those that are read, those that may be left out, those that may not.

use std::path::Path;

use glam::DVec3;
use scene_loading::Shape;
use scene_loading::gltf::parse_gltf;
use serde_json::{Value, json};

use crate::gltf_file::{File, chunk, glb};

const UNIT: [[f64; 3]; 2] = [[0.0; 3], [1.0, 1.0, 0.0]];

#[test]
fn an_accessor_without_data_is_zero() {
    let mut file = File::triangle();
    let zeros = file.zeros(3);
    file.attributes()["NORMAL"] = json!(zeros);
    assert_eq!((file.found(), file.warnings()), ((1, UNIT), String::new()));
    assert!(matches!(file.load().unwrap().primitives[0].shape, Shape::Triangle { .. }));
    let zero = json!({"attributes": {"POSITION": 1}});
    file.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(zero);
    assert_eq!(file.found(), (1, UNIT));
    assert!(file.warnings().contains("1 triangles without area left out"));
}

#[test]
fn incomplete_and_empty_primitives_are_counted() {
    let mut file = File::triangle();
    let indices = file.accessor("SCALAR", 5123, 5, &[0, 0, 1, 0, 2, 0, 0, 0, 1, 0]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert_eq!(file.found(), (1, UNIT));
    assert!(file.warnings().contains("1 primitives whose last triangle lacks corners"));
    let two = file.accessor("SCALAR", 5121, 2, &[0, 1]);
    let none = json!({"componentType": 5123, "count": 0, "type": "SCALAR"});
    let none = file.push("accessors", none);
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.extend([
        json!({"attributes": {"POSITION": 0}, "indices": none}),
        json!({"attributes": {"POSITION": 0}, "indices": two, "mode": 5}),
        json!({"attributes": {"NORMAL": 0}}),
        json!({"attributes": {"POSITION": 0}, "mode": 0}),
    ]);
    file.push("meshes", json!({"primitives": []}));
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
    let mut file = File::triangle();
    let normals = file.floats("VEC3", &[f32::NAN, 0., 0., 0., f32::INFINITY, 0., 0., 0., 1.]);
    let colours = file.floats("VEC3", &[1.; 9]);
    file.attributes()["NORMAL"] = json!(normals);
    file.attributes()["COLOR_0"] = json!(colours);
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
    let mut file = File::triangle();
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
    let mut file = File::triangle();
    file.attributes()["_BATCHID"] = json!(0);
    file.attributes()["_FEATURE_ID_0"] = json!(0);
    file.json["accessors"][0].as_object_mut().unwrap().remove("min");
    file.json["accessors"][0].as_object_mut().unwrap().remove("max");
    assert_eq!((file.found(), file.warnings()), ((1, UNIT), String::new()));
    // one that is read must be there
    file.attributes()["NORMAL"] = json!(9);
    assert!(file.refusal().contains("accessor index 9"));
}

#[test]
fn text_may_have_a_mark_before_it_and_base64_no_padding() {
    let mut file = File::triangle();
    file.bytes.push(0);
    let text = file.text();
    assert!(text.contains("==\""));
    let text = format!("\u{feff}{}", text.replace("==\"", "\""));
    let scene = parse_gltf(Path::new("a.gltf"), text.as_bytes()).unwrap();
    assert_eq!(scene.primitives.len(), 1);
}

#[test]
fn unknown_chunks_of_a_glb_file_are_skipped() {
    let file = File::triangle();
    let mut text = file.text().into_bytes();
    // padded by zeros, as some writers do
    text.resize(text.len().next_multiple_of(4) + 4, 0);
    let triangles = |chunks: &[Vec<u8>]| {
        parse_gltf(Path::new("a.glb"), &glb(chunks)).map(|scene| scene.primitives.len())
    };
    let (json, other) = (chunk(b"JSON", &text), chunk(b"ACME", &[1, 2, 3, 4]));
    assert_eq!(triangles(&[json.clone(), other.clone()]).unwrap(), 1);
    // also before the data
    let mut own = file.json.clone();
    own["buffers"] = json!([{"byteLength": file.bytes.len()}]);
    let own = chunk(b"JSON", own.to_string().as_bytes());
    let data = chunk(b"BIN\0", &file.bytes);
    assert_eq!(triangles(&[own.clone(), other.clone(), data.clone(), other.clone()]).unwrap(), 1);
    let error = triangles(&[own, other]).unwrap_err().to_string();
    assert!(error.contains("neither a URI nor a GLB chunk"), "{error}");
    let error = triangles(&[data, json]).unwrap_err().to_string();
    assert!(error.contains("the first GLB chunk: found type `BIN"), "{error}");
}

/// A file of one triangle that uses an extension.
fn using(name: &str) -> File {
    let mut file = File::triangle();
    file.json["extensionsUsed"] = json!([name]);
    file
}

fn requiring(name: &str) -> File {
    let mut file = using(name);
    file.json["extensionsRequired"] = json!([name]);
    file
}

#[test]
fn positions_may_be_bytes_and_shorts() {
    // corners (0, 0, 0), (most, 0, 0) and (0, least, 0), each padded to a multiple of four bytes
    let shorts = |most: i16, least: i16| {
        let all = [0, 0, 0, 0, most, 0, 0, 0, 0, least, 0, 0];
        all.iter().flat_map(|x: &i16| x.to_le_bytes()).collect::<Vec<u8>>()
    };
    let bytes = |most: u8, least: u8| vec![0, 0, 0, 0, most, 0, 0, 0, 0, least, 0, 0];
    for (kind, data, [x, y], [share_x, share_y]) in [
        (5120, bytes(127, 0x80), [127.0, -128.0], [1.0, -1.0]),
        (5121, bytes(255, 51), [255.0, 51.0], [1.0, 0.2]),
        (5122, shorts(32767, -32768), [32767.0, -32768.0], [1.0, -1.0]),
        (5123, shorts(-1, 13107), [65535.0, 13107.0], [1.0, 0.2]),
    ] {
        for (is_normalized, [x, y]) in [(false, [x, y]), (true, [share_x, share_y])] {
            let mut file = requiring("KHR_mesh_quantization");
            let positions = file.accessor("VEC3", kind, 3, &data);
            file.json["bufferViews"][positions]["byteStride"] = json!(data.len() / 3);
            file.json["accessors"][positions]["normalized"] = json!(is_normalized);
            *file.attributes() = json!({"POSITION": positions});
            file.json["nodes"][0]["scale"] = json!([2, 2, 2]);
            let scene = file.load().unwrap();
            let expected = [[0.0; 3], [2.0 * x, 0.0, 0.0], [0.0, 2.0 * y, 0.0]];
            for (vertex, expected) in scene.vertices.iter().zip(expected) {
                let far = vertex.distance(DVec3::from_array(expected));
                assert!(far <= 1e-7, "{kind} {is_normalized}: {vertex} instead of {expected:?}");
            }
            assert_eq!((file.found().0, file.warnings()), (1, String::new()));
        }
    }
}

/// A mesh of one triangle at three places.
fn instanced() -> File {
    let mut file = requiring("EXT_mesh_gpu_instancing");
    let places = file.floats("VEC3", &[0., 0., 0., 10., 0., 0., 0., 20., 0.]);
    let half = 0.5_f32.sqrt();
    #[rustfmt::skip]
    let turns = file.floats("VEC4", &[0., 0., 0., 1.,  0., 0., half, half,  0., 0., 0., 1.]);
    let sizes = file.floats("VEC3", &[1., 1., 1., 1., 1., 1., 2., 2., 2.]);
    let attributes = json!({"TRANSLATION": places, "ROTATION": turns, "SCALE": sizes});
    file.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    file
}

#[test]
fn a_mesh_is_placed_at_each_instance() {
    let mut file = instanced();
    file.json["nodes"][0]["translation"] = json!([0, 0, 7]);
    let (triangles, [min, max]) = file.found();
    // a quarter turn about z puts the second at 9 to 10; the third is twice as large
    assert_eq!(triangles, 3);
    assert!(DVec3::from_array(min).distance(DVec3::new(0.0, 0.0, 7.0)) < 1e-6, "{min:?}");
    assert!(DVec3::from_array(max).distance(DVec3::new(10.0, 22.0, 7.0)) < 1e-6, "{max:?}");
    let scene = file.load().unwrap();
    assert!(scene.vertices[5].distance(DVec3::new(9.0, 0.0, 7.0)) < 1e-6);
    assert_eq!((scene.instances.len(), scene.warnings.len()), (3, 0));
    assert!(scene.instances.iter().all(|instance| instance.object == 0));
    // hidden by scale
    let mut hidden = instanced();
    let sizes = hidden.floats("VEC3", &[1., 1., 1., 0., 0., 0., 2., 2., 2.]);
    hidden.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
        json!(sizes);
    assert_eq!(hidden.found().0, 2);
    assert!(hidden.warnings().contains("1 meshes that are scaled to nothing"));
}

#[test]
fn broken_and_huge_lists_of_instances_are_refused() {
    let change = |attribute: &str, value: Value| {
        let mut file = instanced();
        let extension = &mut file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"];
        extension["attributes"][attribute] = value;
        file.refusal()
    };
    assert!(change("SCALE", json!(77)).contains("accessor 77, expected one of 4"));
    assert!(change("SCALE", json!(2)).contains("accessor 2 (scales of instances)"));
    assert!(change("SCALE", json!("x")).contains("gltf reports"));
    let mut file = instanced();
    file.json["accessors"][3]["count"] = json!(2);
    assert!(file.refusal().contains("attributes of 3 and of 2 instances"));
    // a million places from no bytes, of a thousand vertices, at a hundred nodes
    let bomb = |scale: bool, vertices: usize| {
        let mut file = instanced();
        let [places, positions] = [1 << 20, vertices].map(|count| file.zeros(count));
        let attribute = if scale { "SCALE" } else { "TRANSLATION" };
        let node = json!({"mesh": 1, "extensions": {"EXT_mesh_gpu_instancing": {
            "attributes": {attribute: places}
        }}});
        file.push("meshes", json!({"primitives": [{"attributes": {"POSITION": positions}}]}));
        file.json["nodes"] = json!(vec![node; 100]);
        file.json["scenes"][0]["nodes"] = json!((0..100).collect::<Vec<_>>());
        file.refusal()
    };
    assert!(bomb(false, 1000).contains("vertices or triangles of all instances"));
    assert!(bomb(true, 3).contains("the number of instances"));
}

#[test]
fn extensions_that_are_not_read_are_named() {
    for name in ["KHR_materials_unlit", "EXT_texture_webp", "KHR_texture_transform"] {
        for file in [using(name), requiring(name)] {
            let said = format!("extension `{name}` is not applied: it touches no geometry");
            assert!(file.warnings().contains(&said), "{said}");
            assert_eq!(file.found().0, 1);
        }
    }
    assert!(using("ACME_shape").warnings().contains("extension `ACME_shape` is unknown"));
    let refusal = requiring("ACME_shape").refusal();
    assert!(refusal.contains("extensionsRequired: found `ACME_shape`"), "{refusal}");
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression"] {
        let mut file = using(name);
        assert!(file.warnings().contains("the copy that is not packed is"));
        assert_eq!(file.found().0, 1);
        assert!(requiring(name).refusal().contains(name));
        // there is no such copy
        file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        assert!(file.refusal().contains(&format!("a file that uses {name}")));
    }
}

#[test]
fn a_texture_may_have_its_image_in_an_extension() {
    let mut file = requiring("KHR_texture_basisu");
    file.json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
    file.json["images"] = json!([{"uri": "a.ktx2"}]);
    file.json["materials"] =
        json!([{"name": "wall", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let said = file.warnings();
    assert!(said.contains("material `wall` has its plain colour: texture `texture 0`"), "{said}");
    assert_eq!(file.found().0, 1);
}

#[test]
fn channels_without_a_node_are_ignored() {
    let mut file = using("KHR_animation_pointer");
    let pointer = json!({"pointer": "/materials/0/pbrMetallicRoughness/baseColorFactor"});
    file.json["animations"] = json!([{
        "samplers": [{"input": 0, "output": 0}],
        "channels": [{"sampler": 0, "target": {
            "path": "pointer", "extensions": {"KHR_animation_pointer": pointer}
        }}]
    }]);
    assert!(file.warnings().contains("KHR_animation_pointer"));
    assert_eq!(file.found().0, 1);
}
