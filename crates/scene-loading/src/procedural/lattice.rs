//! `lattice`: a cubic lattice of mirroring spheres joined by matte cylinders, seen from within.
//!
//! The scene is Antonio Costa's. Figures and order: `lattice.c` of SPD 3.14.

use glam::DVec3;

use super::parts::{glossy, matte, stage, view};
use crate::scene::{Cone, Material, Rgb, Scene};

/// Radius of a sphere, in cells.
const BALL: f64 = 1.0 / 4.0;

/// Radius of a cylinder, in cells.
const ROD: f64 = 1.0 / 16.0;

/// Colours of the cylinders along x, y and z.
const ROD_COLORS: [Rgb; 3] = [[0.9, 0.1, 0.1], [0.1, 0.9, 0.1], [0.1, 0.1, 0.9]];

/// Generates the lattice in the unit cube, `size` cells along each edge.
pub(super) fn generate(size: u32) -> Scene {
    let n = f64::from(size);
    let cell = 1.0 / n;
    let middle = (f64::from(size / 2) + 0.5) * cell;
    let half_cell = 1.0 / (2.0 * n);
    let view = view(
        [middle, 1.0, 1.0 - half_cell],
        [middle, -1.0, -1.0 - half_cell],
        [0.2, 1.0, 0.0],
        60.0,
        0.0,
    );
    #[rustfmt::skip]
    let lights = [
        [2.0, 0.5, 0.5], [-1.0, 0.5, 0.5], [0.5, 2.0, 0.5], [0.5, -1.0, 0.5], [0.5, 0.5, 2.0],
        [0.5, 0.5, -1.0],
    ];
    let mut scene = stage(view, &lights);
    let (ball, rod) = (BALL / n, ROD / n);
    // Cylinders start a little within the spheres' surfaces.
    let gap = ball * (1.0 - (ROD / BALL).sqrt()) * 0.99;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for x in 0..=size {
        for y in 0..=size {
            for z in 0..=size {
                let node = [x, y, z];
                let center = DVec3::from_array(node.map(|i| f64::from(i) / n));
                let material = scene.push_material(glossy([0.9; 3], 0.5, 0.5, 37.0));
                scene.push_sphere(material, center, ball);
                for axis in (0..3).filter(|&axis| node[axis] != size) {
                    let along = axes[axis];
                    let material =
                        scene.push_material(Material { diffuse: 0.99, ..matte(ROD_COLORS[axis]) });
                    scene.push_cone(
                        material,
                        Cone {
                            base: center + along * gap,
                            base_radius: rod,
                            apex: center + along * cell - along * gap,
                            apex_radius: rod,
                        },
                    );
                }
            }
        }
    }
    scene
}
