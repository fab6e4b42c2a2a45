//! Textures of OBJ and glTF files: images, texture coordinates, and what is missing or too much.

use std::path::Path;

use base64::Engine;
use scene_loading::gltf::parse_gltf;
use scene_loading::{LoadError, Scene, Wrap};
use serde_json::{Value, json};

use crate::gltf_file::{File, set};
use crate::{folder, warning};

/// A PNG file of 2 x 1 texels: red and blue.
fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let image = image::RgbImage::from_raw(2, 1, vec![255, 0, 0, 0, 0, 255]).unwrap();
    image.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    bytes
}

/// The same with another width and height in its header.
pub fn png_that_claims([width, height]: [u32; 2]) -> Vec<u8> {
    let mut bytes = png();
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let crc = !bytes[12..29].iter().fold(!0_u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| (c >> 1) ^ (0xedb8_8320 * (c & 1)))
    });
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    bytes
}

const QUAD: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
    vt 0 0\nvt 1 0\nvt 1 0.75\nvt 0 0.75\nusemtl wall\n";

/// Loads an OBJ file with an MTL file and images beside it.
fn load(obj: &str, mtl: &str, images: &[(&str, Vec<u8>)]) -> Scene {
    let texts = [("a.obj", obj.into()), ("a.mtl", mtl.into())];
    let (_folder, path) = folder(&[&texts[..], images].concat());
    crate::load(&path.join("a.obj")).unwrap()
}

#[test]
fn obj_faces_keep_their_texture_coordinates() {
    let text = format!("{QUAD}f 1/1 2/2 3/3 4/4\nf 1/-4 2/-3 3/-2\nf 1 2 3\n");
    let mtl = "newmtl wall\nKd 1 0.5 1\nmap_Kd wall one.png\n";
    let scene = load(&text, mtl, &[("wall one.png", png())]);
    let texture = &scene.textures[scene.materials[0].texture.unwrap() as usize];
    assert_eq!((texture.size, texture.wrap), ([2, 1], [Wrap::Repeat; 2]));
    assert_eq!(&*texture.texels, [[255, 0, 0], [0, 0, 255]]);
    assert_eq!(scene.materials[0].color, [1.0, 0.5, 1.0]);
    // the face with four corners is split; v is turned around
    assert_eq!(scene.primitives.len(), 4);
    for id in 0..3 {
        let (shape, corners) = (scene.primitives[id].shape, scene.texcoords[id].unwrap());
        for (p, [u, v]) in scene.outline(shape).iter().zip(corners) {
            assert_eq!((u, v), (p.x as f32, 1.0 - 0.75 * p.y as f32), "{id}");
        }
    }
    assert_eq!(scene.texcoords_of(3), None);
    let warning = warning(&scene);
    assert!(warning.contains("1 faces of textured materials"), "{warning}");
    assert!(warning.ends_with("(first: line 13)"), "{warning}");
}

#[test]
fn options_of_a_map_place_it() {
    let text = format!("{QUAD}f 1/1 2/2 3/3\nvt nan 0\nf 1/1 2/2 3/5\n");
    let mtl = "newmtl wall\nmap_Kd -s 2 4 1 -clamp on -o 0.5 0.25 wall.png\n";
    let scene = load(&text, mtl, &[("wall.png", png())]);
    assert_eq!(scene.textures[0].wrap, [Wrap::Clamp; 2]);
    assert_eq!(scene.texcoords[0], Some([[0.5, 0.75], [2.5, 0.75], [2.5, -2.25]]));
    // texture coordinates that are NaN leave the plain colour
    assert_eq!(scene.texcoords_of(1), None);
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
}

#[test]
fn without_a_texture_nothing_of_textures_is_kept() {
    let text = format!("{QUAD}f 1/1 2/2 3/3 4/4\n");
    let scene = load(&text, "newmtl wall\nKd 1 0 0\nnewmtl other\nmap_Kd lost.png\n", &[]);
    assert!(scene.textures.is_empty() && scene.texcoords.is_empty());
    assert_eq!((scene.primitives.len(), scene.warnings.len()), (1, 0));
}

