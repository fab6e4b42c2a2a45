//! `cloth`: a cloth on a rod that waves in the wind, of triangles 16 times as long as wide. Nothing
//! in it is rigid.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::animation::generated::stage::{Frames, seconds};
use crate::procedural::parts::{Z_UP, matte, stage, view};

/// Number of strips per row.
const SLIMNESS: u32 = 16;

/// `n` rows of 16 n squares.
pub(super) fn count(size: u32) -> u64 {
    2 * u64::from(SLIMNESS) * u64::from(size).pow(2)
}

pub(super) fn frames(size: u32) -> Frames {
    let view = view([1.1, -3.0, 1.3], [0.0, 0.0, -0.05], Z_UP, 42.0, 0.0);
    let mut still = stage(view, &[[2.0, -4.0, 3.0], [-3.0, -2.0, 2.0]]);
    let material = still.push_material(matte([0.75, 0.2, 0.18]));
    let (rows, strips) = (size, SLIMNESS * size);
    Box::new(move |frame| {
        let mut scene = still.clone();
        let time = seconds(frame);
        let corners = (0..=rows).flat_map(|row| (0..=strips).map(move |strip| (row, strip)));
        let vertices = corners.map(|(row, strip)| {
            at(f64::from(strip) / f64::from(strips), f64::from(row) / f64::from(rows), time)
        });
        let squares = (0..rows).flat_map(|row| (0..strips).map(move |strip| (row, strip)));
        let triangles = squares.flat_map(|(row, strip)| {
            let a = row * (strips + 1) + strip;
            let [b, c, d] = [a + 1, a + strips + 1, a + strips + 2];
            [[a, c, d], [a, d, b]]
        });
        scene.vertices.reserve_exact((rows as usize + 1) * (strips as usize + 1));
        scene.primitives.reserve_exact(2 * rows as usize * strips as usize);
        scene.push_mesh(material, vertices, triangles);
        scene
    })
}

/// Position of a point of the cloth, from (0, 0) at the left end of the rod to (1, 1) at the lower
/// right corner: 2 units wide and long, with waves that grow towards the free edge.
fn at(across: f64, down: f64, time: f64) -> DVec3 {
    let wave = |along: f64, often: f64, phase: f64| {
        (TAU * (along * often - time * often * 0.6 + phase)).sin()
    };
    let swell = down * down;
    let out = swell * (0.22 * wave(down - 0.4 * across, 1.3, 0.0) + 0.1 * wave(across, 2.0, 0.2))
        + down * 0.03 * wave(across + down, 5.0, 0.6);
    let aside = 0.06 * swell * wave(down, 1.0, 0.25);
    // the wind lifts it
    let lift = 0.35 * swell;
    DVec3::new(2.0 * across - 1.0 + aside, out + 0.9 * lift, 1.0 - 2.0 * down + 0.5 * lift)
}
