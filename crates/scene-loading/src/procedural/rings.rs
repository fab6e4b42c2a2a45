//! `rings`: a pyramid of clusters, each of six interlocked pentagonal rings that join the edge
//! midpoints of a dodecahedron, before a wall.
//!
//! Figures and order: `rings.c` of SPD 3.14.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::parts::{Z_UP, glossy, matte, stage, view};
use crate::scene::{Cone, Rgb, Scene};

/// Radius of rods and joints.
const ROD: f64 = 0.07412;

/// One colour per ring: the primaries and their complements.
#[rustfmt::skip]
const COLORS: [Rgb; 6] = [
    [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
];

/// Generates `size` layers; layer `k` has `k * k` clusters.
pub(super) fn generate(size: u32) -> Scene {
    let spread = 1.0 / (PI / 8.0).sin();
    let eye = DVec3::new(-1.0, -spread, 0.5);
    let view = view(eye.to_array(), (eye + DVec3::Y).to_array(), Z_UP, 45.0, 1.0);
    let lights = [[3.0, -spread, 3.0], [-4.0, -spread, 1.0], [2.0, -spread, -4.0]];
    let mut scene = stage(view, &lights);

    let white = scene.push_material(matte([1.0; 3]));
    let distance = spread * f64::from(size + 1);
    let half = 1.01 * (distance - eye.y) * (PI / 8.0).tan();
    let wall = [[half, half], [-half, half], [-half, -half], [half, -half]]
        .map(|[x, z]| DVec3::new(x + eye.x, distance, z + eye.z));
    scene.push_polygon(white, &wall);

    let rings = rings();
    for layer in 0..size {
        let depth = spread * f64::from(layer + 1);
        let across = |i: u32| f64::from(2 * i) - f64::from(layer);
        for z in 0..=layer {
            for x in 0..=layer {
                let offset = DVec3::new(across(x), depth, across(z));
                for (ring, color) in rings.iter().zip(COLORS) {
                    push_ring(&mut scene, color, ring.map(|p| p + offset));
                }
            }
        }
    }
    scene
}

/// Adds a ring in its own material: per corner a rod to the corner before and a joint.
fn push_ring(scene: &mut Scene, color: Rgb, corners: [DVec3; 5]) {
    let material = scene.push_material(glossy(color, 0.5, 0.2, 37.0));
    for (i, &base) in corners.iter().enumerate() {
        let apex = corners[(i + 4) % 5];
        scene.push_cone(material, Cone { base, base_radius: ROD, apex, apex_radius: ROD });
        scene.push_sphere(material, base, ROD);
    }
}

/// The six pentagons of a cluster within the unit sphere: one in the xy plane, and five leaning
/// against it at the angle between two faces of a dodecahedron.
fn rings() -> [[DVec3; 5]; 6] {
    let scale = 1.0 / (1.0 + ROD);
    let flat = std::array::from_fn(|i| {
        let angle = i as f64 * 2.0 * PI / 5.0;
        DVec3::new(scale * angle.cos(), scale * angle.sin(), 0.0)
    });
    let lean = DMat3::from_rotation_x(2.0 * ((PI / 3.0).cos() / (PI / 5.0).sin()).acos());
    std::array::from_fn(|ring| match ring.checked_sub(1) {
        None => flat,
        Some(fifth) => {
            let turn = DMat3::from_rotation_z(PI * (2.0 * fifth as f64 + 1.0) / 5.0);
            flat.map(|p| turn * (lean * p))
        }
    })
}
