//! The readers of PBRT and of tray_racing's scene files: what they accept, and the error of every
//! way a file can be wrong.

use std::path::Path;

use glam::DVec3;
use scene_loading::pbrt::parse_pbrt;
use scene_loading::source::formats::{ReadOptions, parse_scene};
use scene_loading::{LoadError, Primitive, Scene, Shape};

use crate::{check_faults, folder, resolved, shapes, warnings};

const TRIANGLE: &str = "Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n\
                        \"point3 P\" [0 0 0  1 0 0  0 1 0]\n";

fn pbrt(text: &str) -> Result<Scene, LoadError> {
    parse_pbrt(Path::new("no-such-folder/a.pbrt"), text.into(), false)
}

fn near(a: DVec3, b: [f64; 3]) -> bool {
    a.distance(DVec3::from_array(b)) < 1e-9
}

#[test]
fn all_statements_of_a_scene_are_read() {
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" [400] \"string filename\" \"a.exr\"\n\
         LookAt 1 2 3  1 2 0  0 1 0 # a comment \" with [ signs\n\
         Camera \"perspective\" \"float fov\" 40\nSampler \"halton\"\nWorldBegin\n\
         LightSource \"point\" \"point3 from\" [0 5 0] \"rgb I\" [10 5 0]\n\
         LightSource \"infinite\" \"string filename\" \"sky.exr\"\n\
         MakeNamedMaterial \"red\" \"string type\" \"diffuse\" \"rgb reflectance\" [1 0 0]\n\
         Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\"\n\
         AttributeBegin\nNamedMaterial \"red\"\nTranslate 0 0 -5\nScale 2 2 2\n{TRIANGLE}\
         Shape \"sphere\" \"float radius\" 1.5\n\
         Scale 1 2 1\nShape \"sphere\"\nShape \"curve\" \"float width\" 1\nAttributeEnd\n\
         Material \"conductor\" \"spectrum eta\" \"metal-Cu-eta\"\n\
         AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n\
         Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]\n"
    );
    let scene = pbrt(&text).unwrap();
    let camera = scene.camera;
    assert!(near(camera.from, [1., 2., 3.]) && near(camera.at, [1., 2., 2.]), "{camera:?}");
    assert!(near(camera.up, [0., 1., 0.]) && camera.angle == 40.0);
    assert_eq!(scene.lights.len(), 1);
    assert_eq!(scene.lights[0].color, Some([1.0, 0.5, 0.0]), "the strongest is 1");
    assert!(matches!(
        shapes(&scene)[..],
        [Shape::Triangle { .. }, Shape::Sphere(0), Shape::Polygon { .. }]
    ));
    assert!(near(scene.vertices[1], [2., 0., -5.]));
    assert!(near(scene.spheres[0].center, [0., 0., -5.]) && scene.spheres[0].radius == 3.0);
    assert_eq!(scene.materials[scene.primitives[0].material as usize].name, "red");
    assert!(scene.materials[scene.primitives[2].material as usize].specular > 0.0);
    assert_eq!(
        warnings(&scene),
        [
            "a.pbrt: 1 area lights are plain surfaces (first: line 23)",
            "a.pbrt: 1 ellipsoids (spheres that their transform stretches) left out (first: line 18)",
            "a.pbrt: 1 lights infinite left out (first: line 7)",
            "a.pbrt: 1 shapes curve left out (first: line 19)",
        ]
    );
}

