//! Files that are damaged where it is no geometry, or written as no specification says, and what is
//! read in them: triangles, corners, and one warning for each kind.

use std::path::Path;

use scene_loading::scene_file::{SceneFile, Source};
use scene_loading::source::formats::{ReadOptions, parse_scene};
use scene_loading::{LoadError, Scene, Shape};

use crate::warnings;

fn load(name: &str, bytes: &[u8]) -> Result<Scene, LoadError> {
    parse_scene(&Path::new("no-such-folder").join(name), bytes.into(), ReadOptions::default())
}

/// Triangles of a scene; a polygon of `k` corners counts as `k - 2`.
fn triangles(scene: &Scene) -> usize {
    let of = |shape| match shape {
        Shape::Polygon { count, .. } => count as usize - 2,
        _ => 1,
    };
    scene.primitives.iter().map(|p| of(p.shape)).sum()
}

/// Loads a file, and checks its triangles and that its warnings are these.
fn check(name: &str, bytes: &[u8], expected: usize, said: &[&str]) -> Scene {
    let text = String::from_utf8_lossy(bytes);
    let scene = load(name, bytes).unwrap_or_else(|error| panic!("{text}\n{error}"));
    assert_eq!(triangles(&scene), expected, "{text}");
    assert_eq!(warnings(&scene), said, "{text}");
    assert!(scene.vertices.iter().chain(&scene.normals).all(|v| v.is_finite()), "{text}");
    scene
}

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn obj_geometry_wins_over_decoration() {
    let flat = "invalid normals: their faces are flat";
    let lost = "invalid indices of normals: their faces are flat";
    let plain = "invalid texture coordinates: their faces have the plain colour";
    let unusable = "vertices with a coordinate or weight that is not usable";
    let ahead = "faces before their vertices: indices count from the file's start";
    let vn = "vn 0 0 1\nvn nan 0 0\nvn 0 1\nvn 1e200 0 0\nf 1//1 2//1 3//1\nf 1//1 2//2 3//1\n";
    let v = "v nan 0 0\nv 1 -inf 0\nv -nan(ind) 0 0\nv 1e300 0 0\nv 1 1 1 0\nf 1 2 3\n";
    for (text, expected, count, what, line) in [
        (vn, 2, 3, flat, 6),
        ("vn 0 0 1\nvn 1.#QNAN 0 0\nf 1//1 2//1 3//1\n", 1, 1, flat, 6),
        ("vt 0 nan\nvt\nvt x\nf 1/1 2/2 3/3\n", 1, 3, plain, 5),
        ("vn 0 0 1\nf 1//0 2//1 3//1\nf 1//1 2//2 3//-2\n", 2, 3, lost, 6),
        ("f 1//9 2//9 3//9\n", 1, 3, lost, 5),
        ("usemtl\nf 1 2 3\nmtllib\nusemtl  \n", 1, 3, "usemtl or mtllib without a name", 5),
        ("f 1 2 3\nf 1 2\nf 1\nf\n", 1, 3, "faces with fewer than 3 corners left out", 6),
        (v, 1, 5, unusable, 5),
        ("f 1 2 5\nf 1 3 -1\nv 0 0 1\n", 2, 1, ahead, 5),
    ] {
        let said = format!("a.obj: {count} {what} (first: line {line})");
        check("a.obj", (QUAD.to_owned() + text).as_bytes(), expected, &[&said]);
    }
    let text = format!("{QUAD}vn 0 0 1\nvn nan 0 0\nf 1//1 2//1 3//1\nf 1//1 2//2 3//1\n");
    let shapes = load("a.obj", text.as_bytes()).unwrap().primitives;
    assert!(matches!(shapes[0].shape, Shape::Patch { .. }));
    assert!(matches!(shapes[1].shape, Shape::Triangle { .. }));
    // a face with such a corner has no surface
    check(
        "a.obj",
        format!("v 0 nan 0\n{QUAD}f 1 2 3\nf 2 3 4\nf 1 2 3 4\n").as_bytes(),
        1,
        &[
            "a.obj: 2 faces with a corner that is not usable left out (first: line 6)",
            "a.obj: 1 vertices with a coordinate or weight that is not usable (first: line 1)",
        ],
    );
    // indices ahead must mean something in the end
    for (text, line) in [("f 1 2 6\nv 0 0 1\n", 5), ("f 1 2 3\nf 1 2 3 4\nf 9 1 2\nf 8 1 2\n", 7)] {
        let error = load("a.obj", (QUAD.to_owned() + text).as_bytes()).unwrap_err();
        assert!(matches!(error, LoadError::IndexOutOfRange { .. }), "{error}");
        assert!(error.to_string().contains(&format!("a.obj:{line}: vertex index")), "{error}");
    }
    // normals ahead, of which one never comes
    let text = format!("{QUAD}f 1//1 2//2 3//1\nf 1//1 2//1 3//1\nvn 0 0 1\n");
    let said = "a.obj: 1 invalid indices of normals: their faces are flat (first: line 5)";
    let scene = check("a.obj", text.as_bytes(), 2, &[said]);
    assert!(matches!(scene.primitives[0].shape, Shape::Triangle { .. }));
    assert!(matches!(scene.primitives[1].shape, Shape::Patch { .. }));
}

