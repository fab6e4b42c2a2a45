//! Scenes of smaller copies of themselves.
//!
//! `balls`, the sphereflake: a sphere that carries nine spheres of a third of its radius, each of
//! which carries nine, and so on; on a square floor. `tetra`: the tetrahedral Sierpinski pyramid.
//! `tree`: a binary tree of cones and spheres on a field, by the model of M. Aono and T. L. Kunii,
//! "Botanical Tree Image Generation", IEEE CG&A 4(5), 1984.
//!
//! Figures and order: `balls.c`, `tetra.c` and `tree.c` of SPD 3.14.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3};

use super::parts::{Z_UP, glossy, ground, matte, rotation, stage, view};
use crate::scene::{Cone, Material, Scene};

/// Radius of a child in its parent's.
const SHRINK: f64 = 1.0 / 3.0;

/// Directions within this much of the z axis (in `z`) count as along it.
const ALONG_AXIS: f64 = 0.9999;

/// Generates the flake with `size` generations of children.
pub(super) fn balls(size: u32) -> Scene {
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
pub(super) fn tetra(size: u32) -> Scene {
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

/// Length of a branch to its parent's, angle off the parent's direction and angle around it
/// (degrees), for the two branches of every fork.
const FORK: [(f64, f64, f64); 2] = [(0.65, 40.0, 90.0), (0.70, 25.0, 140.0 + 90.0)];

/// Thickness at the end of a branch to that at its start.
const TAPER: f64 = 0.67;

/// Radius of the trunk's base; its length is 1.
const TRUNK: f64 = 0.15;

/// Generates the tree with `size` generations of branches above the trunk.
pub(super) fn tree(size: u32) -> Scene {
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