#[test]
fn transforms_are_those_of_pbrt() {
    for (transform, expected) in [
        ("Translate 1 2 3", [2., 2., 3.]),
        ("Translate 1 2 3 Scale 2 2 2", [3., 2., 3.]),
        ("Scale 2 2 2 Translate 1 2 3", [4., 4., 6.]),
        ("Rotate 90 0 0 1", [0., 1., 0.]),
        ("Transform [1 0 0 0  0 1 0 0  0 0 1 0  7 8 9 1]", [8., 8., 9.]),
        ("Translate 1 0 0 ConcatTransform [0 1 0 0 -1 0 0 0 0 0 1 0 0 0 0 1]", [1., 1., 0.]),
        ("Translate 9 9 9 Identity", [1., 0., 0.]),
        ("TransformBegin Translate 9 9 9 TransformEnd", [1., 0., 0.]),
        ("Translate 1 1 1 CoordinateSystem \"a\" Identity CoordSysTransform \"a\"", [2., 1., 1.]),
        ("ActiveTransform EndTime Translate 5 5 5 ActiveTransform All", [1., 0., 0.]),
        // from (0,0,5) to the origin: what is at x=1 in the world is 5 ahead, to the left
        ("LookAt 0 0 5  0 0 0  0 1 0", [-1., 0., 5.]),
    ] {
        let scene = pbrt(&format!("{transform}\n{TRIANGLE}")).unwrap();
        assert!(near(scene.vertices[1], expected), "{transform}: {:?}", scene.vertices);
    }
}

