//! The glTF reader: what it accepts, and the error of every way a file can be wrong.

use std::path::Path;

use glam::DVec3;
use scene_loading::gltf::parse_gltf;
use scene_loading::{Light, LoadError, Scene, Shape};
use serde_json::{Value, json};

use crate::gltf_file::{self, chunk, set};
use crate::triangles;

/// A binary glTF of one JSON and one BIN chunk.
fn glb(document: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = serde_json::to_vec(document).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    gltf_file::glb(&[chunk(b"JSON", &text), chunk(b"BIN\0", bin)])
}

/// The bytes of the test buffer: 4 positions (48 bytes), 4 normals (48), 6 indices u16 (12),
/// sparse: 1 index u16 at 108, 1 position at 112.
fn buffer() -> Vec<u8> {
    let floats: [f32; 24] = [
        0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0., // positions
        0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1., // normals
    ];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 2, 1, 3].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend([3u16, 0].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend([5f32, 5., 5.].iter().flat_map(|f| f.to_le_bytes()));
    bytes
}

/// A document of one quadrangle in two triangles, under one node.
fn document() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 2}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 48},
            {"buffer": 0, "byteOffset": 96, "byteLength": 12},
            {"buffer": 0, "byteOffset": 108, "byteLength": 16}
        ],
        "buffers": [{"byteLength": 124}]
    })
}

fn parse(document: &Value) -> Result<Scene, LoadError> {
    parse_gltf(Path::new("dir/test.glb"), &glb(document, &buffer()))
}

/// Sets the value at a JSON pointer, adding the last key where it is missing.
fn with(pointer: &str, value: Value) -> Value {
    set(document(), pointer, value)
}

fn error_of(document: &Value) -> LoadError {
    let error = parse(document).expect_err(&document.to_string());
    assert!(error.to_string().starts_with("dir/test.glb: "), "{error}");
    error
}

#[test]
fn a_mesh_is_read() {
    let scene = parse(&document()).unwrap();
    assert_eq!(triangles(&scene), [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(scene.vertices[3], DVec3::new(1.0, 1.0, 0.0));
    assert!(scene.warnings.is_empty());
    assert_eq!(scene.materials.len(), 1);
}

#[test]
fn normals_make_patches() {
    let scene = parse(&with("/meshes/0/primitives/0/attributes/NORMAL", json!(1))).unwrap();
    assert!(matches!(scene.primitives[1].shape, Shape::Patch { v: [2, 1, 3], n: [2, 1, 3] }));
    assert_eq!(scene.normals, [DVec3::Z; 4]);
}

#[test]
fn strips_and_fans() {
    let mut strip = with("/meshes/0/primitives/0/mode", json!(5));
    strip["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
    let scene = parse(&strip).unwrap();
    assert_eq!(triangles(&scene), [[0, 1, 2], [1, 3, 2]]);
    strip["meshes"][0]["primitives"][0]["mode"] = json!(6);
    let scene = parse(&strip).unwrap();
    assert_eq!(triangles(&scene), [[1, 2, 0], [2, 3, 0]]);
    strip["meshes"][0]["primitives"][0]["mode"] = json!(1);
    assert!(matches!(error_of(&strip), LoadError::NoPrimitives { .. }));
}

#[test]
fn transforms_are_applied_down_the_tree() {
    let mut tree = with(
        "/nodes",
        json!([
            {"children": [1, 2], "translation": [10, 0, 0]},
            {"mesh": 0, "scale": [2, 2, 2]},
            {"mesh": 0, "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]}
        ]),
    );
    tree["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(1);
    let scene = parse(&tree).unwrap();
    assert_eq!(scene.primitives.len(), 4);
    assert_eq!(scene.vertices[3], DVec3::new(12.0, 2.0, 0.0));
    assert_eq!(scene.vertices[7], DVec3::new(9.0, 1.0, 5.0));
    // The mirrored instance winds the other way round; its normals still point up.
    assert_eq!(scene.normals, [DVec3::Z; 8]);
    for primitive in &scene.primitives {
        let o = scene.outline(primitive.shape);
        assert!((o[1] - o[0]).cross(o[2] - o[0]).z > 0.0);
    }
}

#[test]
fn materials_cameras_and_lights() {
    let mut full = document();
    full["materials"] = json!([
        {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0}},
        {"name": "mirror", "pbrMetallicRoughness": {"roughnessFactor": 0}},
        {"name": "glass", "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25]}}
    ]);
    full["meshes"][0]["primitives"][0]["material"] = json!(1);
    full["cameras"] = json!([
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 1}},
        {"type": "perspective", "perspective": {"aspectRatio": 1.5, "yfov": 0.5, "znear": 0.1}}
    ]);
    full["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    full["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "color": [1, 0.5, 0], "intensity": 40},
        {"type": "point", "intensity": 20},
        {"type": "directional"}
    ]}});
    let light = |i: u32| json!({"KHR_lights_punctual": {"light": i}});
    full["nodes"] = json!([
        {"mesh": 0},
        {"camera": 0},
        {"camera": 1, "translation": [0, 0, 5]},
        {"translation": [1, 2, 3], "extensions": light(0)},
        {"extensions": light(1)},
        {"extensions": light(2)}
    ]);
    full["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4, 5]);
    let scene = parse(&full).unwrap();
    let [red, mirror, glass] = &scene.materials[..] else { panic!("{:?}", scene.materials) };
    assert_eq!((red.color, red.diffuse, red.specular), ([1.0, 0.0, 0.0], 1.0, 0.0));
    assert_eq!((mirror.diffuse, mirror.specular), (0.0, 1.0));
    assert_eq!(glass.transmittance, 0.75);
    assert_eq!(scene.primitives[0].material, 1);
    assert_eq!(scene.camera.from, DVec3::new(0.0, 0.0, 5.0));
    assert_eq!(scene.camera.at, DVec3::new(0.0, 0.0, 4.0));
    assert_eq!(scene.camera.resolution, [768, 512]);
    assert!((scene.camera.angle - 0.5f64.to_degrees()).abs() < 1e-5);
    assert_eq!(
        scene.lights,
        [
            Light::point(DVec3::new(1.0, 2.0, 3.0), Some([1.0, 0.5, 0.0])),
            Light::point(DVec3::ZERO, Some([0.5; 3])),
        ]
    );
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
}

