//! The loader cases L1 to L10 of the project's catalogue of hard cases, one test each, by name.
//! (The tests `load_*` have the same faults in more variants.)

use std::path::Path;

use scene_loading::gltf::parse_gltf;
use scene_loading::nff::parse_nff;
use scene_loading::obj::{ObjOptions, parse_materials, parse_obj};
use scene_loading::{LoadError, Material, Scene};
use serde_json::{Value, json};

use crate::gltf_file::{File, set};
use crate::load_textures::png_that_claims;
use crate::{folder, warning, warnings};

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn obj(text: &[u8]) -> Result<Scene, LoadError> {
    parse_obj(Path::new("a.obj"), text.to_vec(), ObjOptions::default())
}

/// The error of an OBJ text, which must name that line.
fn obj_error(text: &str, line: usize) -> LoadError {
    let error = obj(text.as_bytes()).expect_err(text);
    assert!(error.to_string().starts_with(&format!("a.obj:{line}: ")), "{text:?}: {error}");
    error
}

/// The scene of an OBJ file beside other files.
fn beside(obj: &str, files: &[(&str, &[u8])]) -> Scene {
    let (_folder, path) = folder(&[&[("a.obj", obj.as_bytes())], files].concat());
    crate::load(&path.join("a.obj")).unwrap()
}

