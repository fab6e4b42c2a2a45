//! `mount`: a fractal mountain by midpoint displacement on a square grid, and four glass spheres.
//!
//! Figures, order and the pseudo-random numbers: `mount.c` and `libvec.c` of SPD 3.14, with the
//! original (weak) hash that the published scene was made with. The Gaussian deviates come from
//! the polar method over a small linear congruential generator, as in W. H. Press et al.,
//! "Numerical Recipes in C", 1988, section 7.2.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::parts::{Z_UP, matte, phong_exponent, rotation, stage, view};
use crate::scene::{Material, Scene};

/// Fractal dimension of the surface, between 2 and 3.
const DIMENSION: f64 = 2.2;

/// Selects the mountain: added to every seed.
const MOUNTAIN: u64 = 21;

/// Edge of the mountain's square; its lower corner is at (-1, -1).
const WIDTH: f64 = 2.0;

/// Square root of two as the original has it.
#[allow(clippy::approx_constant)]
const DIAGONAL: f64 = 1.4142136;

/// Generates the mountain on a grid of `2^size` squares per side.
pub(super) fn generate(size: u32) -> Scene {
    let view = view([-1.6, 1.6, 1.7], [0.0; 3], Z_UP, 45.0, 0.01);
    let mut scene = stage(view, &[[-100.0, -100.0, 100.0]]);
    let glass = scene.push_material(Material {
        color: [1.0; 3],
        diffuse: 0.1,
        specular: 0.1,
        shine: phong_exponent(6.7),
        transmittance: 0.9,
        refraction_index: 1.5,
        ..Material::default()
    });
    push_pyramid(&mut scene, glass, DVec3::new(-0.8, 0.8, 1.0), 0.17);

    let rock = scene.push_material(matte([0.5, 0.45, 0.35]));
    let ratio = 2.0 / (2.0_f64.ln() / (DIMENSION - 1.0)).exp();
    let roughness = (ratio * ratio - 1.0).sqrt();
    let points = 1 << size;
    let mut mountain = Mountain { scene, material: rock, size, points, roughness };
    let whole = Tile { x: 0, y: 0, width: points, heights: [0.0; 4] };
    mountain.grow(whole);
    mountain.scene
}

/// Adds four spheres of that radius, each touching the others; the first is on top.
fn push_pyramid(scene: &mut Scene, material: u32, center: DVec3, radius: f64) {
    let up = DVec3::new(0.0, 0.0, radius * 1.5_f64.sqrt());
    scene.push_sphere(material, center + up, radius);
    let foot = rotation(DVec3::new(1.0, 1.0, 0.0), (-1.0_f64 / 3.0).acos()) * up;
    for third in 0..3 {
        let turn = DMat3::from_rotation_z(f64::from(third) * 2.0 * PI / 3.0);
        scene.push_sphere(material, turn * foot + center, radius);
    }
}

struct Mountain {
    scene: Scene,
    material: u32,
    size: u32,
    /// Grid squares per side.
    points: u32,
    roughness: f64,
}

/// A square part of the grid; corners run against the clock from the lower left one.
struct Tile {
    x: u32,
    y: u32,
    width: u32,
    heights: [f64; 4],
}

impl Mountain {
    /// Splits a tile in four until it is one grid square, which becomes two triangles.
    fn grow(&mut self, tile: Tile) {
        let Tile { x, y, width, heights: [ll, lr, ur, ul] } = tile;
        if width == 1 {
            return self.push_square(&tile);
        }
        let half = width / 2;
        let rise = f64::from(half) * WIDTH / f64::from(self.points) * self.roughness;
        let deviate = |x, y| gaussian(MOUNTAIN + hash(x, y, self.size));
        let lower = (ll + lr) / 2.0 + rise * deviate(x + half, y);
        let right = (lr + ur) / 2.0 + rise * deviate(x + width, y + half);
        let upper = (ur + ul) / 2.0 + rise * deviate(x + half, y + width);
        let left = (ul + ll) / 2.0 + rise * deviate(x, y + half);
        let middle = (ll + lr + ur + ul) / 4.0 + DIAGONAL * rise * deviate(x + half, y + half);
        for (dx, dy, heights) in [
            (0, 0, [ll, lower, middle, left]),
            (half, 0, [lower, lr, right, middle]),
            (half, half, [middle, right, ur, upper]),
            (0, half, [left, middle, upper, ul]),
        ] {
            self.grow(Tile { x: x + dx, y: y + dy, width: half, heights });
        }
    }

    fn push_square(&mut self, tile: &Tile) {
        let at = |i: u32| -1.0 + f64::from(i) * WIDTH / f64::from(self.points);
        let [ll, lr, ur, ul] = tile.heights;
        let (left, right) = (at(tile.x), at(tile.x + 1));
        let (lower, upper) = (at(tile.y), at(tile.y + 1));
        let ll = DVec3::new(left, lower, ll);
        let lr = DVec3::new(right, lower, lr);
        let ur = DVec3::new(right, upper, ur);
        let ul = DVec3::new(left, upper, ul);
        self.scene.push_polygon(self.material, &[ll, lr, ur]);
        self.scene.push_polygon(self.material, &[ur, ul, ll]);
    }
}

/// Seed for a grid point: sixteen bits that repeat within the mountain, as in the published scene.
///
/// Shifts that would be negative (`size` above 7) drop out, as they do where the original runs.
fn hash(x: u32, y: u32, size: u32) -> u64 {
    let shifted = |value: u32, bits: u32| match bits.checked_sub(size) {
        Some(shift) => u64::from(value) << shift,
        None => 0,
    };
    (shifted(x, 23) + shifted(y, 15) + shifted(x, 7)) & 0xffff
}

/// A normally distributed number, a function of the seed alone.
fn gaussian(seed: u64) -> f64 {
    const MODULUS: u64 = 134_456;
    let next = |state: u64| (state * 8121 + 28411) % MODULUS;
    let symmetric = |state: u64| state as f64 * 2.0 / MODULUS as f64 - 1.0;
    let mut state = seed;
    loop {
        let first = next(state);
        state = next(first);
        let (u, v) = (symmetric(first), symmetric(state));
        let square = u * u + v * v;
        if square < 1.0 {
            return u * (-2.0 * square.ln() / square).sqrt();
        }
    }
}
