//! `walker`: a figure that walks, made of capsules and ellipsoids, each rigid: a limb hangs on the
//! one before it. The camera follows. Joints swing as sines of the step; feet may slide.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DVec3};

use crate::animation::generated::stage::{Frames, Mesh, Stage, seconds};
use crate::procedural::parts::{Z_UP, ground, matte, stage, view};

/// Metres per second, double steps per second.
const SPEED: f64 = 1.35;
const STEPS: f64 = 0.95;

/// Height of the hip above the ground, metres.
const HIP: f64 = 0.93;

/// Shapes of limbs: half axes and by how much a capsule is pulled, metres. Their joint is at the
/// origin.
const SHAPES: [([f64; 3], f64); 8] = [
    // pelvis, chest, head
    ([0.11, 0.17, 0.1], 0.0),
    ([0.12, 0.2, 0.27], 0.0),
    ([0.11, 0.09, 0.14], 0.0),
    // upper arm, forearm with hand
    ([0.05, 0.05, 0.05], 0.26),
    ([0.042, 0.045, 0.05], 0.34),
    // thigh, shin, foot
    ([0.08, 0.08, 0.08], 0.42),
    ([0.055, 0.055, 0.055], 0.42),
    ([0.13, 0.045, 0.04], 0.0),
];

/// A limb: its shape, the limb that it hangs on, where the joint is there, and where its own middle
/// is from the joint, metres; how it bends about the y axis with the phase of its side, radians.
type Limb = (u32, Option<usize>, [f64; 3], [f64; 3], f64, fn(f64) -> f64);

const NONE: [f64; 3] = [0.0; 3];

/// The figure, which faces +x. Sides differ by half a double step.
#[rustfmt::skip]
const LIMBS: [Limb; 13] = [
    (0, None, NONE, NONE, 0.0, |_| 0.0),
    (1, Some(0), [0.0, 0.0, 0.08], [0.0, 0.0, 0.27], 0.0, |phase| 0.06 + 0.02 * (2.0 * phase).sin()),
    (2, Some(1), [0.02, 0.0, 0.56], [0.02, 0.0, 0.13], 0.0, |_| -0.04),
    (3, Some(1), [0.0, 0.24, 0.46], NONE, 0.5, |phase| -0.05 - 0.45 * phase.sin()),
    (4, Some(3), [0.0, 0.0, -0.29], NONE, 0.5, |phase| -0.4 - 0.25 * phase.sin()),
    (3, Some(1), [0.0, -0.24, 0.46], NONE, 0.0, |phase| -0.05 - 0.45 * phase.sin()),
    (4, Some(5), [0.0, 0.0, -0.29], NONE, 0.0, |phase| -0.4 - 0.25 * phase.sin()),
    (5, Some(0), [0.0, 0.1, -0.03], NONE, 0.0, |phase| -0.1 - 0.42 * phase.sin()),
    (6, Some(7), [0.0, 0.0, -0.43], NONE, 0.0, knee),
    (7, Some(8), [0.0, 0.0, -0.43], [0.06, 0.0, -0.03], 0.0, ankle),
    (5, Some(0), [0.0, -0.1, -0.03], NONE, 0.5, |phase| -0.1 - 0.42 * phase.sin()),
    (6, Some(10), [0.0, 0.0, -0.43], NONE, 0.5, knee),
    (7, Some(11), [0.0, 0.0, -0.43], [0.06, 0.0, -0.03], 0.5, ankle),
];

/// Bent most while the leg swings forward.
fn knee(phase: f64) -> f64 {
    0.1 + 0.45 * (1.0 + (phase + 0.9).cos())
}

fn ankle(phase: f64) -> f64 {
    -0.2 - 0.25 * (phase + 0.9).cos()
}

/// The ground, and a ball's triangles for each limb.
pub(super) fn count(size: u32) -> u64 {
    2 + 20 * u64::from(size).pow(2) * LIMBS.len() as u64
}

pub(super) fn frames(size: u32) -> Frames {
    let view = view([1.6, -3.0, 1.5], [0.0, 0.0, 0.9], Z_UP, 40.0, 0.0);
    let mut stage = Stage::new(stage(view, &[[3.0, -4.0, 5.0], [-4.0, -3.0, 3.0]]));
    stage.part_at_rest(Mesh::quadrangle(ground(12.0, 0.0)), matte([0.5, 0.55, 0.5]));
    let colors = [[0.25, 0.3, 0.5], [0.7, 0.3, 0.2], [0.8, 0.62, 0.5]];
    let [trousers, shirt, skin] = colors.map(|color| stage.scene.push_material(matte(color)));
    let meshes = SHAPES.map(|(axes, pulled)| {
        let ball = Mesh::ball(size).scaled(DVec3::from_array(axes));
        stage.mesh(ball.pulled_down(pulled))
    });
    for (shape, ..) in LIMBS {
        let material = match shape {
            1 | 3 => shirt,
            2 | 4 => skin,
            _ => trousers,
        };
        stage.part(meshes[shape as usize], material);
    }
    Box::new(move |frame| {
        let time = seconds(frame);
        let ahead = DVec3::new(SPEED * time, 0.0, 0.0);
        let mut scene = stage.placed(pose(TAU * STEPS * time, ahead));
        scene.camera.from += ahead;
        scene.camera.at += ahead;
        scene
    })
}

/// Placements of the limbs at a phase of the double step.
fn pose(phase: f64, ahead: DVec3) -> Vec<DAffine3> {
    let bob = 0.02 * (2.0 * phase).cos();
    let hip = DAffine3::from_translation(ahead + DVec3::new(0.0, 0.0, HIP + bob));
    // of the joints, of which each comes behind the one that it hangs on
    let mut joints: Vec<DAffine3> = Vec::with_capacity(LIMBS.len());
    for (_, on, joint, _, side, bend) in LIMBS {
        let turn = DMat3::from_rotation_y(bend(phase + TAU * side));
        let here = DAffine3::from_mat3_translation(turn, DVec3::from_array(joint));
        let on = on.map_or(hip, |i| joints[i]);
        joints.push(on * here);
    }
    let middle = |offset| DAffine3::from_translation(DVec3::from_array(offset));
    joints.iter().zip(LIMBS).map(|(&joint, limb)| joint * middle(limb.3)).collect()
}