#[test]
fn an_unavailable_image_is_a_warning_that_names_it() {
    let text = format!("{QUAD}f 1/1 2/2 3/3 4/4\n");
    let cases = [
        ("lost.png", "lost.png: "),
        ("../lost.png", "leads out of the folder"),
        ("..\\lost.png", "leads out of the folder"),
        ("/etc/passwd", "leads out of the folder"),
        ("a.obj", "is not a PNG image"),
        ("cut.png", "is damaged"),
        ("huge.png", "has 50000 x 50000 texels: 7500000000 bytes decoded, but 536870912 of"),
        ("-cc on wall.png", "has options that are not read: -cc"),
        (".", "leads out of the folder"),
        ("", "leads out of the folder"),
    ];
    for (name, why) in cases {
        let mtl = format!("newmtl wall\nKd 1 0.5 1\nmap_Kd {name}\n");
        let images = [
            ("wall.png", png()),
            ("cut.png", png()[..40].to_vec()),
            ("huge.png", png_that_claims([50_000; 2])),
        ];
        let scene = load(&text, &mtl, &images);
        for part in ["a.mtl:3: material `wall` has its plain colour", &format!("`{name}`"), why] {
            assert!(warning(&scene).contains(part), "{part}: {}", warning(&scene));
        }
        assert_eq!((scene.materials[0].texture, scene.materials[0].color), (None, [1.0, 0.5, 1.0]));
        assert!(scene.textures.is_empty() && scene.texcoords.is_empty());
    }
}

#[test]
fn the_images_of_a_scene_share_one_budget() {
    // 1 + 11 images of 45 MB each, in a few kB: the twelfth is too much
    let mut bytes = Vec::new();
    let image = image::DynamicImage::new_luma8(4000, 3750);
    image.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    let (mut text, mut mtl) = (QUAD.to_owned(), "newmtl wall\n".to_owned());
    let names: Vec<String> = (0..12).map(|i| format!("{i}.png")).collect();
    for (i, name) in names.iter().enumerate() {
        text.push_str(&format!("usemtl m{i}\nf 1/1 2/2 3/3\n"));
        mtl.push_str(&format!("newmtl m{i}\nmap_Kd {name}\n"));
    }
    let images: Vec<_> = names.iter().map(|name| (name.as_str(), bytes.clone())).collect();
    let scene = load(&text, &mtl, &images);
    assert_eq!(scene.textures.len(), 11);
    let warning = warning(&scene);
    assert!(warning.contains("material `m11`") && warning.contains("left"), "{warning}");
}

/// A textured triangle; the buffer has positions, floats, bytes, shorts and the image.
fn textured() -> File {
    let mut file = File::triangle();
    file.floats("VEC2", &[0., 0., 2., 0., 0., -3.]);
    file.accessor("VEC2", 5121, 3, &[0, 0, 255, 0, 0, 51]);
    let shorts = [0_u16, 0, 65535, 0, 0, 13107];
    file.accessor("VEC2", 5123, 3, &shorts.map(u16::to_le_bytes).concat());
    for set in 0..3 {
        file.json["accessors"][set + 1]["normalized"] = json!(set > 0);
        file.attributes()[format!("TEXCOORD_{set}")] = json!(set + 1);
    }
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.json["materials"] = json!([{"name": "wall", "pbrMetallicRoughness": {
        "baseColorTexture": {"index": 0}, "baseColorFactor": [1, 0.5, 1, 1]}}]);
    file.json["textures"] = json!([{"source": 0, "sampler": 0}]);
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648}]);
    let view = file.view(&png());
    file.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    file
}

/// Parses the document after a change at `at`.
fn parse(at: &str, to: Value) -> Result<Scene, LoadError> {
    let mut document = textured().document();
    if !at.is_empty() {
        document = set(document, at, to);
    }
    parse_gltf(Path::new("dir/a.gltf"), document.to_string().as_bytes())
}

