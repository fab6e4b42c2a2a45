//! What a second attack found (issue 14), by its numbers: files that took memory, time or paths
//! that they must not have.

use std::fmt::Write as _;
use std::path::Path;

use glam::DVec3;
use scene_loading::limits::{MAX_MATERIALS, MAX_NAME};
use scene_loading::nff::parse_nff;
use scene_loading::obj::{ObjOptions, parse_materials, parse_obj};
use scene_loading::scene_file::SceneFile;
use scene_loading::second_opinion::{SecondOpinion, second_opinion};
use scene_loading::tessellate::{TessellationOptions, tessellate, triangulate};
use scene_loading::{LoadError, Scene, Shape};

use crate::gltf_file::File;
use crate::{folder, resolved, warnings};

/// A triangle's corners and texture coordinates.
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";

const NFF: &str =
    "v\nfrom 0 0 9\nat 0 0 0\nup 0 1 0\nangle 45\nhither 0\nresolution 8 8\ns 0 0 0 1\n";

fn obj(text: &str) -> Result<Scene, LoadError> {
    parse_obj(Path::new("no-such-folder/a.obj"), text.into(), ObjOptions::default())
}

/// The error for an OBJ text, which must be refused at that line for being too much of something.
fn too_much(text: &str, line: usize) -> String {
    let error = obj(text).unwrap_err();
    assert!(matches!(error, LoadError::CountTooLarge { .. }), "{error}");
    let said = error.to_string();
    assert!(said.starts_with(&format!("no-such-folder/a.obj:{line}: ")), "{said}");
    said
}

#[test]
fn h1_a_library_is_read_once_and_a_material_once() {
    let libraries = ["a.mtl", "./a.mtl", "b.mtl"].map(|name| format!("mtllib {name}\n").repeat(50));
    let text = libraries.concat() + TRIANGLE + "usemtl m7\nf 1 2 3\n";
    let mut mtl = (0..100).fold(String::new(), |mut text, i| {
        writeln!(text, "newmtl m{i}\nKd 0 0 0\nmap_Kd lost.png").unwrap();
        text
    });
    let later = "newmtl m7\nKd 0.25 0 0\nnewmtl m7\nKd 0.5 0 0\n";
    let (_folder, path) = folder(&[("a.obj", &*text), ("a.mtl", &*mtl), ("b.mtl", later)]);
    let scene = crate::load(&path.join("a.obj")).unwrap();
    // of several the last counts, its missing map too
    assert_eq!((scene.materials.len(), scene.materials[7].color[0]), (100, 0.5));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // The planted fault: another order of the libraries gives another material.
    mtl.push_str("newmtl m100\n");
    let turned = text.replace("b.mtl", "c.mtl").replacen("./a.mtl", "b.mtl", 1);
    std::fs::write(path.join("a.obj"), turned.replace("mtllib ./a.mtl\n", "mtllib d.mtl\n"))
        .unwrap();
    std::fs::write(path.join("d.mtl"), mtl).unwrap();
    let scene = crate::load(&path.join("a.obj")).unwrap();
    assert_eq!((scene.materials.len(), scene.materials[7].color[0]), (101, 0.0));
}

#[test]
fn h1_materials_libraries_names_and_lines_have_limits() {
    let name = "n".repeat(MAX_NAME);
    assert!(obj(&format!("{TRIANGLE}usemtl {name}\nf 1 2 3\n")).is_ok());
    assert!(too_much(&format!("usemtl {name}x\n"), 1).contains("the length of a name"));
    assert!(too_much(&format!("\nmtllib {name}x\n"), 2).contains("the length of a name"));
    let libraries = (0..257).fold(String::new(), |text, i| text + &format!("mtllib {i}.mtl\n"));
    assert!(too_much(&libraries, 257).contains("the number of material files is 257"));
    let said = |text: String| {
        let error = parse_materials(Path::new("a.mtl"), text.into()).unwrap_err();
        assert!(matches!(error, LoadError::CountTooLarge { .. }), "{error}");
        error.to_string()
    };
    assert!(
        said(format!("newmtl a\nnewmtl {name}x\n")).starts_with("a.mtl:2: the length of a name")
    );
    let long = format!("newmtl a\nKd{}\n", " 1".repeat(40_000));
    assert!(said(long).starts_with("a.mtl:2: the length of a line is 80002"));
    // An unknown word of any length, a name that is no number: messages stay short.
    let scene = obj(&format!("{TRIANGLE}f 1 2 3\n{}\n", "w".repeat(1 << 20))).unwrap();
    assert!(scene.warnings[0].0.len() < 200, "{}", scene.warnings[0].0.len());
    for bad in [format!("v 0 0 1{}\n", "0".repeat(1 << 20)), format!("f {}\n", "9".repeat(1 << 20))]
    {
        assert!(obj(&bad).unwrap_err().to_string().len() < 300);
    }
}

