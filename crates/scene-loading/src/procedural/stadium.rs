//! `stadium`: the hare on the pitch of a stadium 230 units long: the teapot in a stadium.
//!
//! Ours, after the name that E. Haines gave to the problem (Ray Tracing News 1, 1988): a structure
//! whose cells are all of one size has the whole figure in one of them.

use glam::DVec3;

use super::hare::push_hare;
use super::parts::{Y_UP, matte, stage, view};
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
    let rim = rim.map(|[x, z]| DVec3::new(x * half[0], 0.0, z * half[1]));
    let triangles = (0..8).map(|i| [0, 1 + (i + 1) % 8, 1 + i]);
    scene.push_mesh(material, std::iter::once(DVec3::ZERO).chain(rim), triangles);
}

/// Rows of risers and treads, rising outwards.
fn push_stands(scene: &mut Scene, material: u32) {
    // three rings a row: foot and head of its riser, the far edge of its tread
    let rings = (0..ROWS).flat_map(|row| [(row, row), (row, row + 1), (row + 1, row + 1)]);
    let vertices = rings.flat_map(|(out, up)| {
        (0..SEGMENTS).map(move |i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(SEGMENTS)).sin_cos();
            let [x, z] = PITCH.map(|half| half + ROW[0] * f64::from(out));
            DVec3::new(cos * x, ROW[1] * f64::from(up), sin * z)
        })
    });
    let strips = (0..ROWS).flat_map(|row| [3 * row, 3 * row + 1].map(|ring| ring * SEGMENTS));
    let triangles = strips.flat_map(|low| {
        (0..SEGMENTS).flat_map(move |i| {
            let (high, j) = (low + SEGMENTS, (i + 1) % SEGMENTS);
            [[low + i, high + i, high + j], [low + i, high + j, low + j]]
        })
    });
    scene.push_mesh(material, vertices, triangles);
}
