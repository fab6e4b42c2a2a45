//! The readers of PLY, STL and tinybvh's triangles: what they accept, and the error of every way a
//! file can be wrong.

use std::fmt::Write as _;
use std::path::Path;

use scene_loading::ply::parse_ply;
use scene_loading::stl::parse_stl;
use scene_loading::triangle_soup::parse_triangle_soup;
use scene_loading::{LoadError, Scene, Shape};

use crate::{check_faults, triangles, warnings};

const QUAD: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

fn ply(bytes: &[u8]) -> Result<Scene, LoadError> {
    parse_ply(Path::new("dir/a.ply"), bytes, false)
}

fn stl(bytes: &[u8]) -> Result<Scene, LoadError> {
    parse_stl(Path::new("dir/a.stl"), bytes.to_vec())
}

fn soup(bytes: &[u8]) -> Result<Scene, LoadError> {
    parse_triangle_soup(Path::new("dir/a.bin"), bytes)
}

/// A PLY of a quadrangle and a triangle, with properties and elements that are left out, in the
/// words of that encoding.
fn two_faces(format: &str, indices: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment made by hand\nobj_info nothing\nelement vertex 4\n\
         property float x\nproperty float y\nproperty uchar red\nproperty double z\n\
         property list uchar short around\nelement edge 1\nproperty int vertex1\n\
         property int vertex2\nelement face 2\nproperty int8 flag\n\
         property list uint8 int32 {indices}\nproperty list ushort float texcoord\n\
         element empty 3\nend_header\n"
    )
    .into_bytes();
    let mut put = Put { format, bytes: &mut bytes };
    for [x, y, z] in QUAD {
        put.f32(x).f32(y).u8(255).f64(f64::from(z)).u8(2).i16(-1).i16(7);
    }
    put.i32(0).i32(1);
    put.u8(9).u8(4).i32(0).i32(1).i32(2).i32(3).u16(1).f32(0.5);
    put.u8(9).u8(3).i32(0).i32(2).i32(3).u16(0);
    bytes
}

/// Writes numbers in an encoding of PLY.
struct Put<'a> {
    format: &'a str,
    bytes: &'a mut Vec<u8>,
}

macro_rules! put {
    ($($type:ident),*) => {$(
        fn $type(&mut self, value: $type) -> &mut Self {
            match self.format {
                "ascii" => self.bytes.extend(format!("{value}\n").bytes()),
                "binary_little_endian" => self.bytes.extend(value.to_le_bytes()),
                _ => self.bytes.extend(value.to_be_bytes()),
            }
            self
        }
    )*};
}

impl Put<'_> {
    put!(u8, i16, u16, i32, f32, f64);
}

const FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

#[test]
fn all_encodings_of_ply_are_the_same_scene() {
    let first = ply(&two_faces(FORMATS[0], "vertex_index")).unwrap();
    assert_eq!(first.primitives.len(), 2);
    assert!(matches!(first.primitives[0].shape, Shape::Polygon { count: 4, .. }));
    assert_eq!(first.primitives[1].shape, Shape::Triangle { v: [0, 2, 3] });
    assert_eq!(first.vertices[2].to_array(), [1.0, 1.0, 0.0]);
    assert!(first.warnings.is_empty(), "{:?}", first.warnings);
    for format in FORMATS {
        for indices in ["vertex_indices", "vertex_index", "corners"] {
            assert_eq!(ply(&two_faces(format, indices)).unwrap(), first, "{format} {indices}");
        }
        let split = parse_ply(Path::new("a.ply"), &two_faces(format, "vertex_index"), true);
        assert_eq!(split.unwrap().primitives.len(), 3);
    }
}

#[test]
fn all_types_of_ply_are_read() {
    for scalar in [
        "char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16", "int", "int32",
        "uint", "uint32", "float", "float32", "double", "float64",
    ] {
        for format in FORMATS {
            let mut bytes = format!(
                "ply\r\nformat {format} 1.0\r\nelement vertex 3\r\nproperty {scalar} x\r\n\
                 property {scalar} y\r\nproperty {scalar} z\r\nelement face 1\r\n\
                 property list uchar uint vertex_indices\r\nend_header\r\n"
            )
            .into_bytes();
            let mut put = Put { format, bytes: &mut bytes };
            for value in [0_u8, 0, 0, 100, 0, 0, 0, 100, 0] {
                match scalar {
                    "char" | "int8" | "uchar" | "uint8" => put.u8(value),
                    "short" | "int16" | "ushort" | "uint16" => put.i16(value.into()),
                    "int" | "int32" | "uint" | "uint32" => put.i32(value.into()),
                    "float" | "float32" => put.f32(value.into()),
                    _ => put.f64(value.into()),
                };
            }
            put.u8(3).i32(0).i32(1).i32(2);
            let scene = ply(&bytes).unwrap_or_else(|error| panic!("{format} {scalar}: {error}"));
            assert_eq!(scene.vertices[2].to_array(), [0.0, 100.0, 0.0], "{format} {scalar}");
        }
    }
}