#[test]
fn h1_as_many_materials_as_fit_into_a_small_file_are_refused_at_their_line() {
    let count = MAX_MATERIALS + 1;
    let mut text = String::with_capacity(16 * count);
    for i in 0..count {
        writeln!(text, "usemtl {i:x}").unwrap();
    }
    assert!(too_much(&text, count).contains("the number of materials is 1048577"));
}

#[test]
fn h2_outlines_that_cross_themselves_everywhere_end() {
    let mut random = Random(5);
    for n in [10, 300, 1000, 20_000] {
        let tangle: Vec<DVec3> =
            (0..n).map(|_| DVec3::new(random.next(), random.next(), random.next())).collect();
        let triangles = triangulate(&tangle).unwrap();
        assert!(triangles.len() <= n - 2, "{n}");
        let mut text = String::new();
        for v in &tangle {
            writeln!(text, "v {} {} {}", v.x, v.y, v.z).unwrap();
        }
        let all: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
        let scene = obj(&format!("{text}f {}\n", all.join(" "))).unwrap();
        assert_eq!(scene.primitives.len(), triangles.len());
    }
}

#[test]
fn h2_a_polygon_beyond_the_limits_is_refused_with_file_and_line() {
    // 4 Mi corners are taken; the indices of this face are all the same few.
    let corners = (4 << 20) + 1;
    let face = format!("{TRIANGLE}f{}\n", " 1".repeat(corners));
    assert!(too_much(&face, 5).contains("the number of corners of a face is 4194305"));
    let nff = format!("{NFF}p {corners}\n{}", "0 0 0\n".repeat(10));
    let error = parse_nff(Path::new("a.nff"), &nff).unwrap_err().to_string();
    assert!(error.starts_with("a.nff:9: the vertex count of a polygon is 4194305"), "{error}");
    let (mut scene, material) = Scene::of_one_material("a");
    scene.push_polygon(material, &vec![DVec3::ZERO; corners]);
    let error = tessellate(&scene, &TessellationOptions::default()).unwrap_err().to_string();
    assert!(error.starts_with("primitive 0 is a polygon of 4194305 corners"), "{error}");
}

#[test]
fn h6_an_image_that_fails_is_read_once_a_file() {
    // A file of 32 MiB that is no image, 2,000 materials, and several ways to write its name: read
    // again for each, it would use up the 512 MiB that images may have at the sixteenth.
    let count = 2000;
    let (mut text, mut mtl) = (format!("mtllib a.mtl\n{TRIANGLE}"), String::new());
    for i in 0..count {
        writeln!(text, "usemtl m{i}\nf 1/1 2/1 3/1").unwrap();
        writeln!(mtl, "newmtl m{i}\nmap_Kd {}big.png", "./".repeat(i % 4)).unwrap();
    }
    let big = vec![7; 32 << 20];
    let files =
        [("a.obj", text.as_bytes()), ("a.mtl", mtl.as_bytes()), ("big.png", big.as_slice())];
    let (_folder, path) = folder(&files);
    let scene = crate::load(&path.join("a.obj")).unwrap();
    let warnings = warnings(&scene);
    assert_eq!(warnings.len(), 101, "the others are counted");
    assert!(warnings[..100].iter().all(|w| w.ends_with("is not a PNG image")), "{}", warnings[99]);
    assert!(warnings[100].starts_with("1900 more materials"), "{}", warnings[100]);
    // The planted fault: as many files of that size are over the budget.
    let mut mtl = String::new();
    for i in 0..20 {
        std::fs::write(path.join(format!("{i}.png")), &big).unwrap();
        writeln!(mtl, "newmtl m{i}\nmap_Kd {i}.png").unwrap();
    }
    std::fs::write(path.join("a.mtl"), mtl).unwrap();
    let scene = crate::load(&path.join("a.obj")).unwrap();
    let said = |i: usize| scene.warnings[i].0.as_str();
    assert!(said(15).ends_with("is not a PNG image"), "{}", said(15));
    assert!(said(16).contains("larger than the limit of 0 bytes"), "{}", said(16));
}