/// A document of one triangle, whose buffer is a data URI: three positions and three indices.
fn triangle() -> Value {
    let mut file = File::triangle();
    let indices = file.accessor("SCALAR", 5121, 3, &[0, 1, 2]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    file.document()
}

/// The document with one value set; the last key of the pointer may be new.
fn with(pointer: &str, value: Value) -> Value {
    set(triangle(), pointer, value)
}

fn gltf(document: &Value) -> Result<Scene, LoadError> {
    parse_gltf(Path::new("dir/a.gltf"), document.to_string().as_bytes())
}

/// The error of a document: typed, from the checks before the crate or from its validation, and
/// not from a panic.
fn gltf_error(document: &Value) -> LoadError {
    let error = gltf(document).expect_err(&document.to_string());
    let text = error.to_string();
    assert!(text.starts_with("dir/a.gltf: ") && !text.contains("panic"), "{text}");
    error
}

#[test]
fn l1_obj_indices_and_numbers() {
    for bad in [
        "f 0 1 2",
        "f 1 2 4",
        "f -4 1 2",
        "f 1 2 9223372036854775807",
        "f 1 2 -9223372036854775808",
        "f 1 2 9223372036854775808",
    ] {
        let error = obj_error(&format!("{CORNERS}\n{bad}\n"), 5);
        assert!(matches!(error, LoadError::IndexOutOfRange { .. }), "{bad}: {error}");
    }
    // What no face needs is counted, and never gets into a scene.
    for bad in
        ["v nan 0 0", "v 1e400 0 0", "v 0 -inf 0", "vn 0 0 nan", "v 1e99 0 0 1e-90", "f 1//9 2 3"]
    {
        let scene = beside(&format!("{CORNERS}{bad}\nf 1 2 3\n"), &[]);
        assert!(warning(&scene).ends_with("(first: line 4)"), "{}", warning(&scene));
        assert!(scene.vertices.iter().chain(&scene.normals).all(|v| v.is_finite()));
    }
}

#[test]
fn l2_mtl_of_one_number() {
    let path = Path::new("a.mtl");
    let grey = parse_materials(path, b"newmtl a\nKd 0.5\n".to_vec()).unwrap();
    assert_eq!(grey[0].color, [0.5; 3]);
    // Damaged lines are left out, and none of them panics.
    for (bad, materials) in [
        ("newmtl a\nKd 0.5 0.5\nKd\nKs 1 2 3 4\nNs\nd x\nillum -1\n", 1),
        ("newmtl \nKd 0.5\n", 0),
        ("Kd 1 1 1\nmap_Kd a.png\n", 0),
    ] {
        let read = parse_materials(path, bad.as_bytes().to_vec()).unwrap();
        assert_eq!(read.len(), materials, "{bad}");
        assert!(read.iter().all(|m| m.color == Material::default().color), "{bad}");
    }
    // The other things that stand in such files are no obstacle.
    let all = b"# x\nnewmtl a\nKa 1\nTf\nmap_bump -bm 1 x.png\nKe\nsharpness\nKd spectral x.rfl\n";
    assert_eq!(parse_materials(path, all.to_vec()).unwrap().len(), 1);
}

#[test]
fn l3_empty_missing_latin_1_and_continued() {
    for text in ["", "\n", "#", "\\", "\\\n"] {
        let parsed = obj(text.as_bytes());
        assert!(matches!(parsed, Err(LoadError::NoPrimitives { .. })), "{text:?}");
    }
    assert!(matches!(parse_nff(Path::new("a.nff"), ""), Err(LoadError::NoPrimitives { .. })));
    assert!(parse_gltf(Path::new("a.gltf"), b"").is_err());
    let scene = beside(&format!("mtllib lost.mtl\n{CORNERS}f 1 2 3\n"), &[]);
    assert!(warning(&scene).contains("lost.mtl is missing"), "{}", warning(&scene));
    let odd = b"# caf\xe9\nv 0 0 \\\r\n0\nv 1 0 0 # \xff\nv 0 1 0\nusemtl caf\xe9\nf 1 \\\n2 3\n";
    assert_eq!(obj(odd).unwrap().primitives.len(), 1);
}

#[test]
fn l4_gltf_that_panics_the_crate() {
    for (pointer, value) in [
        ("/accessors/1/componentType", json!(5126)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(77)),
        ("/meshes/0/primitives/0/indices", json!(77)),
        ("/buffers/0/uri", json!("%FF")),
        ("/buffers/0/uri", json!("data:;base64,%FF")),
        ("/cameras", json!([{"type": "perspective"}])),
        ("/nodes/0/skin", json!(5)),
        ("/scene", json!(5)),
    ] {
        let mut document = with(pointer, value);
        if document.get("cameras").is_some() {
            document["nodes"][0]["camera"] = json!(0);
        }
        gltf_error(&document);
    }
    // An image that cannot be had is a warning, and the surface keeps its plain colour.
    for image in [
        json!({}),
        json!({"bufferView": 99, "mimeType": "image/png"}),
        json!({"bufferView": 0}),
        json!({"uri": "%FF"}),
        json!({"uri": "data:image/png;base64,AAAA"}),
    ] {
        let mut document = with("/images", json!([image]));
        document["textures"] = json!([{"source": 0}]);
        document["materials"] =
            json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        document["meshes"][0]["primitives"][0]["material"] = json!(0);
        match gltf(&document) {
            Ok(scene) => assert!(warning(&scene).contains("plain colour"), "{image}"),
            Err(error) => assert!(!error.to_string().contains("panic"), "{image}: {error}"),
        }
    }
}

#[test]
fn l5_glb_that_claims_4_gib() {
    let mut file = b"glTF\x02\0\0\0\xff\xff\xff\xff\x10\0\0\0JSON{}              ".to_vec();
    let error = parse_gltf(Path::new("a.glb"), &file).unwrap_err();
    assert!(matches!(error, LoadError::GlbLength { declared: 0xffff_ffff, .. }), "{error}");
    // So may a chunk.
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    file[12..16].copy_from_slice(&[0xff; 4]);
    let error = parse_gltf(Path::new("a.glb"), &file).unwrap_err();
    assert!(!error.to_string().contains("panic"), "{error}");
    // And JSON may be small in the file and large in memory.
    let bomb = format!("{{\"nodes\":[{}]}}", "{},".repeat((2 << 20) + 1));
    let error = parse_gltf(Path::new("a.gltf"), bomb.as_bytes()).unwrap_err();
    assert!(matches!(error, LoadError::CountTooLarge { .. }), "{error}");
}

#[test]
fn l6_gltf_cycles_and_doubled_children() {
    let cycle = json!([{"mesh": 0, "children": [1]}, {"children": [0]}]);
    let itself = json!([{"mesh": 0, "children": [0]}]);
    let mut doubled: Vec<Value> = (1..=40).map(|i| json!({"children": [i, i]})).collect();
    doubled.push(json!({"mesh": 0}));
    for nodes in [cycle, itself, json!(doubled)] {
        let error = gltf_error(&with("/nodes", nodes));
        assert!(matches!(error, LoadError::NodeReachedTwice { .. }), "{error}");
    }
    // A long chain is no recursion: the stack of a test's thread would not hold it.
    let mut chain: Vec<Value> = (1..100_000).map(|i| json!({"children": [i]})).collect();
    chain.push(json!({"mesh": 0}));
    assert_eq!(gltf(&with("/nodes", json!(chain))).unwrap().primitives.len(), 1);
}

#[test]
fn l7_gltf_accessors_that_lie() {
    for (pointer, value) in [
        ("/accessors/0/count", json!(4)),
        ("/accessors/0/byteOffset", json!(8)),
        ("/bufferViews/0/byteLength", json!(35)),
        ("/bufferViews/1/byteOffset", json!(u64::MAX)),
        ("/buffers/0/byteLength", json!(41)),
    ] {
        let error = gltf_error(&with(pointer, value));
        assert!(matches!(error, LoadError::PastBuffer { .. }), "{pointer}: {error}");
    }
    // The bytes of 1.0 as indices: 0, 0, 128.
    let beyond = with("/bufferViews/1/byteOffset", json!(12));
    let error = gltf_error(&beyond);
    assert!(matches!(error, LoadError::IndexOutOfRange { .. }), "{error}");
    let zero = with("/nodes/0/matrix", json!([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]));
    assert!(matches!(gltf_error(&zero), LoadError::Gltf { .. }));
    // NaN positions: 0x7fc00000, little-endian, in base64, nine times.
    let nan = with(
        "/buffers/0/uri",
        json!(format!("data:;base64,{}AAECAA==", "AADAfwAAwH8AAMB/".repeat(3))),
    );
    let error = gltf_error(&nan);
    assert!(matches!(error, LoadError::NotFinite { .. }), "{error}");
    // Zeros that the file does not hold.
    let mut zeros = triangle();
    zeros["accessors"][0] = json!({
        "componentType": 5126, "count": 60_000_000, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1],
        "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121},
                   "values": {"bufferView": 0}}
    });
    let error = gltf_error(&zeros);
    assert!(matches!(error, LoadError::CountTooLarge { .. }), "{error}");
}

