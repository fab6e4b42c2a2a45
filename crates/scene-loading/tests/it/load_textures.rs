//! Textures of OBJ and glTF files: images, texture coordinates, and what is missing or too much.

use std::path::Path;

use base64::Engine;
use scene_loading::gltf::parse_gltf;
use scene_loading::{LoadError, Scene, Wrap};
use serde_json::{Value, json};

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
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), obj).unwrap();
    std::fs::write(folder.path().join("a.mtl"), mtl).unwrap();
    for (name, bytes) in images {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    crate::load(&folder.path().join("a.obj")).unwrap()
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
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert!(warning.0.contains("1 faces of textured materials"), "{warning}");
    assert!(warning.0.ends_with("(first: line 13)"), "{warning}");
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
        let [warning] = &scene.warnings[..] else { panic!("{name}: {:?}", scene.warnings) };
        for part in ["a.mtl:3: material `wall` has its plain colour", &format!("`{name}`"), why] {
            assert!(warning.0.contains(part), "{part}: {warning}");
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
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert!(warning.0.contains("material `m11`") && warning.0.contains("left"), "{warning}");
}

/// A textured triangle; the buffer has positions, floats, bytes, shorts and the image.
fn document() -> (Value, Vec<u8>) {
    let floats: [f32; 15] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 2., 0., 0., -3.];
    let mut buffer: Vec<u8> = floats.iter().flat_map(|f| f.to_le_bytes()).collect();
    buffer.extend([0_u8, 0, 255, 0, 0, 51, 0, 0]);
    buffer.extend([0_u16, 0, 65535, 0, 0, 13107].iter().flat_map(|i| i.to_le_bytes()));
    let image = png();
    buffer.extend(&image);
    let view =
        |from: usize, length: usize| json!({"buffer": 0, "byteOffset": from, "byteLength": length});
    let texcoords = |view: usize, kind: u32, normalized: bool| {
        json!({"bufferView": view, "componentType": kind, "count": 3, "type": "VEC2",
            "normalized": normalized})
    };
    let document = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 2,
            "TEXCOORD_2": 3}, "material": 0}]}],
        "materials": [{"name": "wall", "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0}, "baseColorFactor": [1, 0.5, 1, 1]}}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0, 0, 0], "max": [1, 1, 0]},
            texcoords(1, 5126, false), texcoords(2, 5121, true), texcoords(3, 5123, true),
        ],
        "bufferViews": [view(0, 36), view(36, 24), view(60, 6), view(68, 12), view(80, image.len())],
        "buffers": [{"byteLength": buffer.len(), "uri": "buffer"}],
    });
    (document, buffer)
}

/// Parses the document after a change at `at`.
fn parse(at: &str, to: Value) -> Result<Scene, LoadError> {
    let (mut document, buffer) = document();
    let data = base64::engine::general_purpose::STANDARD.encode(buffer);
    document["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{data}").into();
    if !at.is_empty() {
        *document.pointer_mut(at).expect(at) = to;
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
        let [warning] = &scene.warnings[..] else { panic!("{image}: {:?}", scene.warnings) };
        let expected = "dir/a.gltf: material `wall` has its plain colour: texture `image 0`";
        assert!(warning.0.starts_with(expected) && warning.0.contains(why), "{warning}");
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