#[test]
fn comments_and_names_swallow_no_line() {
    let said = |line: usize, count: usize| {
        format!(
            "a.obj: {count} comments or names that end in `\\`: they end with their line \
             (first: line {line})"
        )
    };
    for (text, line) in [
        (format!("# C:\\out\\\n{QUAD}f 1 2 3\n"), 1),
        (format!("{QUAD}f 1 2 3 # C:\\out\\\nf 1 3 4\n"), 5),
        (format!("{QUAD}g C:\\out\\  \nf 1 2 3\n"), 5),
        (format!("{QUAD}f 1 \\\n2 3 # \\\r\nf 1 3 4\n"), 5),
    ] {
        let expected = text.matches("f 1").count();
        check("a.obj", text.as_bytes(), expected, &[&said(line, 1)]);
    }
    // numbers go on, with blanks behind the backslash, too
    check("a.obj", format!("{QUAD}f 1 2 \\ \t\r\n 3 \\\n4\n").as_bytes(), 2, &[]);
}

#[test]
fn lines_end_in_any_way_and_a_mark_is_no_text() {
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
               endloop\nendfacet\nendsolid a\n";
    let ply = "ply\nformat ascii 1.0\ncomment x\nelement vertex 3\nproperty float x\n\
               property float y\nproperty float z\nelement face 1\n\
               property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let nff = "# old\nv\nfrom 0 0 9\nat 0 0 0\nup 0 1 0\nangle 45\nhither 0\nresolution 8 8\n\
               p 3\n0 0 0\n1 0 0\n0 1 0\n";
    let pbrt = "# old\nShape \"trianglemesh\" # here\n\"point3 P\" [0 0 0 1 0 0 0 1 0]\n";
    let obj = format!("# old\n{QUAD}f 1 2 3\n");
    for (name, text) in
        [("a.obj", obj.as_str()), ("a.stl", stl), ("a.ply", ply), ("a.nff", nff), ("a.pbrt", pbrt)]
    {
        let plain = check(name, text.as_bytes(), 1, &[]);
        for end in ["\n", "\r", "\r\n"] {
            for mark in ["", "\u{feff}"] {
                let text = mark.to_owned() + &text.replace('\n', end);
                assert_eq!(load(name, text.as_bytes()).unwrap(), plain, "{text:?}");
            }
        }
        // only some lines end in CR
        assert_eq!(load(name, text.replacen('\n', "\r", 2).as_bytes()).unwrap(), plain, "{name}");
        let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        for wide in [[&b"\xff\xfe"[..], &wide].concat(), wide] {
            let error = load(name, &wide).unwrap_err().to_string();
            let expected = format!("no-such-folder/{name}:1: found `UTF-16 text`");
            assert!(error.starts_with(&expected), "{error}");
        }
        // errors count such lines, too
        let damaged = text.replacen("0 1 0", "0 one 0", 1);
        let line = damaged.lines().position(|line| line.contains("one")).unwrap() + 1;
        for end in ["\n", "\r", "\r\n"] {
            let error = load(name, damaged.replace('\n', end).as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with(&format!("no-such-folder/{name}:{line}:")), "{error}");
        }
    }
}

