//! The OBJ reader: what it accepts, and the error of every way a file can be wrong.

use std::path::Path;

use glam::DVec3;
use scene_loading::obj::{ObjOptions, parse_obj};
use scene_loading::{LoadError, Scene, Shape};

use crate::{folder, shapes, triangles, warning, warnings};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn parse_with(text: &str, triangulate: bool) -> Result<Scene, LoadError> {
    parse_obj(Path::new("dir/test.obj"), text.as_bytes().to_vec(), ObjOptions { triangulate })
}

fn parse(text: &str) -> Result<Scene, LoadError> {
    parse_with(text, false)
}

/// The error of a text, after checking that its message names the file and the line.
fn error_at(text: &str, line: usize) -> LoadError {
    let error = parse(text).expect_err(text);
    let message = error.to_string();
    assert!(message.starts_with(&format!("dir/test.obj:{line}:")), "{message}");
    error
}

#[test]
fn triangles_share_vertices_and_keep_their_order() {
    let text = format!("{TRIANGLE}v 1 1 0\ng one\nf 1 2 3\ng two\nf -1 -2 -3\n");
    let scene = parse(&text).unwrap();
    assert_eq!(scene.vertices.len(), 4);
    assert_eq!(triangles(&scene), [[0, 1, 2], [3, 2, 1]]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.name, "test");
}

#[test]
fn corners_with_normals_are_patches_and_others_stay_flat() {
    let text =
        format!("{TRIANGLE}vn 0 0 1\nvn 0 1 1\nvt 0.5\nf 1/1/2 2/1/1 3/1/1\nf 1//1 2 3//1\n");
    let scene = parse(&text).unwrap();
    let [Shape::Patch { n, .. }, Shape::Triangle { .. }] = shapes(&scene)[..] else {
        panic!("{:?}", scene.primitives)
    };
    assert_eq!(scene.normals[n[0] as usize], DVec3::new(0.0, 1.0, 1.0));
    assert_eq!(scene.normals[n[1] as usize], DVec3::Z);
}

#[test]
fn concave_faces_are_polygons_or_split_without_gain() {
    let text = "v 0 0 0\nv 2 0 0\nv .2 .2 0\nv 0 2 0\nf 2 3 4 1\n";
    let scene = parse(text).unwrap();
    let [Shape::Polygon { first, count: 4 }] = shapes(&scene)[..] else { panic!() };
    assert_eq!(scene.vertices[first as usize], DVec3::new(2.0, 0.0, 0.0));
    let scene = parse_with(text, true).unwrap();
    assert!(scene.is_triangles_only());
    let area: f64 = scene
        .primitives
        .iter()
        .map(|p| scene.outline(p.shape))
        .map(|o| (o[1] - o[0]).cross(o[2] - o[0]).length() / 2.0)
        .sum();
    assert!((area - 0.4).abs() < 1e-12, "{area}");
}

#[test]
fn bent_faces_are_split_with_a_warning() {
    let scene = parse("v 0 0 0\nv 1 0 0\nv 1 1 .5\nv 0 1 0\n\nf 1 2 3 4\n").unwrap();
    assert_eq!(scene.primitives.len(), 2);
    assert!(scene.is_triangles_only());
    assert_eq!(warning(&scene), "dir/test.obj: 1 faces that are not flat split (first: line 6)");
}

#[test]
fn faces_without_area_lines_and_points_are_counted() {
    let text = format!(
        "{TRIANGLE}f 1 2 3\nf 1 1 2\nf 1 2 1\nl 1 2 3 1\nl 1 2\np 1\nfoo 1\ncurv 0 1 1 2\n"
    );
    let scene = parse(&text).unwrap();
    assert_eq!(scene.primitives.len(), 1);
    assert_eq!(
        warnings(&scene),
        [
            "dir/test.obj: 2 faces without area left out (first: line 5)",
            "dir/test.obj: 2 line elements left out",
            "dir/test.obj: 1 point elements left out",
            "dir/test.obj: 1 free-form curves and surfaces left out",
            "dir/test.obj:10: 1 lines with unknown keywords (first: `foo`)",
        ]
    );
}

