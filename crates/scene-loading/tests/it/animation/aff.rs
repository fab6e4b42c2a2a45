//! AFF files, with what is expected worked out by hand.

use glam::DVec3;
use scene_loading::animation::{Animation, open};
use scene_loading::{Light, LoadError, Scene, Shape};

use super::{claim_error, claimed};
use crate::{folder, shapes, warnings};

/// A view, a light, and a clip of five frames from 0 to 4 seconds.
const HEAD: &str = "v\nfrom 0 0 9\nat 0 0 4\nup 0 1 0\nangle 40\nhither 1\nresolution 8 6\n\
                    l 1 2 3 0.5 0.5 0.5\na 0 4 5 % frames\n";

/// A triangle.
const TRIANGLE: &str = "p 3\n0 0 0\n1 0 0\n0 1 0\n";

/// Five keys that move along x by one unit a second from 0 to 4.
const ALONG_X: &str = "transl 7\n-1 -1 0 0 0 0 0\n0 0 0 0 0 0 0\n1 1 0 0 0 0 0\n2 2 0 0 0 0 0\n\
                       3 3 0 0 0 0 0\n4 4 0 0 0 0 0\n5 5 0 0 0 0 0\n";

fn opened(files: &[(&str, &str)]) -> Result<Animation, LoadError> {
    // all is in memory from here on
    let (_folder, path) = folder(files);
    open(path.join(files[0].0).to_str().unwrap())
}

fn animation(body: &str) -> Animation {
    opened(&[("a.aff", &(HEAD.to_owned() + body))]).unwrap()
}

fn error(body: &str) -> String {
    let opened = opened(&[("a.aff", &(HEAD.to_owned() + body))]);
    let text = opened.and_then(|mut a| a.frame(1)).expect_err(body).to_string();
    assert!(text.contains("a.aff"), "{text}");
    text
}

fn corners(scene: &Scene, id: usize) -> Vec<DVec3> {
    scene.outline(scene.primitives[id].shape)
}

fn near(a: DVec3, b: [f64; 3]) {
    assert!(a.distance(DVec3::from_array(b)) < 1e-9, "{a} instead of {b:?}");
}

#[test]
fn transforms_are_nested_and_keys_move_them() {
    let body = format!(
        "# a comment with a brace {{\nfm 9 9 9  0.2 0.4 0.1  0.3 0.1 0  20 0 0\n{TRIANGLE}\
         x slider {{ xs 2 2 2  0 0 1 90  0 0 5\n{{ {TRIANGLE} }}\n{TRIANGLE}}}\n\
         k slider {{ {ALONG_X} }}\n"
    );
    let mut animation = animation(&body);
    assert_eq!((animation.name(), animation.frames()), ("a", 5));
    let [first, third] = [0, 3].map(|i| animation.frame(i).unwrap());
    // at rest; twice as large, a quarter turn, 5 up and 3 along; 3 along
    near(corners(&third, 0)[1], [1.0, 0.0, 0.0]);
    near(corners(&third, 1)[1], [3.0, 2.0, 5.0]);
    near(corners(&third, 1)[2], [1.0, 0.0, 5.0]);
    near(corners(&third, 2)[1], [4.0, 0.0, 0.0]);
    let material = &first.materials[0];
    assert_eq!((material.color, material.diffuse), ([0.5, 1.0, 0.25], 0.4));
    assert_eq!((material.specular, material.shine), (0.3, 20.0));
    let color = Some([0.5; 3]);
    assert_eq!(first.lights, [Light::point(DVec3::new(1.0, 2.0, 3.0), color)]);
    assert_eq!((first.camera.resolution, first.camera.from.z), ([8, 6], 9.0));
    assert_eq!(claimed(&first), 3);
    for index in 1..5 {
        assert!(claim_error(&first, &animation.frame(index).unwrap()) < 1e-12);
    }
    assert!(matches!(animation.frame(5), Err(LoadError::IndexOutOfRange { .. })));
}

#[test]
fn a_file_that_is_included_twice_is_one_object() {
    let main = format!(
        "{HEAD}xs 1 1 1 0 0 1 0 0 0 7 {{ i 0 wheel.aff }}\nx nothing {{ i 0 wheel.aff }}\n\
         i 1 fine.aff\nd 1\ni 1 fine.aff"
    );
    let files = [("m.aff", main.as_str()), ("wheel.aff", TRIANGLE), ("fine.aff", TRIANGLE)];
    let scene = opened(&files).unwrap().frame(0).unwrap();
    let objects: Vec<u32> = scene.instances.iter().map(|i| i.object).collect();
    assert!(objects.len() == 3 && objects[0] == objects[1] && objects[1] != objects[2]);
    assert!(claim_error(&scene, &scene) < 1e-12);
    near(corners(&scene, 0)[1], [1.0, 0.0, 7.0]);
    near(corners(&scene, 1)[1], [1.0, 0.0, 0.0]);
}

