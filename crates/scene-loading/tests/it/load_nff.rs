//! The NFF reader: what it accepts, and the error of every way a file can be wrong.

use std::io::Write;
use std::path::Path;

use glam::DVec3;
use scene_loading::nff::parse_nff;
use scene_loading::{Light, LoadError, Scene, Shape};

use crate::{folder, shapes};

const VIEW: &str = "v\nfrom 1 2 3\nat 0 0 0\nup 0 0 1\nangle 45\nhither 0.5\nresolution 320 200\n";

fn parse(text: &str) -> Result<Scene, LoadError> {
    parse_nff(Path::new("dir/test.nff"), text)
}

/// The error of a text, after checking that its message names the file and the line.
fn error_at(text: &str, line: usize) -> LoadError {
    let error = parse(text).expect_err(text);
    let message = error.to_string();
    assert!(message.starts_with(&format!("dir/test.nff:{line}:")), "{message}");
    error
}

#[test]
fn every_entity_is_read() {
    let text = format!(
        "# caf\u{e9}\nb 0.1 0.2 0.3\n{VIEW}l 1 2 3\nl 4 5 6 0.5 0.25 1\n\
         f 1 0.5 0.25 0.8 0.2 3 0.1 1.5\ns 1 2 3 0.5\n\
         c 0 0 0 1 0 0 2 0.5\nf 0 0 1 1 0 0 0 1\nc 0 0 0 -1 0 0 2 -1\n\
         p 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
         pp 3\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n"
    );
    let scene = parse(&text).unwrap();
    assert_eq!(scene.name, "test");
    assert_eq!(scene.background, [0.1, 0.2, 0.3]);
    assert_eq!(scene.camera.from, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!((scene.camera.angle, scene.camera.hither), (45.0, 0.5));
    assert_eq!(scene.camera.resolution, [320, 200]);
    assert_eq!(
        scene.lights,
        [
            Light::point(DVec3::new(1.0, 2.0, 3.0), None),
            Light::point(DVec3::new(4.0, 5.0, 6.0), Some([0.5, 0.25, 1.0])),
        ]
    );
    assert_eq!(scene.materials.len(), 2);
    assert_eq!(scene.materials[0].transmittance, 0.1);
    assert_eq!(
        shapes(&scene),
        [
            Shape::Sphere(0),
            Shape::Cone(0),
            Shape::Cone(1),
            Shape::Polygon { first: 0, count: 4 },
            Shape::Patch { v: [4, 5, 6], n: [0, 1, 2] },
        ]
    );
    let materials: Vec<u32> = scene.primitives.iter().map(|p| p.material).collect();
    assert_eq!(materials, [0, 0, 1, 1, 1]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn white_space_is_free() {
    let text = "v from 1 2\n\t3 at 0 0 0 up\r\n0 0 1 angle 45 resolution 8 8 s 0 0 # centre\n0 1";
    let scene = parse(text).unwrap();
    assert_eq!(scene.spheres.len(), 1);
    assert_eq!(scene.spheres[0].radius, 1.0);
    assert_eq!(scene.camera.hither, 0.0);
}

#[test]
fn a_missing_view_is_a_warning_and_frames_the_scene() {
    let scene = parse("s 5 5 5 1").unwrap();
    assert_eq!(scene.camera.at, DVec3::splat(5.0));
    assert!(scene.warnings[0].0.contains("dir/test.nff"), "{}", scene.warnings[0]);
}

#[test]
fn wide_patches_are_fanned_with_a_warning() {
    let corner = |x: i32, y: i32| format!("{x} {y} 0 0 0 1\n");
    let text =
        format!("{VIEW}\npp 4\n{}{}{}{}", corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
    let scene = parse(&text).unwrap();
    assert_eq!(scene.primitives.len(), 2);
    assert_eq!(scene.primitives[1].shape, Shape::Patch { v: [3, 4, 5], n: [3, 4, 5] });
    assert_eq!(
        scene.warnings[0].0,
        "dir/test.nff:9: a patch of 4 vertices was split into a fan of triangles"
    );
}

#[test]
fn unknown_words_name_the_valid_ones() {
    let error = error_at("s 0 0 0 1\nfish 1 2\n", 2);
    assert!(matches!(error, LoadError::Syntax { .. }));
    assert!(error.to_string().contains("`fish`") && error.to_string().contains("pp"));
}

#[test]
fn words_in_place_of_numbers_are_syntax_errors() {
    assert!(matches!(error_at("s 0 0 zero 1", 1), LoadError::Syntax { .. }));
    assert!(matches!(error_at("\n\np three", 3), LoadError::Syntax { .. }));
    assert!(matches!(error_at("p -3\n0 0 0", 1), LoadError::Syntax { .. }));
    // The third vertex is missing: the next entity stands in its place.
    let error = error_at("p 3\n0 0 0\n1 0 0\ns 0 0 0 1\n", 4);
    assert!(error.to_string().contains("vertex 3 of 3"), "{error}");
}

#[test]
fn non_finite_numbers_are_rejected() {
    for bad in ["nan", "NaN", "inf", "-inf", "infinity", "1e400"] {
        let error = error_at(&format!("s 0 0 0 1\ns 0 {bad} 0 1"), 2);
        assert!(matches!(error, LoadError::NotFinite { .. }), "{bad}: {error}");
    }
}

#[test]
fn truncated_files_are_errors() {
    let error = error_at("p 4\n0 0 0\n1 0 0\n1 1 0\n", 5);
    assert!(matches!(error, LoadError::UnexpectedEnd { .. }));
    assert!(error.to_string().contains("vertex 4 of 4"), "{error}");
    for text in ["s 0 0", "c 1 2 3 4 5", "f 1 1 1", "l", "b 0", "v from 1", "p", "pp 3\n0 0 0"] {
        assert!(matches!(error_at(text, text.lines().count()), LoadError::UnexpectedEnd { .. }));
    }
}

#[test]
fn every_truncation_of_a_file_is_an_error_or_a_scene() {
    let text = format!("{VIEW}f 1 1 1 1 0 0 0 1\ns 1 2 3 4\np 3\n0 0 0\n1 0 0\n0 1 0\n# end");
    for end in 0..text.len() {
        let _ = parse(&text[..end]);
    }
}

#[test]
fn impossible_counts_are_rejected_before_allocating() {
    for entity in ["p", "pp"] {
        for count in ["4000000000", "18446744073709551615", "100000"] {
            let error = error_at(&format!("s 0 0 0 1\n{entity} {count}\n0 0 0\n"), 2);
            assert!(matches!(error, LoadError::CountTooLarge { .. }), "{count}: {error}");
        }
        let error = error_at(&format!("{entity} 2\n0 0 0\n0 0 0\n0 0 0\n0 0 0"), 1);
        assert!(matches!(error, LoadError::OutOfRange { .. }), "{error}");
    }
    assert!(matches!(error_at("p 99999999999999999999", 1), LoadError::Syntax { .. }));
}

#[test]
fn tight_polygons_fit_their_count() {
    let scene = parse("p 3 0 0 0 1 0 0 0 1 0").unwrap();
    assert_eq!(scene.primitives.len(), 1);
    let scene = parse("pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1").unwrap();
    assert_eq!(scene.primitives.len(), 1);
}

#[test]
fn negative_radii() {
    let error = error_at("\ns 0 0 0 -1", 2);
    assert!(matches!(error, LoadError::OutOfRange { found, .. } if found == "-1"));
    let error = error_at("c 0 0 0 1 0 0 1 -2", 1);
    assert!(matches!(error, LoadError::OutOfRange { found, .. } if found == "-2"));
    assert!(parse("c 0 0 0 -1 0 0 1 0").is_ok());
}

#[test]
fn views_without_a_view_are_rejected() {
    for (from, to) in [
        ("angle 45", "angle 0"),
        ("angle 45", "angle 180"),
        ("at 0 0 0", "at 1 2 3"),
        ("up 0 0 1", "up 0 0 0"),
        ("up 0 0 1", "up 1 2 3"),
        ("resolution 320 200", "resolution 0 200"),
    ] {
        let error = parse(&format!("s 0 0 0 1\n{}", VIEW.replace(from, to))).unwrap_err();
        assert!(matches!(error, LoadError::OutOfRange { .. }), "{to}: {error}");
    }
    let error = parse(&VIEW.replace("resolution 320 200", "resolution 320 99999999")).unwrap_err();
    assert!(matches!(error, LoadError::CountTooLarge { .. }), "{error}");
    let error = error_at(&format!("s 0 0 0 1\n{}", VIEW.replace("angle 45\n", "")), 2);
    assert!(error.to_string().contains("a view without `angle`"), "{error}");
}

#[test]
fn empty_files_have_no_primitives() {
    for text in ["", "   \n\n", "# only a comment", VIEW] {
        assert!(matches!(parse(text), Err(LoadError::NoPrimitives { .. })), "{text}");
    }
}

#[test]
fn files_plain_and_gzipped_and_in_latin_1() {
    let bytes = b"# caf\xe9\ns 0 0 0 1\n";
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    let stream = encoder.finish().unwrap();
    let (_folder, path) = folder(&[("a.nff", &bytes[..]), ("b.nff.gz", &stream)]);
    let packed = path.join("b.nff.gz");
    assert_eq!(crate::load(&path.join("a.nff")).unwrap().name, "a");
    assert_eq!(crate::load(&packed).unwrap().name, "b");
    std::fs::write(&packed, &stream[..stream.len() - 9]).unwrap();
    assert!(matches!(crate::load(&packed), Err(LoadError::Decompress { .. })));
    let error = crate::load(&path.join("absent.nff")).unwrap_err();
    assert!(matches!(error, LoadError::Io { .. }) && error.to_string().contains("absent.nff"));
    assert!(matches!(crate::load(&path), Err(LoadError::Io { .. })));
}