#[test]
fn instances_are_copies_in_their_places() {
    let text = format!(
        "Translate 100 0 0\nObjectBegin \"o\"\nTranslate 0 1 0\n{TRIANGLE}\
         Shape \"sphere\" \"float radius\" 1\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1 0 0 1 0 0 1]\nObjectEnd\nIdentity\nTranslate 0 0 5\nObjectInstance \"o\"\n\
         Scale 2 2 2\nObjectInstance \"o\"\nScale 1 1 -3\nObjectInstance \"o\"\n"
    );
    let scene = pbrt(&text).unwrap();
    assert_eq!(scene.primitives.len(), 3 * 3 - 1, "one sphere is none any more");
    assert!(near(scene.vertices[1], [101., 1., 5.]), "{:?}", scene.vertices[1]);
    assert_eq!(scene.spheres.iter().map(|s| s.radius).collect::<Vec<_>>(), [1.0, 2.0]);
    assert!(near(scene.spheres[1].center, [200., 2., 5.]));
    let Shape::Patch { n, .. } = scene.primitives[7].shape else { panic!() };
    assert!(near(scene.normals[n[0] as usize], [0., 0., -1.]), "a mirrored one");
    assert_eq!(
        warnings(&scene),
        ["a.pbrt: 1 ellipsoids (spheres that their transform stretches) left out (first: line 15)"]
    );
    let placed: Vec<_> = scene.instances.iter().map(|i| (i.object, i.first, i.count)).collect();
    assert_eq!(placed, [(0, 0, 3), (0, 3, 3), (0, 6, 2)]);
    let there = scene.instances[1].placement.transform_point3(scene.vertices[1]);
    assert!(near(there, [202., 2., 15.]), "{there}");
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                   property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                   end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

#[test]
fn files_are_included_and_named_ones_lie_in_the_folder() {
    let main = "Include \"geometry/b.pbrt\"\nShape \"plymesh\" \"string filename\" \"geometry/m.ply\"\n\
                Import \"geometry/b.pbrt\"\nShape \"plymesh\" \"string filename\" \"geometry/m.ply\"\n";
    let inner = "Translate 0 0 9\nMaterial \"diffuse\"\n";
    let files = [("a.pbrt", main), ("geometry/b.pbrt", inner), ("geometry/m.ply", PLY)];
    let (_folder, path) = folder(&files);
    let scene = resolved(&path.join("a.pbrt")).unwrap().load().unwrap().scene;
    let corner = |p: &Primitive| scene.to_file_coordinates(scene.outline(p.shape)[0]);
    let places: Vec<f64> = scene.primitives.iter().map(|p| corner(p).z).collect();
    assert_eq!(places, [9.0, 9.0], "what an Import sets ends with it");
    for (text, part) in [
        ("Include \"../b.pbrt\"", "leads out"),
        ("Include \"/etc/passwd\"", "leads out"),
        ("Shape \"plymesh\" \"string filename\" \"../m.ply\"", "leads out"),
        ("Shape \"plymesh\"", "filename"),
        ("Include \"lost.pbrt\"", "lost.pbrt"),
        ("Include \"a.pbrt\"", "the depth of Include"),
        ("Shape \"plymesh\" \"string filename\" \"a.pbrt\"", "ply was expected"),
    ] {
        std::fs::write(path.join("a.pbrt"), text).unwrap();
        let error = parse_pbrt(&path.join("a.pbrt"), text.into(), false).unwrap_err().to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
    // each of three files names the next one many times: the number of files ends it
    let many = |next: &str| format!("Include \"{next}\"\n").repeat(100);
    let files = [
        ("a.pbrt", many("b.pbrt")),
        ("b.pbrt", many("c.pbrt")),
        ("c.pbrt", many("d.pbrt")),
        ("d.pbrt", "Identity\n".to_owned()),
    ];
    let (_folder, path) = folder(&files);
    let error = parse_pbrt(&path.join("a.pbrt"), many("b.pbrt").into(), false).unwrap_err();
    assert!(error.to_string().contains("the number of files"), "{error}");
}

#[test]
fn faults_of_pbrt_files_are_errors_with_their_line() {
    let text = format!("WorldBegin\nAttributeBegin\n{TRIANGLE}AttributeEnd\n");
    assert!(pbrt(&text).is_ok());
    let faults = [
        ("WorldBegin", "WorldStart", ":1:", "a directive of PBRT"),
        ("WorldBegin", "[", ":1:", "a directive"),
        ("WorldBegin", "Translate 1 2", ":2:", "3 numbers"),
        ("WorldBegin", "Translate [1 2 3 4]", ":1:", "]"),
        ("WorldBegin", "Scale 1 2 1e300", ":1:", "1e100"),
        ("WorldBegin", "Scale 1 2 nan", ":1:", "finite"),
        (
            "WorldBegin",
            "Scale 1e99 1 1 Scale 1e99 1 1 Scale 1e99 1 1 Scale 1e99 1 1",
            ":1:",
            "not finite",
        ),
        ("WorldBegin", "Rotate 4 0 0 0", ":1:", "an axis"),
        ("WorldBegin", "LookAt 0 0 0 0 0 0 0 1 0", ":1:", "another point"),
        ("WorldBegin", "Scale 0 0 0 Camera \"perspective\"", ":1:", "camera"),
        ("WorldBegin", "Camera \"perspective\" \"float fov\" 180", ":1:", "180 degrees"),
        ("WorldBegin", "Camera perspective", ":1:", "\"type\""),
        ("WorldBegin", "CoordSysTransform \"x\"", ":1:", "a coordinate system before"),
        ("WorldBegin", "NamedMaterial \"x\"", ":1:", "a named material before"),
        ("WorldBegin", "ObjectInstance \"x\"", ":1:", "an object before"),
        ("WorldBegin", "ObjectEnd", ":1:", "ObjectBegin before"),
        ("WorldBegin", "ObjectBegin \"x\" ObjectBegin \"y\"", ":1:", "ObjectEnd before"),
        ("WorldBegin", "ObjectBegin \"x\"", ":", "ObjectEnd for each"),
        ("WorldBegin", "AttributeEnd", ":1:", "beginnings"),
        ("AttributeBegin", "", ":5:", "beginnings"),
        ("AttributeEnd", "", ":", "AttributeEnd"),
        ("\"integer indices\"", "\"indices\"", ":3:", "\"type name\""),
        ("\"integer indices\"", "integer", ":3:", "a multiple of 3"),
        ("[0 1 2]", "[0 1 3]", ":3:", "3 vertices"),
        ("[0 1 2]", "[0 1 -1]", ":3:", "3 vertices"),
        ("[0 1 2]", "[0 1]", ":3:", "a multiple of 3"),
        ("[0 1 2]", "[0 \"1\" 2]", ":3:", "numbers (indices)"),
        ("[0 1 2]", "[0 1 2", ":4:", "a value of integer indices"),
        ("0 1 0]", "0 1]", ":3:", "three a point"),
        ("0 1 0]", "0 0 0]", ":", "no primitives"),
        ("0 1 0]", "0 1 0", ":5:", "a value of point3 P"),
        ("\"trianglemesh\" \"integer indices\" [0 1 2]", "\"trianglemesh", ":3:", "quoted"),
        ("\"trianglemesh\"", "\"sphere\" \"float radius\" -1", ":3:", "above 0"),
    ];
    check_faults(&text, "no-such-folder/a.pbrt", pbrt, &faults);
    let deep = "AttributeBegin\n".repeat(5000);
    assert!(pbrt(&deep).unwrap_err().to_string().contains("the depth of attributes is 4097"));
    // instances of instances there are none, and their copies count
    let big =
        format!("ObjectBegin \"o\" {TRIANGLE} ObjectEnd\n{}", "ObjectInstance \"o\"\n".repeat(9));
    assert_eq!(pbrt(&big).unwrap().primitives.len(), 9);
}

#[test]
fn attributes_are_defaults_of_later_statements() {
    let text = "Attribute \"shape\" \"float radius\" 2\nShape \"sphere\"\nAttributeBegin\n\
                Attribute \"shape\" \"float radius\" 3\nShape \"sphere\"\nAttributeEnd\n\
                Shape \"sphere\"\nShape \"sphere\" \"float radius\" 4\n\
                Attribute \"material\" \"rgb reflectance\" [1 0 0]\nMaterial \"diffuse\"\n\
                Shape \"sphere\"\nAttribute \"medium\" \"float scale\" 2\n\
                Attribute \"light\" \"point3 from\" [0 9 0]\nLightSource \"point\"\n";
    let scene = pbrt(text).unwrap();
    let radii: Vec<f64> = scene.spheres.iter().map(|s| s.radius).collect();
    assert_eq!(radii, [2.0, 3.0, 2.0, 4.0, 2.0]);
    assert_eq!(scene.materials[scene.primitives[4].material as usize].color, [1.0, 0.0, 0.0]);
    assert!(near(scene.lights[0].position, [0., 9., 0.]));
    assert_eq!(warnings(&scene), ["a.pbrt: 1 attributes of medium left out (first: line 12)"]);
    let many = "Attribute \"shape\" \"float radius\" 2\n".repeat(257);
    let error = pbrt(&many).unwrap_err().to_string();
    assert!(error.contains("a.pbrt:257: the number of Attribute statements"), "{error}");
}

#[test]
fn files_of_earlier_versions_are_read_with_a_warning() {
    let text = "SurfaceIntegrator \"path\"\nWorldBegin\n\
                LightSource \"point\" \"point from\" [0 5 0] \"color I\" [50 25 0]\n\
                Material \"matte\" \"color Kd\" [1 0 0]\n\
                Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0]\n\
                Material \"mirror\"\nShape \"sphere\"\nWorldEnd\n";
    let scene = pbrt(text).unwrap();
    assert_eq!((scene.primitives.len(), scene.lights[0].color), (2, Some([1.0, 0.5, 0.0])));
    let material = |id: usize| &scene.materials[scene.primitives[id].material as usize];
    assert_eq!(material(0).color, [1.0, 0.0, 0.0]);
    assert!(material(1).specular > 0.0);
    assert_eq!(
        warnings(&scene),
        ["a.pbrt: 2 statements from before PBRT version 4; read as far as both agree \
          (first: line 1)"]
    );
}

#[test]
fn normals_and_vertices_that_are_none_are_counted() {
    let text = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 1 3 0 1 4]\n\
                \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1 nan 0 0]\n\
                \"normal N\" [0 0 1 0 0 1 0 0 1 inf 0 0 0 0 1]\n\
                Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1]\n";
    let scene = pbrt(text).unwrap();
    assert!(matches!(
        shapes(&scene)[..],
        [Shape::Patch { .. }, Shape::Triangle { .. }, Shape::Triangle { .. }]
    ));
    assert!(scene.vertices.iter().chain(&scene.normals).all(|v| v.is_finite()));
    assert_eq!(
        warnings(&scene),
        [
            "a.pbrt: 1 faces with a corner that is not usable left out (first: line 1)",
            "a.pbrt: 1 vertices with a coordinate that is not usable (first: line 1)",
            "a.pbrt: 2 invalid normals: their faces are flat (first: line 1)",
        ]
    );
}

