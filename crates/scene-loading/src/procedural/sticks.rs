//! `sticks`: a heap of long thin sticks in all directions, each in the way of many others.
//!
//! Ours. The box of a stick is some thousand times as large as the stick, so that hierarchies of
//! boxes overlap everywhere, while each cell of a grid has only what passes through it. Places and
//! directions are terms of an additive recurrence in six dimensions, which fills them evenly: M.
//! Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018.

use glam::DVec3;

use super::parts::{Y_UP, matte, stage, view};
use crate::scene::Scene;

const LENGTH: f64 = 1.2;
/// Half a side of its square section.
const HALF_SIDE: f64 = 0.001;
/// Powers -1 to -6 of the root of x^7 = x + 1.
#[rustfmt::skip]
const STEPS: [f64; 6] = [
    0.898_653_712_628_699, 0.807_578_495_221_321, 0.725_733_412_969_76, 0.652_183_025_943_972,
    0.586_086_697_577_969, 0.526_688_986_700_736,
];

/// Generates `size` squared sticks.
pub(super) fn generate(size: u32) -> Scene {
    let view = view([2.6, 1.9, 3.1], [0.0, 0.0, 0.0], Y_UP, 40.0, 0.0);
    let mut scene = stage(view, &[[5.0, 9.0, 4.0]]);
    let wood = scene.push_material(matte([0.75, 0.55, 0.3]));
    for stick in 1..=u64::from(size).pow(2) {
        let [x, y, z, height, turn, roll] = STEPS.map(|step| (step * stick as f64).fract());
        push_stick(&mut scene, wood, DVec3::new(x, y, z) * 2.0 - 1.0, [height, turn, roll]);
    }
    scene
}

/// A stick around `middle`; direction and roll are drawn by numbers in [0, 1).
fn push_stick(scene: &mut Scene, material: u32, middle: DVec3, [height, turn, roll]: [f64; 3]) {
    // evenly on the sphere, by Archimedes
    let height = 2.0 * height - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
    let out = (1.0 - height * height).sqrt();
    let along = DVec3::new(out * cos, height, out * sin);
    let across = along.any_orthonormal_vector();
    let (sin, cos) = (std::f64::consts::TAU * roll).sin_cos();
    let across =
        [across * cos + along.cross(across) * sin, along.cross(across) * cos - across * sin];
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = [-0.5, 0.5].into_iter().flat_map(|end| {
        square.map(|(a, b)| {
            middle + along * (LENGTH * end) + (across[0] * a + across[1] * b) * HALF_SIDE
        })
    });
    let sides = (0..4).flat_map(|i| {
        let j = (i + 1) % 4;
        [[i, j, 4 + j], [i, 4 + j, 4 + i]]
    });
    let caps = [[2, 1, 0], [3, 2, 0], [4, 5, 6], [4, 6, 7]];
    scene.push_mesh(material, corners, sides.chain(caps));
}