#[test]
fn outlines_that_cross_themselves_have_the_area_that_they_enclose() {
    let tie = "0 0 0\n1 1 0\n1 0 0\n0 1 0\n";
    let obj = format!("{}f 1 2 3 4\n", tie.lines().map(|v| format!("v {v}\n")).collect::<String>());
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
         {tie}4 0 1 2 3\n"
    );
    let nff = format!("v from 0 0 9 at 0 0 0 up 0 1 0 angle 45 resolution 8 8\np 4\n{tie}");
    for (name, text, place) in
        [("a.obj", obj, "line 5"), ("a.ply", ply, "line 14"), ("a.nff", nff, "line 2")]
    {
        let said =
            format!("{name}: 1 faces that cross themselves split at the crossing (first: {place})");
        for triangulate in [false, true] {
            let path = Path::new("no-such-folder").join(name);
            let options = ReadOptions { triangulate, ..ReadOptions::default() };
            let scene = parse_scene(&path, text.clone().into(), options).unwrap();
            assert_eq!(warnings(&scene), [said.as_str()]);
            let area = |shape| {
                let o = scene.outline(shape);
                (o[1] - o[0]).cross(o[2] - o[0]).length() / 2.0
            };
            let areas: Vec<f64> = scene.primitives.iter().map(|p| area(p.shape)).collect();
            assert_eq!(areas, [0.25; 2], "{name}");
        }
    }
}

#[test]
fn nff_polygons_that_are_bent_are_split_and_patches_may_lack_normals() {
    let view = "v from 0 0 9 at 0 0 0 up 0 1 0 angle 45 resolution 8 8\n";
    let bent = format!("{view}p 4\n0 0 0\n1 0 0\n1 1 1\n0 1 0\n");
    let said = "a.nff: 1 faces that are not flat split (first: line 2)";
    let scene = check("a.nff", bent.as_bytes(), 2, &[said]);
    assert!(scene.is_triangles_only());
    let text = format!("{view}pp 3\n0 0 0 0 0 1\n1 0 0 nan 0 0\n0 1 0 0 1e200 -nan(ind)\n");
    let said = "a.nff: 3 invalid normals: their faces are flat (first: line 4)";
    let scene = check("a.nff", text.as_bytes(), 1, &[said]);
    assert!(matches!(scene.primitives[0].shape, Shape::Triangle { .. }));
}

#[test]
fn polygons_of_scene_files_are_split_and_all_pieces_move() {
    let shape = |corners: &str, moves: u32| {
        format!(
            r#"{{"polygon": {{"vertices": {corners}, "material": "m", "velocity": [{moves}, 0, 0]}}}}"#
        )
    };
    let shapes = [
        shape("[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]", 0),
        shape("[[0,0,0],[1,0,0],[1,1,1],[0,1,0]]", 1),
        shape("[[0,0,0],[1,1,0],[1,0,0],[0,1,0]]", 2),
    ];
    let text = format!(
        r#"{{"name": "a", "title": "t", "why": "w", "materials": {{"m": {{}}}},
            "source": {{"shapes": [{}]}}}}"#,
        shapes.join(",")
    );
    let path = Path::new("a.json");
    let file = SceneFile::parse(path, &text).unwrap();
    let Source::Shapes(shapes) = &file.source else { panic!() };
    let scene = file.inline(path, shapes).unwrap();
    let moves: Vec<f64> = (0..5).map(|id| scene.velocity(id).x).collect();
    assert_eq!((triangles(&scene), moves), (6, vec![0.0, 1.0, 1.0, 2.0, 2.0]));
    assert_eq!(
        warnings(&scene),
        [
            "a.json: 1 faces that are not flat split",
            "a.json: 1 faces that cross themselves split at the crossing",
        ]
    );
}