#[test]
fn l8_nothing_outside_the_folder_is_read() {
    for uri in ["../../x", "%2e%2e/x", "file:x", "file:///etc/passwd", "/dev/zero", "..\\x"] {
        let error = gltf_error(&with("/buffers/0/uri", json!(uri)));
        assert!(matches!(error, LoadError::OutsideFolder { .. }), "{uri}: {error}");
    }
    for map in ["../../x.png", "/dev/zero", "..\\x.png"] {
        let obj = format!("mtllib a.mtl\n{CORNERS}usemtl a\nf 1 2 3\n");
        let mtl = format!("newmtl a\nmap_Kd {map}\n");
        let scene = beside(&obj, &[("a.mtl", mtl.as_bytes())]);
        assert!(warning(&scene).contains("leads out of the folder"), "{}", warning(&scene));
    }
    for library in ["../a.mtl", "/etc/passwd"] {
        let scene = beside(&format!("mtllib {library}\n{CORNERS}f 1 2 3\n"), &[]);
        assert!(warning(&scene).contains("leads out of the folder"), "{}", warning(&scene));
    }
}

/// Links that lead out, and what is no file.
#[cfg(unix)]
#[test]
fn l8_links_and_devices() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    let link = |to: &str, name: &str| {
        std::os::unix::fs::symlink(to, folder.path().join(name)).unwrap();
    };
    link("/etc/passwd", "out.bin");
    link("/dev/zero", "zero.bin");
    std::fs::create_dir(folder.path().join("folder.bin")).unwrap();
    for (uri, is_outside) in [("out.bin", true), ("zero.bin", true), ("folder.bin", false)] {
        std::fs::write(&path, with("/buffers/0/uri", json!(uri)).to_string()).unwrap();
        let error = crate::load(&path).unwrap_err();
        assert_eq!(matches!(error, LoadError::OutsideFolder { .. }), is_outside, "{uri}: {error}");
        assert_eq!(matches!(error, LoadError::Io { .. }), !is_outside, "{uri}: {error}");
    }
    assert!(matches!(crate::load(Path::new("/dev/zero")), Err(LoadError::Io { .. })));
}

#[test]
fn l9_images_share_one_budget() {
    // Six images of 16,384 x 8,192 texels, 402 MB each once decoded, from a header alone.
    let bomb = png_that_claims([16_384, 8_192]);
    let names: Vec<String> = (0..6).map(|i| format!("{i}.png")).collect();
    let mut files: Vec<(&str, &[u8])> = names.iter().map(|n| (n.as_str(), &bomb[..])).collect();
    let mut obj = format!("mtllib a.mtl\n{CORNERS}vt 0 0\n");
    let mut mtl = String::new();
    for name in names.iter().map(String::as_str).chain(["lost.png"]) {
        obj.push_str(&format!("usemtl {name}\nf 1/1 2/1 3/1\n"));
        mtl.push_str(&format!("newmtl {name}\nmap_Kd {name}\n"));
    }
    files.push(("a.mtl", mtl.as_bytes()));
    let scene = beside(&obj, &files);
    assert_eq!((scene.primitives.len(), scene.textures.len()), (7, 0));
    let warnings = warnings(&scene);
    assert_eq!(warnings.len(), 7, "{warnings:?}");
    assert!(warnings[1..6].iter().all(|w| w.contains("of the 536870912")), "{warnings:?}");
    assert!(warnings[6].contains("lost.png"), "{warnings:?}");
}

