//! Scenes of flat polygons, for tracers that know nothing else.

use glam::{DVec2, DVec3, dvec3};
use scene_loading::{Camera, Light, Material, Scene, Shape, procedural};

/// An empty scene seen from (0, 0, 5) along -z, with a light.
pub fn stage(name: &str) -> Scene {
    let mut scene = Scene::new(name);
    scene.background = [0.2, 0.4, 0.6];
    scene.camera = Camera { from: dvec3(0.1, 0.2, 5.0), angle: 50.0, ..Camera::default() };
    let position = dvec3(3.0, 6.0, 4.0);
    scene.lights.push(Light::point(position, Some([1.0; 3])));
    scene
}

pub fn matte(scene: &mut Scene, color: [f64; 3]) -> u32 {
    scene.push_material(Material { color, ..Material::default() })
}

/// A rectangle: a corner and two edges.
pub fn rectangle(scene: &mut Scene, material: u32, corner: DVec3, a: DVec3, b: DVec3) {
    scene.push_polygon(material, &[corner, corner + a, corner + a + b, corner + b]);
}

/// The mountain without its glass spheres.
pub fn bare_mount(size: u32) -> Scene {
    let mut scene = procedural::generate(&format!("mount:{size}")).unwrap();
    scene.primitives.retain(|p| !matches!(p.shape, Shape::Sphere(_)));
    scene
}

pub fn tetra(size: u32) -> Scene {
    procedural::generate(&format!("tetra:{size}")).unwrap()
}

/// A star, a bracket and a spiral, one behind another.
pub fn concave() -> Scene {
    let mut scene = stage("concave");
    let [red, green, blue] =
        [[0.9, 0.2, 0.1], [0.2, 0.8, 0.2], [0.2, 0.3, 0.9]].map(|c| matte(&mut scene, c));
    let star = |i: u32| {
        let angle = f64::from(i) / 14.0 * std::f64::consts::TAU;
        (DVec2::from_angle(angle) * if i.is_multiple_of(2) { 1.3 } else { 0.5 }).extend(1.0)
    };
    scene.push_polygon(red, &(0..14).map(star).collect::<Vec<_>>());
    let bracket = [(-1.8, -1.5), (1.7, -1.4), (1.6, -0.7), (-1.0, -0.8), (-1.1, 0.9), (1.5, 0.8)];
    let bracket = bracket.into_iter().chain([(1.7, 1.5), (-1.9, 1.6)]);
    scene.push_polygon(green, &bracket.map(|(x, y)| dvec3(x, y, 0.2 * x)).collect::<Vec<_>>());
    let turn = |i: i32, grow: f64| {
        let angle = f64::from(i) / 9.0 * std::f64::consts::TAU;
        (DVec2::from_angle(angle) * (grow + f64::from(i) * 0.08)).extend(-1.5)
    };
    let spiral: Vec<DVec3> =
        (0..30).map(|i| turn(i, 0.3)).chain((0..30).rev().map(|i| turn(i, 0.6))).collect();
    scene.push_polygon(blue, &spiral);
    scene
}

/// Three bars, each over the next one.
pub fn cycle() -> Scene {
    let mut scene = stage("cycle");
    for k in 0..3 {
        let color = std::array::from_fn(|i| if i == k { 0.9 } else { 0.2 });
        let material = matte(&mut scene, color);
        let angle = f64::from(k as u32) / 3.0 * std::f64::consts::TAU;
        let at =
            |x: f64, y: f64, z: f64| DVec2::from_angle(angle).rotate(DVec2::new(x, y)).extend(z);
        let bar = [at(-2.0, 0.4, 0.6), at(2.0, 0.4, -0.6), at(2.0, 0.9, -0.6), at(-2.0, 0.9, 0.6)];
        scene.push_polygon(material, &bar);
    }
    scene
}

/// Planes that go through each other, and twins in one plane.
pub fn intersecting() -> Scene {
    let mut scene = stage("intersecting");
    for k in 0..5 {
        let material = matte(&mut scene, [0.2 * f64::from(k), 0.5, 0.9 - 0.2 * f64::from(k)]);
        let (s, c) = (f64::from(k) * 0.9).sin_cos();
        let (a, b) = (dvec3(3.0 * c, 0.4, 3.0 * s), dvec3(-0.5 * s, 2.5, 0.9 * c));
        rectangle(&mut scene, material, -(a + b) * 0.5, a, b);
    }
    let grey = matte(&mut scene, [0.5; 3]);
    rectangle(&mut scene, grey, dvec3(-1.5, -1.5, 1.0), DVec3::X, DVec3::Y);
    rectangle(&mut scene, grey, dvec3(-1.0, -1.2, 1.0), DVec3::X, DVec3::Y);
    scene
}