#[test]
fn vanished_primitives_keep_their_ids() {
    let body = format!(
        "x blink {{ {TRIANGLE} s 0 0 0 1 }}\n{TRIANGLE}k blink {{ visibility 2\n1 0\n3 1\n {ALONG_X} }}"
    );
    let mut animation = animation(&body);
    for (index, is_visible) in [(0, true), (1, false), (2, false), (3, true), (4, true)] {
        let scene = animation.frame(index).unwrap();
        assert_eq!((scene.primitives.len(), scene.instances.len()), (3, 1));
        let [a, b, _] = corners(&scene, 0)[..] else { panic!() };
        assert_eq!(a != b, is_visible, "{index}");
        assert_eq!(scene.spheres[0].radius, f64::from(u8::from(is_visible)));
        near(scene.spheres[0].center, [f64::from(index), 0.0, 0.0]);
    }
}

#[test]
fn animated_triangles_are_straight_between_their_times() {
    let corner = |z: f64| format!("0 0 {z} 0 0 1\n1 0 {z} 0 0 1\n0 1 {z} 0 {z} 1\n");
    let body = format!(
        "xs 1 1 1 0 0 1 0 0 0 10 {{ tpa 3\n1\n{}2\n{}3\n{} }}",
        corner(0.0),
        corner(1.0),
        corner(5.0)
    );
    let mut animation = animation(&body.replace("tpa", "fm 0 0 0 1 1 1 0 0 0 0 0 0 tpa"));
    for (index, z) in [(0, 10.0), (1, 10.0), (2, 11.0), (3, 15.0), (4, 15.0)] {
        let scene = animation.frame(index).unwrap();
        near(scene.to_file_coordinates(corners(&scene, 0)[1]), [1.0, 0.0, z]);
        assert!(matches!(scene.primitives[0].shape, Shape::Patch { .. }));
        assert!(scene.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-12));
        assert!(scene.instances.is_empty());
    }
    near(animation.frame(2).unwrap().normals[2], [0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()]);
}

#[test]
fn the_camera_looks_down_its_own_z() {
    let turn = "rot 4\n-1 0 1 0 0 0 0 0\n0 0 1 0 0 0 0 0\n4 0 1 0 -90 0 0 0\n5 0 1 0 -90 0 0 0\n";
    let mut moved = animation(&format!("{TRIANGLE}k camera {{ {ALONG_X}{turn} }}"));
    let [first, last] = [0, 4].map(|i| moved.frame(i).unwrap().camera);
    near(first.from, [0.0; 3]);
    near(first.at, [0.0, 0.0, -5.0]);
    near(last.from, [4.0, 0.0, 0.0]);
    near(last.at, [9.0, 0.0, 0.0]);
    near(last.up, [0.0, 1.0, 0.0]);
    // without a view the first frame is framed
    let text = HEAD.split_once("l 1").unwrap().1;
    let text = format!("l 1{text}x s {{ {TRIANGLE} }} k s {{ {ALONG_X} }}");
    let mut framed = opened(&[("a.aff", &text)]).unwrap();
    assert_eq!(framed.frame(4).unwrap().camera, framed.frame(0).unwrap().camera);
}

#[test]
fn shapes_are_read() {
    let body = "f 1 0 0 0.5 0.25 10 0 0\np 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
                pp 3\n0 0 0 0 0 2\n1 0 0 0 0 2\n0 1 0 0 0 2\nc\n0 0 0 1\n0 0 2 0.5\n\
                tt a.ppm\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n\
                ttp a.ppm\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 1\n\
                m vertices 4\n0 0 0\n1 0 0\n0 1 0\n1 1 0\nnormals 1\n0 0 1\n\
                texturecoords 2 b.ppm\n0 0\n1 1\ntriangles 3\n0 1 2 0 0 0 0 1 0\n\
                1 3 2 0 0 0 1 1 1\n0 0 0 0 0 0 0 0 0\n\
                m\nvertices 3\n0 0 0\n1 0 0\n0 1 0\ntriangles 1\n2 1 0\n";
    let scene = animation(body).frame(0).unwrap();
    let kind = |shape| match shape {
        Shape::Triangle { .. } => 't',
        Shape::Patch { .. } => 'p',
        Shape::Cone(_) => 'c',
        _ => '?',
    };
    assert_eq!(shapes(&scene).into_iter().map(kind).collect::<String>(), "ttpctpppt");
    assert_eq!(corners(&scene, 7)[1], DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(corners(&scene, 8)[0], DVec3::Y);
    assert_eq!(scene.normals[0], DVec3::Z);
    let warnings = warnings(&scene);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("1 faces without area") && warnings[1].contains("3 textured"));
}