#[test]
fn l10_nff_that_lies() {
    let error_of = |text: &str, line: usize| {
        let error = parse_nff(Path::new("a.nff"), text).expect_err(text);
        assert!(error.to_string().starts_with(&format!("a.nff:{line}: ")), "{text:?}: {error}");
        error
    };
    let cut = error_of("b 0 0 0\np 4\n0 0 0\n1 0 0\n1 1 0\n", 6);
    assert!(matches!(cut, LoadError::UnexpectedEnd { .. }), "{cut}");
    let negative = error_of("s 0 0 0 1\ns 0 0 0 -1\n", 2);
    assert!(matches!(negative, LoadError::OutOfRange { .. }), "{negative}");
    for count in ["4000000000", "18446744073709551615"] {
        let absurd = error_of(&format!("\np {count}\n0 0 0\n"), 2);
        assert!(matches!(absurd, LoadError::CountTooLarge { .. }), "{absurd}");
    }
    for (bad, line) in [("p -1\n", 1), ("p 2\n0 0 0\n1 0 0\n", 1), ("s 0 0 nan 1\n", 1)] {
        error_of(bad, line);
    }
}

/// What was read by tobj before is read as tobj read it.
#[test]
fn the_parser_agrees_with_tobj() {
    let mut state = 1_u64;
    let mut random = |below: u64| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    for case in 0..50 {
        let mut text = String::from("mtllib a.mtl\n");
        let (mut positions, mut normals) = (0, 0);
        for _ in 0..60 {
            match random(8) {
                0..=2 => {
                    let [x, y, z] = [random(1000), random(1000), random(1000)];
                    text.push_str(&format!("v {x}e-2 {y}.5 -{z}\n"));
                    positions += 1;
                }
                3 => {
                    text.push_str(&format!("vn {} 1 0\n", random(9)));
                    normals += 1;
                }
                4 => text.push_str(&format!("usemtl {}\n", ["a", "b"][random(2) as usize])),
                _ if positions >= 3 => {
                    let mut corner = || match (random(2), positions) {
                        (0, n) => format!("{}", 1 + random(n)),
                        (_, n) => format!("-{}", 1 + random(n)),
                    };
                    let corners = [corner(), corner(), corner()];
                    let normal = (normals > 0).then(|| format!("//{}", 1 + random(normals)));
                    let face = corners.map(|c| c + normal.as_deref().unwrap_or_default());
                    text.push_str(&format!("f {}\n", face.join(" ")));
                }
                _ => {}
            }
        }
        let names = ["a", "b"].map(|n| format!("newmtl {n}\n")).concat();
        let (_folder, path) = folder(&[("a.obj", &text), ("a.mtl", &names)]);
        let path = path.join("a.obj");
        let Ok(scene) = crate::load(&path) else { continue };
        let (models, _) = tobj::load_obj(&path, &tobj::LoadOptions::default()).unwrap();
        // tobj keeps faces without area, we leave them out
        let mut theirs = Vec::new();
        for tobj::Model { mesh, .. } in &models {
            for corners in mesh.indices.chunks(3) {
                let point =
                    |&i: &u32| glam::DVec3::from_slice(&mesh.positions[3 * i as usize..][..3]);
                let [a, b, c] = [0, 1, 2].map(|k| point(&corners[k]));
                if (b - a).cross(c - a).length() > 1e-9 {
                    theirs.push((vec![a, b, c], mesh.material_id.map(|id| ["a", "b"][id])));
                }
            }
        }
        let ours: Vec<_> = scene
            .primitives
            .iter()
            .map(|p| (scene.outline(p.shape), scene.materials[p.material as usize].name.as_str()))
            .map(|(outline, name)| (outline, (!name.is_empty()).then_some(name)))
            .collect();
        assert_eq!(ours, theirs, "case {case}\n{text}");
        let vertices: usize = models.iter().map(|m| m.mesh.positions.len() / 3).sum();
        assert_eq!(scene.vertices.len(), vertices, "case {case}\n{text}");
    }
}
