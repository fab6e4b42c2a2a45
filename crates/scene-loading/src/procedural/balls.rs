//! `balls`, the sphereflake: a sphere that carries nine spheres of a third of its radius, each of
//! which carries nine, and so on; on a square floor.
//!
//! Figures and order: `balls.c` of SPD 3.14.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::parts::{Z_UP, glossy, ground, matte, rotation, stage, view};
use crate::scene::{Material, Scene};

/// Radius of a child in its parent's.
const SHRINK: f64 = 1.0 / 3.0;

/// Directions within this much of the z axis (in `z`) count as along it.
const ALONG_AXIS: f64 = 0.9999;

/// Generates the flake with `size` generations of children.
pub(super) fn generate(size: u32) -> Scene {
    let view = view([2.1, 1.3, 1.7], [0.0; 3], Z_UP, 45.0, 0.01);
    let mut scene = stage(view, &[[4.0, 3.0, 2.0], [1.0, -4.0, 4.0], [-3.0, 1.0, 5.0]]);
    let floor = scene.push_material(Material {
        diffuse: 0.8,
        refraction_index: 1.0,
        ..matte([1.0, 0.75, 0.33])
    });
    scene.push_polygon(floor, &ground(12.0, -0.5));
    let mirror = scene.push_material(Material {
        refraction_index: 1.0,
        ..glossy([1.0, 0.9, 0.7], 0.5, 0.5, 37.0)
    });
    let mut flake = Flake { scene, material: mirror, petals: petals() };
    flake.bloom(DVec3::ZERO, 0.5, DVec3::Z, size);
    flake.scene
}

struct Flake {
    scene: Scene,
    material: u32,
    petals: [DVec3; 9],
}

impl Flake {
    /// Adds a sphere that grew in `direction` and `generations` of its offspring, depth first.
    fn bloom(&mut self, center: DVec3, radius: f64, direction: DVec3, generations: u32) {
        self.scene.push_sphere(self.material, center, radius);
        let Some(generations) = generations.checked_sub(1) else { return };
        let turn = rotation_from_z(direction);
        let reach = radius * (1.0 + SHRINK);
        for petal in self.petals {
            let child = turn * petal * reach + center;
            // Not `turn * petal`: what is lost in adding the centre is lost in the files, too.
            let outward = (child - center) / reach;
            self.bloom(child, radius * SHRINK, outward, generations);
        }
    }
}

/// A rotation that takes +z to `direction` (of unit length up to rounding).
fn rotation_from_z(direction: DVec3) -> DMat3 {
    if direction.z >= ALONG_AXIS {
        DMat3::IDENTITY
    } else if direction.z <= -ALONG_AXIS {
        DMat3::from_rotation_y(PI)
    } else {
        rotation(DVec3::Z.cross(direction), direction.z.acos())
    }
}

/// Unit directions of the nine children of a sphere that grew along +z: three edge midpoints of
/// a cube corner turned upright, three times around.
fn petals() -> [DVec3; 9] {
    let upright = rotation(DVec3::new(1.0, -1.0, 0.0), (2.0 / 6.0_f64.sqrt()).asin());
    // Not FRAC_1_SQRT_2, which is one ulp more: that shows where coordinates cancel to about 1e-16,
    // a remainder that the files print.
    let half_diagonal = 1.0 / 2.0_f64.sqrt();
    let trio = [[1.0, 1.0, 0.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0]]
        .map(|d| upright * (DVec3::from_array(d) * half_diagonal));
    std::array::from_fn(|i| {
        let third = (i / 3) as f64;
        DMat3::from_rotation_z(third * 2.0 * PI / 3.0) * trio[i % 3]
    })
}
