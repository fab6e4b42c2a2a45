//! Extensions of glTF: those that are read, those that may be left out, those that may not.

use glam::DVec3;
use serde_json::{Value, json};

use crate::gltf_file::File;

/// A file of one triangle that uses an extension.
fn using(name: &str) -> File {
    let mut file = File::new();
    file.json["extensionsUsed"] = json!([name]);
    file.json["scenes"][0]["nodes"] = json!([0]);
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
            let attributes = &mut file.json["meshes"][0]["primitives"][0]["attributes"];
            *attributes = json!({"POSITION": positions});
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
        let zeros = |count: usize| json!({"componentType": 5126, "count": count, "type": "VEC3"});
        let accessors = file.json["accessors"].as_array_mut().unwrap();
        accessors.extend([zeros(1 << 20), zeros(vertices)]);
        let attribute = if scale { "SCALE" } else { "TRANSLATION" };
        let node = json!({"mesh": 1, "extensions": {"EXT_mesh_gpu_instancing": {
            "attributes": {attribute: 4}
        }}});
        let mesh = json!({"primitives": [{"attributes": {"POSITION": 5}}]});
        file.json["meshes"].as_array_mut().unwrap().push(mesh);
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