const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
                      property float y\nproperty float z\n";
const FACES: &str = "element face 1\nproperty list uchar int vertex_index\nend_header\n";
const CORNERS: &str = "0 0 0\n1 0 0\n0 1 0\n";

#[test]
fn normals_strips_and_faces_without_area() {
    let normals = "property float nx\nproperty float ny\nproperty float nz\n";
    let text = format!("{HEADER}{normals}{FACES}0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 1 1\n3 0 1 2\n");
    let scene = ply(text.as_bytes()).unwrap();
    assert_eq!(scene.primitives[0].shape, Shape::Patch { v: [0, 1, 2], n: [0, 1, 2] });
    let strips = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let header = HEADER.replace("vertex 3", "vertex 5");
    let text = format!("{header}{strips}{CORNERS}1 1 0\n2 2 5\n9 0 1 2 3 -1 4 3 2 -1\n");
    let scene = ply(text.as_bytes()).unwrap();
    assert_eq!(triangles(&scene), [[0, 1, 2], [2, 1, 3], [4, 3, 2]]);
    let text = format!(
        "{}{CORNERS}3 0 1 2 2 0 1 3 0 1 1",
        (HEADER.to_owned() + FACES).replace("face 1", "face 3")
    );
    assert_eq!(
        warnings(&ply(text.as_bytes()).unwrap()),
        [
            "dir/a.ply: 1 faces without area left out (first: line 13)",
            "dir/a.ply: 1 faces with fewer than 3 corners left out (first: line 13)"
        ]
    );
}

#[test]
fn faults_of_ply_files_are_errors_with_their_line() {
    let text = format!("{HEADER}{FACES}{CORNERS}3 0 1 2\n");
    assert!(ply(text.as_bytes()).is_ok());
    let faults = [
        ("ply\n", "plz\n", ":1:", "expected ply"),
        ("ascii 1.0", "ascii 2.0", ":2:", "version 1.0"),
        ("ascii", "binary", ":2:", "binary_little_endian"),
        ("format ascii 1.0\n", "", ":8:", "a format line"),
        ("element vertex 3", "element vertex", ":3:", "a number"),
        ("element vertex 3", "element vertex -3", ":3:", "a number"),
        ("element vertex 3", "element vertex 999999999999", ":3:", "at most"),
        ("element vertex 3", "element vortex 3", ":7:", "element vertex before"),
        ("element face 1", "element face 100", ":7:", "at most"),
        ("property float y", "property half y", ":5:", "one of char"),
        ("property float y", "property float w", ":3:", "x, y and z"),
        ("property float y", "property list uchar float y", ":3:", "x, y and z"),
        ("property list uchar int", "property list float int", ":8:", "whole-number"),
        ("uchar int vertex_index", "uchar float corners", ":7:", "vertex_indices"),
        ("property list uchar int vertex_index", "property color", ":8:", "property TYPE NAME"),
        ("element vertex 3\n", "", ":3:", "element before property"),
        ("end_header\n", "and so on\n", ":9:", "end_header"),
        ("1 0 0\n", "1 zero 0\n", ":11:", "a number (y)"),
        ("3 0 1 2", "3 0 1 3", ":13:", "0 to 2"),
        ("3 0 1 2", "3 0 1 -1", ":13:", "0 to 2"),
        ("3 0 1 2", "3 0 1 1.5", ":13:", "a whole number"),
        ("3 0 1 2", "3 0 1", ":14:", "ends where"),
        ("3 0 1 2", "-3 0 1 2", ":13:", "at least 0"),
        ("3 0 1 2", "300 0 1 2", ":13:", "at most"),
        ("3 0 1 2", "3 0 1 1", ":", "no primitives"),
    ];
    check_faults(&text, "dir/a.ply", |text| ply(text.as_bytes()), &faults);
}

#[test]
fn every_cut_and_every_flipped_bit_of_a_binary_file_ends_in_a_scene_or_an_error_with_a_byte() {
    let little = two_faces(FORMATS[1], "vertex_index");
    for cut in 0..little.len() {
        let error = ply(&little[..cut]).expect_err("a part is no scene").to_string();
        assert!(error.starts_with("dir/a.ply"), "{error}");
    }
    let data = little.len() - 20;
    let error = ply(&little[..data]).unwrap_err().to_string();
    assert!(error.starts_with("dir/a.ply: byte "), "{error}");
    type Parse = fn(&[u8]) -> Result<Scene, LoadError>;
    let files: [(Parse, Vec<u8>); 3] =
        [(ply, little), (stl, binary_stl(b"solid", &[[0, 1, 2], [0, 2, 3]])), (soup, bin(2))];
    for (parse, bytes) in files {
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            if let Err(error) = parse(&flipped) {
                assert!(error.to_string().starts_with("dir/a."), "{error}");
            }
        }
    }
}