#[test]
fn h9_sources_outside_the_folder_are_refused() {
    let file = |name: &str, source: &str| {
        let source = serde_json::json!({ "file": source });
        serde_json::json!({"name": name, "title": "t", "why": "w", "source": source}).to_string()
    };
    let (_folder, path) = folder(&[("scene.nff", NFF), ("in/scene.nff", NFF)]);
    let absolute = path.join("scene.nff");
    let write = |name: &str, source: &str| {
        std::fs::write(path.join(format!("in/{name}.json")), file(name, source)).unwrap();
        path.join(format!("in/{name}.json"))
    };
    let beside = write("beside", "scene.nff");
    assert_eq!(resolved(&beside).unwrap().load().unwrap().scene.primitives.len(), 1);
    for (name, source) in [("up", "../scene.nff"), ("root", absolute.to_str().unwrap())] {
        let json = write(name, source);
        let mut scene = resolved(&json).unwrap();
        for error in [scene.load().unwrap_err(), scene.second_opinion().unwrap_err()] {
            assert!(matches!(error, LoadError::OutsideSource { .. }), "{error}");
            let said = error.to_string();
            assert!(said.starts_with(json.to_str().unwrap()), "{said}");
            assert!(said.contains("--allow-outside"), "{said}");
        }
        scene.allow_outside();
        assert_eq!(scene.load().unwrap().scene.primitives.len(), 1, "{name}");
    }
}

#[cfg(unix)]
#[test]
fn h9_a_link_does_not_lead_out_of_the_folder() {
    let (_folder, path) = folder(&[("scene.nff", NFF), ("in/x", "")]);
    std::os::unix::fs::symlink("../scene.nff", path.join("in/link.nff")).unwrap();
    let json = r#"{"name": "a", "title": "t", "why": "w", "source": {"file": "link.nff"}}"#;
    std::fs::write(path.join("in/a.json"), json).unwrap();
    let error = resolved(&path.join("in/a.json")).unwrap().load().unwrap_err();
    assert!(matches!(error, LoadError::OutsideSource { .. }), "{error}");
}

#[test]
fn h10_a_bomb_is_refused_at_its_budget() {
    // A frame of blocks that each repeat a blank 131,072 times: 256 MiB from 8 KiB.
    let mut bytes = b"\x28\xb5\x2f\xfd\x00\x58".to_vec();
    for block in 0..2048_u32 {
        let header = (128 << 10 << 3) | (1 << 1) | u32::from(block == 2047);
        bytes.extend_from_slice(&header.to_le_bytes()[..3]);
        bytes.push(b' ');
    }
    let (_folder, path) = folder(&[("a.obj.zst", &bytes)]);
    let error = resolved(&path.join("a.obj.zst")).unwrap().load().unwrap_err();
    let expected = (64 << 20) + 200 * bytes.len() as u64;
    assert!(matches!(error, LoadError::Inflated { limit, .. } if limit == expected), "{error}");
    // The planted fault: of so few blocks that they fit, all blanks are unpacked.
    let frame = [&bytes[..6 + 4 * 100], &(((128 << 10 << 3) | 3_u32).to_le_bytes())[..3], b" "];
    std::fs::write(path.join("a.obj.zst"), frame.concat()).unwrap();
    let error = resolved(&path.join("a.obj.zst")).unwrap().load().unwrap_err();
    assert!(matches!(error, LoadError::NoPrimitives { .. }), "{error}");
}

#[test]
fn h13_a_file_called_like_a_generators_size_is_the_file() {
    let (_folder, path) = folder(&[("balls:2.nff", NFF), ("tree-tess:3.nff", NFF)]);
    // names are looked up from the current folder; the catalogue takes paths as well
    for name in ["balls:2.nff", "tree-tess:3.nff"] {
        let scene = resolved(&path.join(name)).unwrap().load().unwrap();
        assert_eq!(scene.scene.primitives.len(), 1, "{name}");
    }
    let said = resolved(Path::new("balls:2.nff")).and_then(|scene| scene.load()).unwrap_err();
    assert!(said.to_string().contains("no size `2.nff`"), "{said}");
}

