//! `tetra`: the tetrahedral Sierpinski pyramid.
//!
//! Figures and order: `tetra.c` of SPD 3.14.

use glam::DVec3;

use super::parts::{matte, stage, view};
use crate::scene::Scene;

/// The corners of a cube that form a tetrahedron: those with an even number of minus signs.
const CORNERS: [DVec3; 4] = [
    DVec3::new(-1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, -1.0),
    DVec3::new(1.0, 1.0, 1.0),
];

/// The tetrahedron's faces, as corner numbers.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [3, 2, 1], [2, 3, 0], [1, 0, 3]];

/// Generates the pyramid with `size - 1` subdivisions.
pub(super) fn generate(size: u32) -> Scene {
    let view = view(
        [1.022846, -3.177154, -2.174512],
        [-0.004103, -0.004103, 0.216539],
        [-0.816497, -0.816497, 0.816497],
        45.0,
        1.0,
    );
    let mut scene = stage(view, &[[2.0, -18.0, -5.0]]);
    let red = scene.push_material(matte([1.0, 0.2, 0.2]));
    subdivide(&mut scene, red, DVec3::ZERO, 1.0, size);
    scene
}

/// Adds the pyramid inscribed in the cube of that centre and half edge.
fn subdivide(scene: &mut Scene, material: u32, center: DVec3, half: f64, size: u32) {
    if size > 1 {
        for corner in CORNERS {
            let center = center + corner * (half / 2.0);
            subdivide(scene, material, center, half / 2.0, size - 1);
        }
    } else {
        let corners = CORNERS.map(|corner| center + corner * half);
        for face in FACES {
            scene.push_polygon(material, &face.map(|i| corners[i]));
        }
    }
}