#[test]
fn sparse_accessors() {
    let mut sparse = document();
    sparse["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": 3, "byteOffset": 0, "componentType": 5123},
        "values": {"bufferView": 3, "byteOffset": 4}
    });
    let scene = parse(&sparse).unwrap();
    assert_eq!(scene.vertices[3], DVec3::splat(5.0));
    sparse["accessors"][0]["sparse"]["values"]["byteOffset"] = json!(8);
    assert!(matches!(error_of(&sparse), LoadError::PastBuffer { .. }));
    sparse["accessors"][0]["sparse"]["count"] = json!(9);
    assert!(matches!(error_of(&sparse), LoadError::Gltf { .. }));
}

#[test]
fn glb_lengths_are_checked() {
    let bytes = glb(&document(), &buffer());
    for length in [0u32, 11, 19, 0xffff_ffff, bytes.len() as u32 + 4] {
        let mut bad = bytes.clone();
        bad[8..12].copy_from_slice(&length.to_le_bytes());
        let error = parse_gltf(Path::new("x.glb"), &bad).unwrap_err();
        assert!(matches!(error, LoadError::GlbLength { .. }), "{length}: {error}");
    }
    for cut in 0..bytes.len() {
        assert!(parse_gltf(Path::new("x.glb"), &bytes[..cut]).is_err(), "{cut}");
    }
    // A chunk that claims more than the file has.
    let mut bad = bytes.clone();
    bad[12..16].copy_from_slice(&0xffff_fff0u32.to_le_bytes());
    assert!(matches!(parse_gltf(Path::new("x.glb"), &bad), Err(LoadError::PastBuffer { .. })));
}

#[test]
fn reading_past_a_buffer_is_an_error() {
    for (pointer, value) in [
        ("/accessors/0/count", json!(5)),
        ("/accessors/0/byteOffset", json!(4)),
        ("/accessors/0/byteOffset", json!(u64::MAX)),
        ("/bufferViews/0/byteLength", json!(47)),
        ("/bufferViews/0/byteOffset", json!(80)),
        ("/bufferViews/0/byteOffset", json!(u64::MAX)),
        ("/bufferViews/0/byteStride", json!(16)),
        ("/buffers/0/byteLength", json!(4_000_000_000u64)),
    ] {
        let error = error_of(&with(pointer, value));
        assert!(matches!(error, LoadError::PastBuffer { .. }), "{pointer}: {error}");
    }
    let error = error_of(&with("/accessors/0/count", json!(4_000_000_000u64)));
    assert!(matches!(error, LoadError::CountTooLarge { .. }), "{error}");
}

#[test]
fn wrong_types_and_shapes() {
    for (pointer, value) in [
        ("/accessors/2/componentType", json!(5126)), // float indices
        ("/accessors/0/componentType", json!(5125)),
        ("/accessors/0/type", json!("VEC2")),
        ("/accessors/2/type", json!("VEC3")),
        ("/accessors/0/normalized", json!(true)),
        ("/bufferViews/0/byteStride", json!(4)),
        ("/scenes", json!([])),
        ("/nodes/0/matrix", json!([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0])),
        ("/nodes/0/rotation", json!([0, 0, 0, 0])),
        ("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])),
    ] {
        let error = error_of(&with(pointer, value));
        let typed = matches!(error, LoadError::Gltf { .. } | LoadError::Parser { .. });
        assert!(typed && !error.to_string().contains("panic"), "{pointer}: {error}");
    }
}

#[test]
fn what_makes_the_crate_panic_is_an_error() {
    for (pointer, value) in [
        ("/images", json!([{}])),
        ("/images", json!([{"uri": "%FF"}])),
        ("/images", json!([{"bufferView": 99}])),
        ("/images", json!([{"bufferView": 0}])),
        ("/materials", json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 7}}}])),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(77)),
        ("/meshes/0/primitives/0/indices", json!(77)),
        ("/meshes/0/primitives/0/material", json!(3)),
        ("/meshes/0/primitives/0/mode", json!(9)),
        ("/cameras", json!([{"type": "perspective"}])),
        ("/nodes/0/camera", json!(4)),
        ("/accessors/0/count", json!(0)),
    ] {
        let mut document = with(pointer, value);
        if document.get("cameras").is_some() {
            document["nodes"][0]["camera"] = json!(0);
        }
        match parse(&document) {
            // Images are never read, so their faults do not matter.
            Ok(_) => assert_eq!(pointer, "/images"),
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("dir/test.glb") && !text.contains("panic"), "{text}");
            }
        }
    }
}