fn ply(vertex: &str, list: &str, data: &str) -> Vec<u8> {
    let vertices = data.lines().filter(|line| !line.starts_with('f')).count();
    let faces = data.lines().count() - vertices;
    format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\n{vertex}element face {faces}\n{list}\n\
         end_header\n{}",
        data.replace("\nf ", "\n")
    )
    .into_bytes()
}

#[test]
fn ply_files_as_they_are_found() {
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let normals = format!("{xyz}property float nx\nproperty float ny\nproperty float nz\n");
    let list = "property list uchar int vertex_indices";
    let corners = "0 0 0\n1 0 0\n0 1 0\n";
    for (vertex, list, data, said) in [
        (xyz, "property list uchar int64 vertex_indices", "f 3 0 1 2\n", vec![]),
        (xyz, "property list uint64 uint64 vertex_index", "f 3 0 1 2\n", vec![]),
        (xyz, "property list uchar float vertex_indices", "f 3 0 1 2\n", vec![]),
        (&xyz.to_uppercase(), "PROPERTY LIST UCHAR INT Vertex_Indices", "f 3 0 1 2\n", vec![]),
        (
            xyz,
            list,
            "nan 0 0\nf 3 0 1 2\n",
            vec!["a.ply: 1 vertices with a coordinate that is not usable (first: line 13)"],
        ),
        (
            xyz,
            list,
            "nan 0 0\n1 -inf 0\n1 1e300 0\nf 3 0 1 2\nf 3 0 1 3\nf 4 0 1 2 5\n",
            vec![
                "a.ply: 2 faces with a corner that is not usable left out (first: line 17)",
                "a.ply: 3 vertices with a coordinate that is not usable (first: line 13)",
            ],
        ),
    ] {
        let bytes = ply(vertex, list, &(corners.to_owned() + data));
        check("a.ply", &bytes, 1, &said);
    }
    let data = "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n1 1 0 nan 0 0\nf 3 0 1 2\nf 3 1 2 3\n";
    let said = "a.ply: 1 invalid normals: their faces are flat (first: line 16)";
    let scene = check("a.ply", &ply(&normals, list, data), 2, &[said]);
    assert!(matches!(scene.primitives[0].shape, Shape::Patch { .. }));
    assert!(matches!(scene.primitives[1].shape, Shape::Triangle { .. }));
    let float = "property list uchar float vertex_indices";
    for (list, face, part) in [
        (float, "3 0 1 1.5", "a.ply:13: vertex index 1.5 is out of range"),
        (float, "3 0 1 nan", "a.ply:13: vertex index NaN is out of range"),
        (float, "3 0 1 -1", "a.ply:13: vertex index -1 is out of range"),
        (list, "3 0 1", "a.ply:14: the file ends where the index of a vertex (face 1 of 1) was"),
        ("property list char int vertex_indices", "-1 0 1 2", "a.ply:13: the length of the list"),
    ] {
        let data = format!("{corners}f {face}\n");
        let error = load("a.ply", &ply(xyz, list, &data)).unwrap_err().to_string();
        assert!(error.contains(part), "{face}: {error}");
    }
}

/// A binary STL file of triangles in a fan, with these attribute bytes and as long a payload as
/// they say, if any.
fn binary_stl(count: u32, triangles: u32, attributes: u16, payload: bool) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(count.to_le_bytes());
    for i in 0..triangles {
        bytes.extend([0; 12]);
        for [x, y] in [[0, 0], [1, i], [1, i + 1]] {
            bytes.extend([x as f32, y as f32, 0.0].iter().flat_map(|v| v.to_le_bytes()));
        }
        bytes.extend(attributes.to_le_bytes());
        bytes.resize(bytes.len() + if payload { attributes.into() } else { 0 }, 0x7e);
    }
    bytes
}