#[test]
fn gltf_textures_from_views_and_uris() {
    let scene = parse("", Value::Null).unwrap();
    assert_eq!(scene.warnings, []);
    let texture = &scene.textures[scene.materials[0].texture.unwrap() as usize];
    assert_eq!((texture.size, texture.wrap), ([2, 1], [Wrap::Clamp, Wrap::Mirror]));
    assert_eq!(&*texture.texels, [[255, 0, 0], [0, 0, 255]]);
    assert_eq!(scene.texcoords, [Some([[0.0, 0.0], [2.0, 0.0], [0.0, -3.0]])]);
    // other sets, of normalized bytes and shorts
    for set in [1, 2] {
        let info = json!({"index": 0, "texCoord": set});
        let scene = parse("/materials/0/pbrMetallicRoughness/baseColorTexture", info).unwrap();
        assert_eq!(scene.texcoords, [Some([[0.0, 0.0], [1.0, 0.0], [0.0, 0.2]])]);
    }
    let data = base64::engine::general_purpose::STANDARD.encode(png());
    let image = json!({"uri": format!("data:image/png;base64,{data}")});
    assert_eq!(parse("/images/0", image).unwrap().textures, scene.textures);
    // the sampler's default
    let scene = parse("/textures/0", json!({"source": 0})).unwrap();
    assert_eq!(scene.textures[0].wrap, [Wrap::Repeat; 2]);
}

#[test]
fn gltf_images_that_cannot_be_had_are_warnings() {
    let huge = base64::engine::general_purpose::STANDARD.encode(png_that_claims([50_000; 2]));
    for (image, why) in [
        (json!({}), "neither a URI nor a buffer view"),
        (json!({"uri": "lost.png"}), "dir/lost.png"),
        (json!({"uri": "../lost.png"}), "leads out of the file's own folder"),
        (json!({"uri": "file:///etc/passwd"}), "leads out of the file's own folder"),
        (json!({"uri": "%FF"}), "UTF-8"),
        (json!({"uri": "data:image/png;base64,!"}), "base64"),
        (json!({"bufferView": 0, "mimeType": "image/png"}), "is not a PNG image"),
        (json!({"bufferView": 0}), "is not a PNG image"),
        (json!({"uri": format!("data:image/png;base64,{huge}")}), "50000 x 50000 texels"),
    ] {
        let scene = parse("/images/0", image.clone()).unwrap_or_else(|e| panic!("{image}: {e}"));
        let expected = "dir/a.gltf: material `wall` has its plain colour: texture `image 0`";
        let warning = warning(&scene);
        assert!(warning.starts_with(expected) && warning.contains(why), "{warning}");
        assert!(scene.textures.is_empty() && scene.texcoords.is_empty());
        assert_eq!(scene.materials[0].color, [1.0, 0.5, 1.0]);
    }
    let info = json!({"index": 0, "texCoord": 7});
    let scene = parse("/materials/0/pbrMetallicRoughness/baseColorTexture", info).unwrap();
    assert!(scene.warnings[0].0.contains("no TEXCOORD_7"), "{:?}", scene.warnings);
    assert!(scene.texcoords.is_empty());
}

#[test]
fn broken_texture_coordinates_and_references_are_errors() {
    for (at, to) in [
        ("/accessors/1/type", json!("VEC3")),
        ("/accessors/1/componentType", json!(5125)),
        ("/accessors/1/count", json!(2)),
        ("/accessors/1/count", json!(1000)),
        ("/bufferViews/1/byteLength", json!(20)),
        ("/bufferViews/1/byteOffset", json!(100_000)),
        ("/textures/0/source", json!(9)),
        ("/images/0/bufferView", json!(9)),
        ("/samplers/0/wrapS", json!(1)),
    ] {
        let error = parse(at, to.clone()).expect_err(at);
        assert!(error.to_string().starts_with("dir/a.gltf: "), "{error}");
        assert!(!error.to_string().contains("panic"), "{at}: {error}");
    }
}