#[test]
fn what_a_camera_has_besides_its_angle_is_counted() {
    let of = |more: &str| {
        let text = format!("Camera \"perspective\" {more}\nWorldBegin\n{TRIANGLE}");
        warnings(&pbrt(&text).unwrap())
    };
    let none: [String; 0] = [];
    assert_eq!(of("\"float fov\" 40 \"float lensradius\" 0"), none);
    assert_eq!(
        of("\"float lensradius\" 0.5 \"float screenwindow\" [-2 2 -1 1]"),
        [
            "a.pbrt: 1 parameters lensradius of cameras left out (first: line 1)",
            "a.pbrt: 1 parameters screenwindow of cameras left out (first: line 1)",
        ]
    );
}

#[test]
fn every_cut_of_a_pbrt_file_ends_in_a_scene_or_an_error() {
    let text = format!("LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\"\nWorldBegin\n{TRIANGLE}");
    for cut in 0..text.len() {
        if let Err(error) = pbrt(&text[..cut]) {
            assert!(error.to_string().starts_with("no-such-folder/a.pbrt"), "{error}");
        }
    }
}

const RON: &str = "(\n    model_path: \"a.obj\",\n    camera: (\n        eye: (3.0, 1.5, 1.4),\n        \
                   look_at: (-3.9, 1.5, -1.7),\n        fov: 70.0,\n        exposure:  -3.0,\n    ),\n    \
                   sun_direction: (0.0, -2.0, 0.0),\n    //sun_direction: (-0.27, -0.24, 1.0),\n)";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn a_scene_of_tray_racing_has_its_camera_and_its_sun() {
    let (_folder, path) = folder(&[("a.obj", OBJ)]);
    let parse = |text: &str| parse_scene(&path.join("a.ron"), text.into(), ReadOptions::default());
    let scene = parse(RON).unwrap();
    let camera = scene.camera;
    assert!(near(camera.from, [3., 1.5, 1.4]) && near(camera.at, [-3.9, 1.5, -1.7]));
    assert!(camera.angle == 70.0 && camera.up == DVec3::Y);
    let sun = scene.lights[0].position;
    assert!(sun.y > 70.0 && near(sun * DVec3::new(1., 0., 1.), [0.5, 0., 0.]), "{sun}");
    for (from, to, part) in [
        ("model_path: \"a.obj\"", "model_path: 7", "a.ron:2: ron reports"),
        ("    camera", "    camara", "camera"),
        ("70.0", "0.0", "180 degrees"),
        ("70.0", "\"wide\"", "a.ron:6: ron reports"),
        ("1.4)", "1e200)", "1e100"),
        ("1.4)", "inf)", "finite"),
        ("(3.0, 1.5, 1.4)", "(3.0, 1.5)", "a.ron:4: ron reports"),
        ("a.obj", "b.ron", "leads out"),
        ("a.obj", "../a.obj", "leads out"),
        ("-2.0, 0.0),", "-2.0, 0.0", "a.ron:"),
    ] {
        assert!(RON.contains(from), "{from}");
        let error = parse(&RON.replacen(from, to, 1)).expect_err(to).to_string();
        assert!(error.contains(part) && error.contains("a.ron"), "{to}: {error}");
    }
    std::fs::write(path.join("b.ron"), RON).unwrap();
    let error = parse(&RON.replace("a.obj", "b.ron")).unwrap_err().to_string();
    assert!(error.contains("a mesh"), "{error}");
    let deep = RON.replace("70.0", &"(".repeat(100_000));
    assert!(parse(&deep).is_err());
}

#[test]
fn a_model_two_folders_above_is_read_where_that_is_allowed() {
    let ron = RON.replace("a.obj", "assets/obj/a.obj");
    let files = [("assets/scenes/a.ron", ron.as_str()), ("assets/obj/a.obj", OBJ)];
    let (_folder, path) = folder(&files);
    let mut scene = resolved(&path.join("assets/scenes/a.ron")).unwrap();
    let error = scene.load().unwrap_err().to_string();
    assert!(error.contains("--allow-outside"), "{error}");
    scene.allow_outside();
    assert_eq!(scene.load().unwrap().scene.primitives.len(), 1);
}