#[test]
fn h14_a_hundred_thousand_lights_and_materials_load() {
    let n = 100_000;
    let lights: Vec<_> = (0..n).map(|i| serde_json::json!({"position": [i, 1, 1]})).collect();
    let names = (0..n).map(|i| format!("m{i}"));
    let materials: serde_json::Map<_, _> =
        names.clone().map(|name| (name, serde_json::json!({"diffuse": 0.5}))).collect();
    let shapes: Vec<_> = names
        .clone()
        .map(|name| serde_json::json!({"sphere": {"center": [0, 0, 0], "radius": 1, "material": name}}))
        .collect();
    let motion: Vec<_> =
        names.map(|name| serde_json::json!({"material": name, "velocity": [1, 0, 0]})).collect();
    let text = serde_json::json!({"name": "a", "title": "t", "why": "w", "lights": lights,
        "materials": materials, "source": {"shapes": shapes}, "motion": motion});
    let path = Path::new("a.json");
    let file = SceneFile::parse(path, &text.to_string()).unwrap();
    let scene_loading::scene_file::Source::Shapes(shapes) = &file.source else { panic!() };
    let mut scene = file.inline(path, shapes).unwrap();
    file.apply(path, &mut scene).unwrap();
    assert_eq!((scene.lights.len(), scene.materials.len()), (n, n));
    assert!(scene.materials.iter().all(|m| m.diffuse == 0.5));
    assert!(scene.velocities.len() == n && scene.velocities.iter().all(|v| *v == DVec3::X));
    let nff = NFF.to_owned() + &"l 1 2 3\n".repeat(n);
    assert_eq!(parse_nff(Path::new("a.nff"), &nff).unwrap().lights.len(), n);
}

#[test]
fn h19_a_gltf_that_requires_draco_says_so() {
    let draco = "KHR_draco_mesh_compression";
    let mut file = File::triangle();
    file.json["extensionsUsed"] = serde_json::json!([draco]);
    file.json["extensionsRequired"] = serde_json::json!([draco]);
    file.json["meshes"][0]["primitives"][0]["extensions"] =
        serde_json::json!({draco: {"bufferView": 0, "attributes": {"POSITION": 0}}});
    let said = file.refusal();
    assert!(said.contains("extensionsRequired: found `KHR_draco_mesh_compression`"), "{said}");
    assert!(said.contains("expected none but KHR_lights_punctual"), "{said}");
}

fn asked(path: &Path) -> (u64, Vec<String>) {
    crate::asked(path, std::fs::read(path).unwrap())
}

#[test]
fn a_second_reader_agrees_or_lists_differences() {
    let quads = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\n";
    let text = format!(
        "mtllib a.mtl\n{quads}usemtl red\nf 1 2 3 4\nf 1 1 2\nusemtl lost\nf 1 2 5\nf 1 2 3 5\n"
    );
    let (_folder, path) = folder(&[("a.obj", &*text), ("a.mtl", "newmtl red\n")]);
    assert_eq!(asked(&path.join("a.obj")), (5, vec![]));
    // Planted: for tobj a material must be known before it is used.
    let late = text.replace("mtllib a.mtl\n", "") + "mtllib a.mtl\n";
    std::fs::write(path.join("a.obj"), late).unwrap();
    let (triangles, differences) = asked(&path.join("a.obj"));
    let expected =
        ["no material: 3 triangles here, 5 by tobj", "material `red`: 2 triangles here, 0 by tobj"];
    assert_eq!((triangles, differences), (5, expected.map(String::from).to_vec()));
    // Planted: it panics on a colour of one number, and refuses what we do not read.
    std::fs::write(path.join("a.obj"), &text).unwrap();
    for (row, said) in [("Kd 0.5", "tobj refuses it: panic"), ("Ka x y z", "tobj cannot read")] {
        std::fs::write(path.join("a.mtl"), format!("newmtl red\n{row}\n")).unwrap();
        let (_, differences) = asked(&path.join("a.obj"));
        assert!(differences.iter().any(|d| d.starts_with(said)), "{row}: {differences:?}");
    }
    let pavilion = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/pavilion.glb");
    let (triangles, differences) = asked(&pavilion);
    assert!(triangles > 1000 && differences.is_empty(), "{triangles} {differences:?}");
    let nff = second_opinion(Path::new("a.nff"), NFF.into()).unwrap();
    assert_eq!(nff, SecondOpinion::NoReader);
    let large = vec![b'\n'; (64 << 20) + 1];
    assert_eq!(second_opinion(Path::new("a.obj"), large).unwrap(), SecondOpinion::TooLarge);
}

#[test]
fn what_scenes_a_polygon_makes_are_still_shapes() {
    // A flat polygon of many corners stays one; it is not cut up unless it must be.
    let n = 2000;
    let mut text = String::new();
    for i in 0..n {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
        writeln!(text, "v {cos} {sin} 0").unwrap();
    }
    let all: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
    let scene = obj(&format!("{text}f {}\n", all.join(" "))).unwrap();
    assert!(matches!(scene.primitives[0].shape, Shape::Polygon { count: 2000, .. }));
}

/// Numbers in [0, 1), by a linear congruential generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