/// Coloured shapes before a mirror that leans, and one behind it.
pub fn mirror() -> Scene {
    let mut scene = stage("mirror");
    let silver = scene.push_material(Material {
        diffuse: 0.1,
        specular: 0.8,
        shine: 20.0,
        ..Material::default()
    });
    let (a, b) = (dvec3(3.1, 0.2, -1.2), dvec3(-0.3, 2.8, 0.2));
    rectangle(&mut scene, silver, dvec3(-1.7, -1.6, -1.0), a, b);
    let [red, green, blue] =
        [[0.9, 0.2, 0.1], [0.2, 0.8, 0.2], [0.2, 0.3, 0.9]].map(|c| matte(&mut scene, c));
    scene
        .push_triangle(red, [dvec3(-0.9, -0.7, 0.4), dvec3(0.3, -0.6, 0.9), dvec3(-0.4, 0.3, 0.3)]);
    let star = |i: u32| {
        let angle = f64::from(i) / 10.0 * std::f64::consts::TAU;
        let p = DVec2::from_angle(angle) * if i.is_multiple_of(2) { 1.5 } else { 0.6 };
        dvec3(p.x + 3.9, p.y + 0.2, 3.0)
    };
    scene.push_polygon(green, &(0..10).map(star).collect::<Vec<_>>());
    // through the mirror: a beam that starts too early meets the part behind it
    let spike = [dvec3(0.9, 0.6, 0.4), dvec3(0.6, 1.0, 0.5), dvec3(-1.8, -0.2, -3.5)];
    scene.push_triangle(blue, spike);
    rectangle(&mut scene, blue, dvec3(-4.0, -1.9, -4.0), DVec3::X * 8.0, DVec3::Z * 13.0);
    scene
}

/// Two mirrors that face each other, and a triangle between them.
pub fn two_mirrors() -> Scene {
    let mut scene = stage("two mirrors");
    let silver = scene.push_material(Material {
        diffuse: 0.2,
        specular: 0.7,
        shine: 20.0,
        ..Material::default()
    });
    rectangle(&mut scene, silver, dvec3(-1.2, -1.5, -20.0), dvec3(0.1, 3.0, 0.0), DVec3::Z * 23.0);
    rectangle(&mut scene, silver, dvec3(1.1, -1.4, -20.1), dvec3(0.1, 2.9, 0.2), DVec3::Z * 23.0);
    let red = matte(&mut scene, [0.9, 0.2, 0.1]);
    scene.push_triangle(
        red,
        [dvec3(-0.4, -0.5, -1.0), dvec3(0.5, -0.4, 0.0), dvec3(0.1, 0.6, -0.6)],
    );
    scene
}

/// Triangles and quadrilaterals anywhere, through each other and around the eye, one in five a
/// mirror.
pub fn soup(seed: u64, count: u32) -> Scene {
    let mut state = seed;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1_u64 << 24) as f64
    };
    let mut point = |size: f64| (dvec3(random(), random(), random()) - 0.5) * size;
    let mut scene = stage("soup");
    scene.camera.from = dvec3(0.1, 0.2, 2.0);
    let materials = [0.0, 0.7].map(|specular| {
        let color = [0.3 + specular, 0.6, 0.9 - specular];
        scene.push_material(Material { color, specular, shine: 3.0, ..Material::default() })
    });
    let fill = dvec3(-1.0, -0.5, 3.0);
    scene.lights.push(Light::point(fill, Some([0.5; 3])));
    for k in 0..count {
        let material = materials[usize::from(k % 5 == 0)];
        let (corner, a, b) = (point(5.0), point(2.5), point(2.5));
        if k % 2 == 0 {
            scene.push_triangle(material, [corner, corner + a, corner + b]);
        } else {
            rectangle(&mut scene, material, corner, a, b);
        }
    }
    scene
}

/// A floor, and a square between it and a light; the eye is under the square and looks down.
pub fn square_shadow() -> Scene {
    let mut scene = Scene::new("square shadow");
    let m = matte(&mut scene, [1.0; 3]);
    rectangle(&mut scene, m, dvec3(-9.0, -9.0, 0.0), DVec3::X * 18.0, DVec3::Y * 18.0);
    rectangle(&mut scene, m, dvec3(-0.3, -0.2, 2.0), DVec3::X * 0.5, DVec3::Y * 0.6);
    let position = dvec3(0.3, 0.1, 5.0);
    scene.lights = vec![Light::point(position, Some([1.0; 3]))];
    let angle = 2.0_f64.atan2(2.0).to_degrees() * 2.0;
    let (from, at) = (DVec3::Z, DVec3::ZERO);
    scene.camera = Camera { from, at, up: DVec3::Y, angle, ..Camera::default() };
    scene
}

/// A block of glass before some stripes.
pub fn slab() -> Scene {
    let mut scene = stage("slab");
    let glass = scene.push_material(Material {
        diffuse: 0.0,
        transmittance: 0.9,
        refraction_index: 1.5,
        ..Material::default()
    });
    let turned = |p: DVec3| glam::DQuat::from_rotation_y(0.6) * p;
    let corner = dvec3(-1.2, -1.0, 0.0);
    let (x, y, z) = (DVec3::X * 2.4, DVec3::Y * 2.2, DVec3::Z * 0.8);
    // seen from outside
    let zero = DVec3::ZERO;
    let sides = [(z, x, y), (zero, y, x), (zero, z, y), (x, y, z), (y, z, x), (zero, x, z)];
    for (at, a, b) in sides {
        rectangle(&mut scene, glass, turned(corner + at), turned(a), turned(b));
    }
    let red = matte(&mut scene, [0.9, 0.2, 0.1]);
    for k in -4..=4 {
        let corner = dvec3(f64::from(k) * 0.7, -3.0, -2.0);
        rectangle(&mut scene, red, corner, DVec3::X * 0.3, DVec3::Y * 6.0);
    }
    scene
}
