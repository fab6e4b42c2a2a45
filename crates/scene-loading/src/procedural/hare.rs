//! `hare`: a sitting hare, 0.3 units tall, as one closed mesh of small triangles of like size.
//!
//! Ours: it stands in for scanned figures such as Stanford's bunny (69 thousand triangles, of which
//! not every copy may be passed on). An octahedron's faces are divided and pushed out to a surface
//! that every ray from the middle meets once: a ball with lobes for head, ears, feet and tail, and
//! waves of falling amplitude for the fur.

use std::collections::HashMap;

use glam::DVec3;

use super::parts::{Y_UP, matte, stage, view};
use crate::scene::Scene;

/// Radius of the ball that the lobes stand on.
const BODY: f64 = 0.085;

/// A lobe: where it points, how far it stands out in parts of the body, how narrow it is.
const LOBES: [([f64; 3], f64, f64); 9] = [
    // the haunches, the head, two ears
    ([0.0, -0.5, -0.5], 0.45, 3.0),
    ([0.0, 0.75, 0.6], 0.5, 9.0),
    ([0.25, 1.0, 0.12], 1.35, 70.0),
    ([-0.25, 1.0, 0.12], 1.35, 70.0),
    // four feet, the tail
    ([0.45, -0.75, 0.5], 0.4, 30.0),
    ([-0.45, -0.75, 0.5], 0.4, 30.0),
    ([0.7, -0.75, -0.1], 0.35, 18.0),
    ([-0.7, -0.75, -0.1], 0.35, 18.0),
    ([0.0, -0.3, -1.0], 0.25, 45.0),
];

/// Waves of the fur.
const WAVES: u32 = 40;

/// Generates the hare with each face of the octahedron divided into `size` squared triangles.
pub(super) fn generate(size: u32) -> Scene {
    let view = view([0.32, 0.16, 0.42], [0.0, 0.03, 0.0], Y_UP, 38.0, 0.0);
    let mut scene = stage(view, &[[0.8, 1.2, 0.9]]);
    let material = scene.push_material(matte([0.62, 0.5, 0.38]));
    push_hare(&mut scene, material, size, DVec3::ZERO);
    scene
}

/// Adds the hare around `middle`.
pub(super) fn push_hare(scene: &mut Scene, material: u32, size: u32, middle: DVec3) {
    let waves = waves();
    let n = size as i32;
    // corners of the lattice |x| + |y| + |z| = n, each once, so that the mesh is closed
    let mut corners: HashMap<[i32; 3], u32> = HashMap::new();
    let octants = (0..8).map(|i| [4, 2, 1].map(|bit| if i & bit == 0 { 1 } else { -1 }));
    for [sx, sy, sz] in octants {
        for (a, b, c) in face(n) {
            let mut v = [a, b, c].map(|[x, y, z]| {
                let key = [sx * x, sy * y, sz * z];
                *corners.entry(key).or_insert_with(|| {
                    let d = DVec3::from_array(key.map(f64::from)).normalize();
                    scene.vertices.push(middle + d * radius(d, &waves));
                    scene.vertices.len() as u32 - 1
                })
            });
            if sx * sy * sz < 0 {
                v.swap(1, 2);
            }
            scene.push_corners(material, v, None);
        }
    }
}

/// The triangles of the octahedron's face where no coordinate is negative, against the clock as
/// seen from outside.
pub(crate) fn face(n: i32) -> impl Iterator<Item = ([i32; 3], [i32; 3], [i32; 3])> {
    let at = move |x: i32, y: i32| [x, y, n - x - y];
    let upright =
        (0..n).flat_map(move |x| (0..n - x).map(move |y| (at(x, y), at(x + 1, y), at(x, y + 1))));
    let inverted = (0..n).flat_map(move |x| {
        (0..n - x - 1).map(move |y| (at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)))
    });
    upright.chain(inverted)
}

/// How far the surface is from the middle in a direction of unit length.
fn radius(d: DVec3, waves: &[(DVec3, f64, f64)]) -> f64 {
    let lobes: f64 = LOBES
        .iter()
        .map(|(at, out, narrow)| {
            let towards = DVec3::from_array(*at).normalize();
            out * (narrow * (d.dot(towards) - 1.0)).exp()
        })
        .sum();
    let fur: f64 = waves.iter().map(|(k, phase, a)| a * (k.dot(d) + phase).sin()).sum();
    BODY * (1.0 + lobes + fur)
}

/// Wave vectors, phases and amplitudes, the same on every machine: from the fractional parts of
/// multiples of irrational numbers.
fn waves() -> Vec<(DVec3, f64, f64)> {
    let part = |i: u32, root: f64| (f64::from(i) * root.sqrt()).fract();
    let wave = |i: u32| {
        let z = 2.0 * part(i, 2.0) - 1.0;
        let flat = (1.0 - z * z).sqrt();
        let around = std::f64::consts::TAU * part(i, 3.0);
        let often = 6.0 * 1.09_f64.powi(i as i32);
        let direction = DVec3::new(flat * around.cos(), flat * around.sin(), z);
        (direction * often, std::f64::consts::TAU * part(i, 5.0), 0.12 / often)
    };
    (1..=WAVES).map(wave).collect()
}
