//! `cloth`: a cloth on a rod that waves in the wind, of triangles 16 times as long as wide. Nothing
//! in it is rigid.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::animation::generated::stage::{Frames, seconds};
use crate::procedural::parts::{Z_UP, matte, stage, view};
use crate::scene::{Primitive, Scene, Shape};

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
        fill(&mut scene, material, [rows, strips], seconds(frame));
        scene
    })
}

fn fill(scene: &mut Scene, material: u32, [rows, strips]: [u32; 2], time: f64) {
    let corners = (0..=rows).flat_map(|row| (0..=strips).map(move |strip| (row, strip)));
    scene.vertices = corners
        .map(|(row, strip)| {
            at(f64::from(strip) / f64::from(strips), f64::from(row) / f64::from(rows), time)
        })
        .collect();
    let corner = |row: u32, strip: u32| row * (strips + 1) + strip;
    scene.primitives = Vec::with_capacity(2 * rows as usize * strips as usize);
    for row in 0..rows {
        for strip in 0..strips {
            let [a, b] = [corner(row, strip), corner(row, strip + 1)];
            let [c, d] = [corner(row + 1, strip), corner(row + 1, strip + 1)];
            for v in [[a, c, d], [a, d, b]] {
                scene.primitives.push(Primitive { shape: Shape::Triangle { v }, material });
            }
        }
    }
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