#[test]
fn lights_follow_their_braces_and_named_ones_stay() {
    let body =
        format!("x s {{ la lamp 0 0 0 {TRIANGLE} }} k s {{ {ALONG_X} }} k lamp {{ {ALONG_X} }}");
    let scene = animation(&body).frame(2).unwrap();
    near(scene.lights[1].position, [2.0, 0.0, 0.0]);
    assert!(scene.warnings[0].0.contains("1 lights with keyframes stay in place"));
}

#[test]
fn broken_files_are_refused_by_line() {
    let says = |body: &str, what: &str| {
        let text = error(body);
        assert!(text.contains(what), "{body}: {text}");
    };
    // the head has nine lines
    says("fish", "a.aff:10: found `fish`, expected an entity");
    says("p 3\n0 0 0\n1 0 zero\n", "a.aff:12: found `zero`, expected a number");
    says("p 2\n0 0 0\n1 0 0", "a.aff:10: the number of corners is 2, expected at least 3");
    says(&format!("{TRIANGLE}}}"), "found `}`, expected as many { before it");
    says(&format!("x a {{ {TRIANGLE}"), "the file ends where } was expected");
    says("xs 1 1 1 0 0 1 0 0 0 0 p 3", "found `p`, expected {");
    says("m vertices 1\n0 0 0\ntriangles 1\n0 0 1", "a.aff:13: vertex index 1 is out of range");
    says("m vertices 1\n0 0 0\nnormals 1\n0 0 1 triangles 1\n0 0 0 0 0 7", "normal index 7");
    says("m corners 3", "found `corners`, expected vertices");
    says("m vertices 99999999\n0 0 0", "vertices is 99999999, but at most");
    says("tpa 99999999\n0 0 0", "the number of times is 99999999, but at most");
    says("tpa 2\n1 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n1 0", "expected more than 1");
    says("xs 1 1 2 0 0 1 0 0 0 0 { s 0 0 0 1 }", "a.aff:10: the scale of a sphere or cone");
    says("c 0 0 0 1 0 0 1 -1", "one of two radii of a cone is -1");
    says("k a { transl 3", "the number of keys is 3, expected at least 4");
    says("k a { fly 4", "found `fly`, expected transl, rot, scale, visibility or }");
    says("k a { visibility 99999999", "the number of keys is 99999999");
    says(
        &format!(
            "{TRIANGLE}xs 1e308 1 1 0 0 1 0 0 0 0 {{ xs 1e308 1 1 0 0 1 0 0 0 0 {{ {TRIANGLE} }} }}"
        ),
        "a place in the world is NaN",
    );
    says("a 1 0 5", "the end is 0, expected at least the start, 1");
    says("i 0 ../b.aff", "leads out");
    says("i 0 a.aff", "the depth of included files is 17, but at most 16");
    says("v\nfrom 0 0 0", "a view without `resolution`");
    says("", "no primitives");
    let text = opened(&[("a.aff", TRIANGLE)]).err().unwrap().to_string();
    assert!(text.contains("the file ends where an entity `a`"), "{text}");
    let text = opened(&[("m.aff", "i 0 lost.aff")]).err().unwrap().to_string();
    assert!(text.contains("lost.aff: "), "{text}");
}

#[test]
fn files_that_multiply_are_refused() {
    // each includes the next three times: the last would be read 3^15 times
    let names: Vec<String> = (0..=15).map(|i| format!("f{i}.aff")).collect();
    let mut texts: Vec<String> =
        names[1..].iter().map(|next| format!("i 0 {next}\n").repeat(3)).collect();
    texts.push(String::new());
    let files: Vec<(&str, &str)> =
        names.iter().zip(&texts).map(|(name, text)| (&**name, &**text)).collect();
    let error = opened(&files).err().unwrap();
    assert!(error.to_string().contains("the number of included files is 65537"), "{error}");
}