#[test]
fn oddly_written_files_load() {
    // Continuations, CRLF, tabs, comments behind data, vertex colours, weights, two usemtl forms.
    let text = "v 0 0 \\\n 0 # zero\r\n\tv\t2 0 0 2\r\nv 0 1 0 0.5 0.5 0.5\r\n  usemtl\tred one \r\n\
                f 1 2 \\\r\n3 # face\r\nusemtl red one\nf 3 2 1\n#comment\n#\n";
    let scene = parse(text).unwrap();
    assert_eq!(scene.vertices, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(scene.primitives.len(), 2);
    assert_eq!(scene.materials[scene.primitives[0].material as usize].name, "red one");
    assert_eq!(scene.primitives[0].material, scene.primitives[1].material);
    // A line number behind a continuation counts the lines of the file.
    error_at("v 0 0 \\\n 0\nv 0 0 x\n", 3);
}

#[test]
fn latin_1_comments_load() {
    let bytes = [b"# caf\xe9\n".as_slice(), TRIANGLE.as_bytes(), b"f 1 2 3"].concat();
    assert!(parse_obj(Path::new("x.obj"), bytes, ObjOptions::default()).is_ok());
}

#[test]
fn indices_out_of_range() {
    for bad in [
        "f 0 1 2",
        "f 1 2 5",
        "f 1 2 -4",
        "f 1 2 9223372036854775807",
        "f 1 2 -9223372036854775808",
        "f 1 2 99999999999999999999999",
    ] {
        let error = error_at(&format!("{TRIANGLE}{bad}\nv 5 5 5\n"), 4);
        assert!(matches!(error, LoadError::IndexOutOfRange { .. }), "{bad}: {error}");
    }
}

#[test]
fn malformed_faces() {
    for bad in ["f 1 2 x", "f 1 2 3/1/1/1", "f /1 2 3", "f 1 2 3.5", "f 1 2 -", "f 1/x 2 3"] {
        let error = error_at(&format!("{TRIANGLE}{bad}"), 4);
        let fine = matches!(error, LoadError::Syntax { .. } | LoadError::IndexOutOfRange { .. });
        assert!(fine, "{bad}: {error}");
    }
}

#[test]
fn malformed_and_non_finite_positions() {
    for bad in ["v 0 0", "v", "v 0 0 zero", "v 0 0 0x10", "v 0,0,0", "v 0 0 0 w", "v 1\u{a0}2 3 4"]
    {
        assert!(matches!(error_at(bad, 1), LoadError::Syntax { .. }), "{bad}");
    }
    for bad in ["nan 0 0", "0 inf 0", "0 0 -Infinity", "1e400 0 0", "1e200 0 0", "0 0 0 nan"] {
        let text = format!("v {bad}\n{TRIANGLE}f 2 3 4\nf 1 2 3\n");
        assert_eq!(parse(&text).unwrap().primitives.len(), 1, "{bad}");
        let error = parse(&text.replace("f 2 3 4\n", "")).unwrap_err();
        assert!(matches!(error, LoadError::NoPrimitives { .. }), "{bad}: {error}");
    }
}

#[test]
fn files_without_faces() {
    for text in ["", "\n\n", "# nothing", TRIANGLE, "v 0 0 0\nf 1 1 1"] {
        assert!(matches!(parse(text), Err(LoadError::NoPrimitives { .. })), "{text}");
    }
}

#[test]
fn materials_are_read_and_mapped() {
    let obj =
        format!("mtllib a.mtl\n{TRIANGLE}usemtl glass\nf 1 2 3\nusemtl grey\nf 3 2 1\nf 1 2 3");
    let mtl = b"# caf\xe9\nnewmtl grey\nKd 0.5\nKs 0.5\nNs 10\nillum 2\nmap_Kd x.png\nKe 1\n\
                newmtl glass\nKd 0.1 0.2 0.3\nKs .3 .6 .9\nNi 1.5\nd 0.25\nillum 4\n";
    let (_folder, path) = folder(&[("a.obj", obj.as_bytes()), ("a.mtl", mtl)]);
    let scene = crate::load(&path.join("a.obj")).unwrap();
    let [grey, glass] = &scene.materials[..] else { panic!("{:?}", scene.materials) };
    assert_eq!((grey.name.as_str(), grey.color, grey.specular), ("grey", [0.5; 3], 0.0));
    assert_eq!((glass.color, glass.transmittance), ([0.1, 0.2, 0.3], 0.75));
    assert!((glass.specular - 0.6).abs() < 1e-12);
    assert_eq!((glass.refraction_index, grey.refraction_index), (1.5, 1.0));
    let used: Vec<u32> = scene.primitives.iter().map(|p| p.material).collect();
    assert_eq!(used, [1, 0, 0]);
    assert!(warning(&scene).contains("a.mtl:7: material `grey` has its plain colour"));
}

#[test]
fn a_missing_material_file_is_a_warning_that_names_it() {
    let text = format!(
        "mtllib lost.mtl\nmtllib ../x.mtl\n{TRIANGLE}usemtl red\nf 1 2 3\nusemtl blue\nf 1 2 3"
    );
    let scene = parse(&text).unwrap();
    assert_eq!(
        warnings(&scene),
        [
            "dir/test.obj:1: material file dir/lost.mtl is missing",
            "dir/test.obj:2: mtllib `../x.mtl` leads out of the folder; not read",
            "dir/test.obj: 2 undefined materials get the default: \
             `red` (line 6), `blue` (line 8)",
        ]
    );
    // Each keeps its name, so that a scene file can give it a colour.
    assert_eq!(scene.materials[1].name, "blue");
    assert_eq!(scene.primitives[1].material, 1);
}

#[test]
fn damaged_materials_are_warnings_with_their_first_line() {
    // of the default material
    const GREY: [f64; 3] = [0.7; 3];
    for (mtl, said, color, transmittance) in [
        (
            "newmtl a\nKd 0.5 0.5\nKd\nKs 1 2 3 4\nNs many\nillum 11\nillum 1.5\nKd nan 0 0\nd inf\nnewmtl\nKd 1\n",
            "9 damaged lines left out (first: line 2)",
            GREY,
            0.0,
        ),
        (
            "Kd 1 1 1\nnewmtl a\nKd .5 0 0\nskin_C.jpg\n",
            "1 damaged lines left out (first: line 1)",
            [0.5, 0.0, 0.0],
            0.0,
        ),
        (
            "newmtl a\nTr 0.25\nd 0.5\n",
            "1 materials whose d and Tr differ: d counts (first: line 1)",
            GREY,
            0.5,
        ),
        (
            "newmtl a\nd 1.0\nTr 1.0\n",
            "1 materials whose d and Tr differ: d counts (first: line 1)",
            GREY,
            0.0,
        ),
        ("newmtl a\nd 0.25\nTr 0.75\n", "", GREY, 0.75),
        (
            "newmtl b\nnewmtl a\nTr 1\nillum 2\n",
            "1 materials with Tr 1 that do not refract taken \
            as opaque (first: line 2)",
            GREY,
            0.0,
        ),
        ("newmtl a\nTr 1\nillum 6\n", "", GREY, 1.0),
        (
            "newmtl a\nd 0\n",
            "1 materials with d 0 that do not refract: they are invisible \
            (first: line 1)",
            GREY,
            1.0,
        ),
        ("\u{feff}newmtl a\rKd 0 1 0\r", "", [0.0, 1.0, 0.0], 0.0),
    ] {
        let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl a\nf 1 2 3");
        let (_folder, path) = folder(&[("a.obj", &*obj), ("a.mtl", mtl)]);
        let scene = crate::load(&path.join("a.obj")).unwrap();
        let said = Some(said).filter(|said| !said.is_empty());
        let file = path.join("a.mtl").display().to_string();
        let expected: Vec<String> = said.iter().map(|said| format!("{file}: {said}")).collect();
        assert_eq!(warnings(&scene), expected, "{mtl}");
        let material = &scene.materials[scene.primitives[0].material as usize];
        assert_eq!((material.color, material.transmittance), (color, transmittance), "{mtl}");
    }
}

#[test]
fn material_files_are_found_as_they_are_named() {
    let (_folder, path) = folder(&[
        ("one.mtl", "newmtl red\n"),
        ("two words.mtl", "newmtl blue\n"),
        ("plain", "newmtl blue\n"),
        ("in/one.mtl", "newmtl red\nnewmtl blue\n"),
    ]);
    for (line, missing) in [
        ("one.mtl two words.mtl", 0),
        ("two words.mtl one.mtl # both", 0),
        ("plain one.mtl", 0),
        ("in\\one.mtl", 0),
        (".\\in\\one.mtl # with a comment", 0),
        ("one.mtl lost.mtl plain", 1),
        ("lost.mtl one.mtl", 2),
        ("..\\one.mtl plain", 2),
        ("in", 3),
    ] {
        let text =
            format!("mtllib {line}\n{TRIANGLE}usemtl red # one\nf 1 2 3\nusemtl blue\nf 1 2 3\n");
        std::fs::write(path.join("a.obj"), text).unwrap();
        let scene = crate::load(&path.join("a.obj")).unwrap();
        let undefined = scene.warnings.iter().filter(|w| w.0.contains("undefined materials"));
        let undefined: usize = undefined.map(|w| w.0.matches("(line").count()).sum();
        let files = scene.warnings.iter().filter(|w| w.0.contains("a.obj:1: ")).count();
        assert_eq!(undefined + files, missing, "{line}: {:?}", scene.warnings);
    }
}

#[test]
fn every_cut_of_a_file_is_an_error_or_a_scene() {
    let text = format!(
        "mtllib x.mtl\n{TRIANGLE}v 1 1 \\\n0 1\nvn 0 0 1\nvt 0 0\nusemtl a\ng b\nf 1/1/1 2/1/1 3/1/1\nl 1 2\nf 1 2 4 3\n"
    );
    for cut in 0..text.len() {
        let _ = parse(&text[..cut]);
        let mut bytes = text.clone().into_bytes();
        for replacement in [b'\n', b'\\', b' ', b'-', b'9', b'\t', 0xe9] {
            bytes[cut] = replacement;
            let _ = parse_obj(Path::new("x.obj"), bytes.clone(), ObjOptions::default());
        }
    }
}

#[test]
fn zstd_files_load() {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    let text = format!("{TRIANGLE}f 1 2 3");
    let bytes = compress_to_vec(text.as_bytes(), CompressionLevel::Fastest);
    let (_folder, path) = folder(&[("b.obj.zst", bytes)]);
    let scene = crate::load(&path.join("b.obj.zst")).unwrap();
    assert_eq!((scene.name.as_str(), scene.primitives.len()), ("b", 1));
}