#[test]
fn indices_beyond_the_vertices() {
    let mut bytes = buffer();
    bytes[96] = 9;
    let error = parse_gltf(Path::new("a.glb"), &glb(&document(), &bytes)).unwrap_err();
    let LoadError::IndexOutOfRange { index, .. } = &error else { panic!("{error}") };
    assert_eq!(index, "9");
}

#[test]
fn non_finite_numbers() {
    for value in [f32::NAN, f32::INFINITY] {
        let mut bytes = buffer();
        bytes[4..8].copy_from_slice(&value.to_le_bytes());
        let error = parse_gltf(Path::new("a.glb"), &glb(&document(), &bytes)).unwrap_err();
        assert!(matches!(error, LoadError::NotFinite { .. }), "{error}");
    }
    let error = error_of(&with("/nodes/0/scale", json!([1e39, 1, 1])));
    assert!(matches!(error, LoadError::NotFinite { .. } | LoadError::Parser { .. }), "{error}");
}

#[test]
fn cycles_and_shared_nodes() {
    let cyclic = json!([{"mesh": 0, "children": [1]}, {"children": [0]}]);
    let error = error_of(&with("/nodes", cyclic));
    assert!(matches!(error, LoadError::NodeReachedTwice { node: 0, .. }), "{error}");
    // Forty doubled levels would be 2^40 visits.
    let mut nodes: Vec<Value> = (1..=40).map(|i| json!({"children": [i, i]})).collect();
    nodes.push(json!({"mesh": 0}));
    let error = error_of(&with("/nodes", json!(nodes)));
    assert!(matches!(error, LoadError::NodeReachedTwice { .. }), "{error}");
}

#[test]
fn buffers_stay_in_the_folder() {
    for uri in [
        "../secret.bin",
        "%2e%2e/secret.bin",
        "/dev/zero",
        "file:///etc/passwd",
        "file:secret.bin",
        "http://example.org/x.bin",
        "..\\secret.bin",
        "",
    ] {
        let text = with("/buffers/0/uri", json!(uri)).to_string();
        let error = parse_gltf(Path::new("dir/a.gltf"), text.as_bytes()).unwrap_err();
        assert!(matches!(error, LoadError::OutsideFolder { .. }), "{uri}: {error}");
    }
    for uri in ["%FF", "data:;base64,@@@@"] {
        let text = with("/buffers/0/uri", json!(uri)).to_string();
        let error = parse_gltf(Path::new("dir/a.gltf"), text.as_bytes()).unwrap_err();
        assert!(matches!(error, LoadError::Gltf { .. }), "{uri}: {error}");
    }
    let text = document().to_string();
    let error = parse_gltf(Path::new("a.gltf"), text.as_bytes()).unwrap_err();
    assert!(matches!(error, LoadError::Gltf { .. }), "{error}");
}

#[test]
fn buffers_from_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, with("/buffers/0/uri", json!("b%20c.bin")).to_string()).unwrap();
    let error = crate::load(&path).unwrap_err();
    assert!(matches!(error, LoadError::Io { .. }) && error.to_string().contains("b c.bin"));
    std::fs::write(folder.path().join("b c.bin"), buffer()).unwrap();
    assert_eq!(crate::load(&path).unwrap().primitives.len(), 2);
    std::fs::write(folder.path().join("b c.bin"), &buffer()[..50]).unwrap();
    assert!(matches!(crate::load(&path), Err(LoadError::PastBuffer { .. })));
}

#[test]
fn garbage_is_an_error() {
    for bytes in
        [&b""[..], b"{", b"null", b"glTF", b"{\"asset\":{\"version\":\"2.0\"}}", b"\xff\xfe"]
    {
        assert!(parse_gltf(Path::new("x.gltf"), bytes).is_err());
    }
}

#[test]
fn every_changed_byte_is_an_error_or_a_scene() {
    let mut document = document();
    document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(1);
    document["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]);
    document["nodes"][0]["camera"] = json!(0);
    let bytes = glb(&document, &buffer());
    for at in 12..bytes.len() {
        for value in [b'0', b'9', b'-', b'"', b'}', 0, 0xff] {
            let mut changed = bytes.clone();
            changed[at] = value;
            let result = parse_gltf(Path::new("x.glb"), &changed);
            if let Err(error) = result {
                assert!(!error.to_string().contains("panic"), "byte {at} = {value}: {error}");
            }
        }
    }
}