fn binary_stl(name: &[u8], triangles: &[[usize; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes[..name.len()].copy_from_slice(name);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flat_map(|&i| QUAD[i]).flat_map(f32::to_le_bytes));
        bytes.extend([7, 7]);
    }
    bytes
}

fn text_stl(triangles: &[[usize; 3]]) -> String {
    let mut text = "solid a name of\t# words\n".to_owned();
    for triangle in triangles {
        text += "  facet normal 0 0 nan\n    OUTER loop\n";
        for [x, y, z] in triangle.map(|i| QUAD[i]) {
            writeln!(text, "      vertex {x:e} {y} {z}").unwrap();
        }
        text += "    endloop\n  endfacet\n";
    }
    text + "endsolid a name of words"
}

#[test]
fn text_and_binary_stl_are_recognised_and_give_the_same_scene() {
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let expected = stl(text_stl(&triangles).as_bytes()).unwrap();
    assert_eq!((expected.primitives.len(), expected.vertices.len()), (2, 4));
    for name in [
        &b"made by hand"[..],
        b"solid",
        b"solid name of 80 bytes without any zero byte\
        that could say it is binary, to the brim",
    ] {
        let name = &name[..name.len().min(80)];
        assert_eq!(stl(&binary_stl(name, &triangles)).unwrap(), expected);
    }
    let mut longer = binary_stl(b"solid", &triangles);
    longer.extend(b"more");
    let scene = stl(&longer).unwrap();
    assert!(warnings(&scene)[0].contains("4 bytes after the last triangle"));
    let two = text_stl(&triangles[..1]) + "\n" + &text_stl(&triangles[1..]);
    assert_eq!(stl(two.as_bytes()).unwrap(), expected);
}

#[test]
fn faults_of_stl_files_are_errors_with_their_place() {
    let text = text_stl(&[[0, 1, 2]]);
    let faults = [
        ("facet", "facett", ":2:", "facet, solid or endsolid"),
        ("normal", "norm", ":2:", "normal"),
        ("loop", "loops", ":3:", "loop"),
        ("vertex 1e0 1 0\n", "", ":6:", "vertex"),
        ("vertex 1e0 1 0", "vertex 1e0 1 x", ":6:", "a number"),
        ("vertex 1e0 1 0", "vertex 1e0 1 0\nvertex 1 1 1", ":7:", "endloop"),
        ("vertex 1e0 1 0", "vertex 0 0 0", ":", "no primitives"),
    ];
    check_faults(&text, "dir/a.stl", |text| stl(text.as_bytes()), &faults);
    let cut = &text.as_bytes()[..text.find("endloop").unwrap()];
    assert!(matches!(stl(cut), Err(LoadError::UnexpectedEnd { .. })));
    let whole = binary_stl(b"x", &[[0, 1, 2]]);
    for (bytes, part) in [
        (&whole[..83], "dir/a.stl: byte 83: the file ends"),
        (&whole[..133], "dir/a.stl: byte 80: the number of triangles is 1, but at most 0"),
        (b"", "dir/a.stl: byte 0: the file ends"),
    ] {
        let error = stl(bytes).unwrap_err().to_string();
        assert!(error.starts_with(part), "{error}");
    }
}

/// So many triangles of tinybvh's files, in a fan.
fn bin(count: u32) -> Vec<u8> {
    let mut bytes = count.to_le_bytes().to_vec();
    for i in 0..count as usize {
        for corner in [0, i + 1, i + 2] {
            bytes.extend(QUAD[corner].into_iter().flat_map(f32::to_le_bytes));
            bytes.extend([255, 255, 255, 0]);
        }
    }
    bytes
}

#[test]
fn tinybvhs_triangles_are_read_and_other_bin_files_are_refused() {
    let scene = soup(&bin(2)).unwrap();
    assert_eq!((scene.primitives.len(), scene.vertices.len()), (2, 4));
    assert_eq!(scene.primitives[1].shape, Shape::Triangle { v: [0, 2, 3] });
    for bytes in [&b""[..], b"abc", &bin(2)[..99], &[bin(2), vec![0]].concat(), b"\0\0\0\0\0"] {
        let error = soup(bytes).unwrap_err().to_string();
        assert!(error.starts_with("dir/a.bin: byte 0: found") && error.contains("48 n"), "{error}");
    }
    assert!(matches!(soup(&[0; 4]), Err(LoadError::NoPrimitives { .. })));
    let mut bytes = bin(1);
    bytes[20..24].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(
        soup(&bytes).unwrap_err().to_string().starts_with("dir/a.bin: byte 4: a corner is NaN")
    );
}
