//! `stadium`: the hare on the pitch of a stadium 230 units long: the teapot in a stadium.
//!
//! Ours, after the name that E. Haines gave to the problem (Ray Tracing News 1, 1988): a structure
//! whose cells are all of one size has the whole figure in one of them.

use glam::DVec3;

use super::hare::push_hare;
use super::parts::{Y_UP, matte, push_triangle, stage, view};
use crate::scene::Scene;

const ROWS: u32 = 28;
/// Segments of each row, all around.
const SEGMENTS: u32 = 141;
/// Half the length and half the width of the pitch, which the first row surrounds.
const PITCH: [f64; 2] = [73.0, 48.0];
/// Depth and height of a row.
const ROW: [f64; 2] = [1.5, 0.8];

/// Generates the stadium around a hare of that size.
pub(super) fn generate(size: u32) -> Scene {
    let view = view([0.55, 0.28, 0.75], [0.0, 0.2, 0.0], Y_UP, 50.0, 0.0);
    let mut scene = stage(view, &[[30.0, 60.0, 40.0]]);
    let fur = scene.push_material(matte([0.62, 0.5, 0.38]));
    let grass = scene.push_material(matte([0.2, 0.55, 0.2]));
    let concrete = scene.push_material(matte([0.6, 0.6, 0.62]));
    push_hare(&mut scene, fur, size, DVec3::new(0.0, 0.13, 0.0));
    push_pitch(&mut scene, grass);
    push_stands(&mut scene, concrete);
    scene
}

/// Eight triangles of grass around the middle, as far as the last row.
fn push_pitch(scene: &mut Scene, material: u32) {
    let half = [PITCH[0] + ROW[0] * f64::from(ROWS), PITCH[1] + ROW[0] * f64::from(ROWS)];
    #[rustfmt::skip]
    let rim: [[f64; 2]; 8] = [
        [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0], [0.0, -1.0],
        [1.0, -1.0],
    ];
    let first = scene.vertices.len() as u32;
    scene.vertices.push(DVec3::ZERO);
    scene.vertices.extend(rim.map(|[x, z]| DVec3::new(x * half[0], 0.0, z * half[1])));
    for i in 0..8 {
        push_triangle(scene, material, [first, first + 1 + (i + 1) % 8, first + 1 + i]);
    }
}

/// Rows of risers and treads, rising outwards.
fn push_stands(scene: &mut Scene, material: u32) {
    let first = scene.vertices.len() as u32;
    // three rings a row: foot and head of its riser, the far edge of its tread
    for row in 0..ROWS {
        for (out, up) in [(row, row), (row, row + 1), (row + 1, row + 1)] {
            for i in 0..SEGMENTS {
                let (sin, cos) =
                    (std::f64::consts::TAU * f64::from(i) / f64::from(SEGMENTS)).sin_cos();
                let [x, z] = PITCH.map(|half| half + ROW[0] * f64::from(out));
                scene.vertices.push(DVec3::new(cos * x, ROW[1] * f64::from(up), sin * z));
            }
        }
    }
    for row in 0..ROWS {
        for ring in 0..2 {
            let low = first + (3 * row + ring) * SEGMENTS;
            let high = low + SEGMENTS;
            for i in 0..SEGMENTS {
                let j = (i + 1) % SEGMENTS;
                push_triangle(scene, material, [low + i, high + i, high + j]);
                push_triangle(scene, material, [low + i, high + j, low + j]);
            }
        }
    }
}