#[test]
fn binary_stl_files_whose_length_says_more_than_their_number() {
    let number = |stated: u32, there: u32| {
        format!(
            "a.stl: the header states {stated} triangles, the file's length fits {there} (byte 80)"
        )
    };
    let payload =
        |bytes: u32| format!("a.stl: {bytes} bytes of attributes behind triangles left out");
    let behind =
        |bytes, at| format!("a.stl: {bytes} bytes after the last triangle left out (byte {at})");
    let nan = {
        let mut bytes = binary_stl(3, 3, 0, false);
        bytes[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
        bytes
    };
    let left_out = "a.stl: 1 faces with a corner that is not usable left out (first: byte 134)";
    for (bytes, expected, said) in [
        (binary_stl(4, 4, 0x7fff, false), 4, vec![]),
        (binary_stl(0, 4, 0, false), 4, vec![number(0, 4)]),
        (binary_stl(u32::MAX, 4, 0, false), 4, vec![number(u32::MAX, 4)]),
        (binary_stl(i32::MAX as u32, 4, 9, false), 4, vec![number(i32::MAX as u32, 4)]),
        (binary_stl(20, 20, 30, true), 20, vec![payload(600)]),
        (binary_stl(20, 20, 1, true), 20, vec![payload(20)]),
        ([binary_stl(4, 4, 0x7fff, false), vec![7; 9]].concat(), 4, vec![behind(9, 284)]),
        ([binary_stl(4, 4, 0, false), vec![7; 90]].concat(), 4, vec![behind(90, 284)]),
        (nan, 2, vec![left_out.to_owned()]),
    ] {
        let said: Vec<&str> = said.iter().map(String::as_str).collect();
        let scene = check("a.stl", &bytes, expected, &said);
        assert!(scene.vertices.iter().all(|v| v.x <= 1.0 && v.y <= 20.0), "{:?}", scene.vertices);
    }
    for (bytes, part) in [
        (binary_stl(5, 4, 0, false), "byte 80: the number of triangles is 5, but at most 4"),
        (binary_stl(u32::MAX - 1, 4, 0, false), "is 4294967294, but at most 4"),
        // attributes that lead to an end before that of the data: neither reading is sure
        ([binary_stl(4, 4, 2, true), vec![7; 9]].concat(), "byte 80: found `217 bytes for 4 tri"),
    ] {
        let error = load("a.stl", &bytes).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    assert!(matches!(
        load("a.stl", &binary_stl(0, 0, 0, false)),
        Err(LoadError::NoPrimitives { .. })
    ));
}

#[test]
fn stl_texts_as_they_are_found() {
    let facet = |end: &str| {
        format!(
            "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
             {end}loop\n{end}facet\n"
        )
    };
    let two = format!("solid a part\n{0}{0}endsolid a part\n", facet("end"));
    let missing = "a.stl: `endsolid` is missing: is the file cut off?";
    let nan = "a.stl: 1 faces with a corner that is not usable left out (first: line 2)";
    for (text, expected, said) in [
        (two.clone(), 2, vec![]),
        (two.replace('\n', " "), 2, vec![]),
        (two.replace('\n', " ").repeat(2), 4, vec![]),
        (two.to_uppercase(), 2, vec![]),
        (format!("solid facet\n{}end solid facet\n", facet("end ")), 1, vec![]),
        (format!("# made by hand\n{}", facet("end")), 1, vec![]),
        (format!("solid\n{}", facet("end")), 1, vec![missing]),
        (two.replacen("vertex 1 0 0", "vertex 1 -nan(ind) 1.#INF", 1), 1, vec![nan]),
    ] {
        check("a.stl", text.as_bytes(), expected, &said);
    }
    for (cut, line) in [("endfacet\nendsolid", 15), ("vertex 0 1 0\nendloop\nendfacet\nends", 13)] {
        let at = two.find(cut).unwrap();
        let error = load("a.stl", &two.as_bytes()[..at]).unwrap_err();
        assert!(matches!(error, LoadError::UnexpectedEnd { .. }), "{error}");
        assert!(error.to_string().contains(&format!("a.stl:{line}: ")), "{error}");
    }
    let error = load("a.stl", two.replacen("endloop", "end face", 1).as_bytes()).unwrap_err();
    assert!(error.to_string().contains("a.stl:7: found `face`, expected loop"), "{error}");
}
