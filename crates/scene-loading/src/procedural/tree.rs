//! `tree`: a binary tree of cones and spheres on a field.
//!
//! The model is that of M. Aono and T. L. Kunii, "Botanical Tree Image Generation", IEEE CG&A
//! 4(5), 1984. Figures and order: `tree.c` of SPD 3.14.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3};

use super::parts::{Z_UP, ground, matte, stage, view};
use crate::scene::{Cone, Scene};

/// Length of a branch to its parent's, angle off the parent's direction and angle around it
/// (degrees), for the two branches of every fork.
const FORK: [(f64, f64, f64); 2] = [(0.65, 40.0, 90.0), (0.70, 25.0, 140.0 + 90.0)];

/// Thickness at the end of a branch to that at its start.
const TAPER: f64 = 0.67;

/// Radius of the trunk's base; its length is 1.
const TRUNK: f64 = 0.15;

/// Generates the tree with `size` generations of branches above the trunk.
pub(super) fn generate(size: u32) -> Scene {
    let view = view([4.5, 0.4, 2.0], [0.0, 0.0, 1.5], Z_UP, 45.0, 1.0);
    #[rustfmt::skip]
    let lights = [
        [-5.0, 5.0, 50.0], [30.0, -30.0, 30.0], [-40.0, -30.0, 20.0], [10.0, 30.0, 40.0],
        [-30.0, 40.0, 10.0], [50.0, 25.0, 20.0], [-10.0, -60.0, 30.0],
    ];
    let mut scene = stage(view, &lights);
    let field = scene.push_material(matte([0.2, 0.7, 0.2]));
    scene.push_polygon(field, &ground(50.0, 0.0));
    let material = scene.push_material(matte([0.55, 0.4, 0.2]));
    let forks = FORK.map(|(length, off, around)| {
        let turn =
            DMat3::from_rotation_z(around * PI / 180.0) * DMat3::from_rotation_x(off * PI / 180.0);
        DAffine3 {
            matrix3: DMat3::from_diagonal(DVec3::splat(length)) * turn,
            translation: DVec3::Z,
        }
    });
    let mut tree = Tree { scene, material, forks };
    tree.grow(DAffine3::IDENTITY, 1.0, size);
    tree.scene
}

struct Tree {
    scene: Scene,
    material: u32,
    /// From a branch's frame to those of its two children.
    forks: [DAffine3; 2],
}

impl Tree {
    /// Adds the branch that runs from 0 to 1 along the frame's z axis, and what grows from it.
    fn grow(&mut self, frame: DAffine3, thickness: f64, generations: u32) {
        let base_radius = thickness * TRUNK;
        let apex = frame.transform_point3(DVec3::Z);
        let apex_radius = base_radius * TAPER;
        let branch = Cone { base: frame.translation, base_radius, apex, apex_radius };
        self.scene.push_cone(self.material, branch);
        self.scene.push_sphere(self.material, apex, apex_radius);
        let Some(generations) = generations.checked_sub(1) else { return };
        for fork in self.forks {
            self.grow(frame * fork, thickness * TAPER, generations);
        }
    }
}
