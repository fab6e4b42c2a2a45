//! `city`: cars in the streets of a city that is at rest: most of the scene does not move, and what
//! does is far apart.

use glam::{DAffine3, DMat3, DVec3};

use crate::animation::generated::stage::{self, Frames, Mesh, Stage, seconds};
use crate::procedural::parts::{Z_UP, ground, matte, stage, view};

/// From one street to the next, and the side of a building's plot, units.
const BLOCK: f64 = 1.0;
const PLOT: f64 = 0.68;

/// Height of a storey, units.
const STOREY: f64 = 0.09;

const WALLS: [[f64; 3]; 4] =
    [[0.75, 0.7, 0.62], [0.6, 0.62, 0.66], [0.72, 0.55, 0.45], [0.5, 0.56, 0.6]];

/// The ground, two blocks a storey, a car of two blocks for each of the streets.
pub(super) fn count(size: u32) -> u64 {
    let storeys: u64 = (0..u64::from(size).pow(2)).map(storeys).sum();
    2 + 24 * storeys + 24 * 2 * u64::from(size)
}

pub(super) fn frames(size: u32) -> Frames {
    let reach = f64::from(size) * BLOCK / 2.0;
    let from = [-1.1 * reach, -1.5 * reach - 1.0, 0.9 * reach + 1.5];
    let view = view(from, [0.0, -0.15 * reach, 0.0], Z_UP, 45.0, 0.0);
    let light = [-3.0 * reach, -2.0 * reach, 5.0 * reach + 5.0];
    let mut stage = Stage::new(stage(view, &[light]));
    stage.part_at_rest(Mesh::quadrangle(ground(reach + BLOCK, 0.0)), matte([0.35, 0.36, 0.37]));
    for (kind, wall) in WALLS.into_iter().enumerate() {
        let of_kind = |i: &u64| stage::random_below(4, *i, 0) == kind as u64;
        let buildings = (0..u64::from(size).pow(2)).filter(of_kind);
        let mesh = buildings.fold(Mesh::default(), |all, i| with_building(all, i, size, reach));
        stage.part_at_rest(mesh, matte(wall));
    }
    let paint = [[0.8, 0.1, 0.1], [0.9, 0.85, 0.2], [0.1, 0.3, 0.8], [0.9, 0.9, 0.9]];
    let paint = paint.map(|color| stage.scene.push_material(matte(color)));
    let car = stage.mesh(car());
    for i in 0..2 * size {
        stage.part(car, paint[i as usize % paint.len()]);
    }
    Box::new(move |frame| {
        stage.placed((0..2 * size).map(|i| car_at(i, size, reach, seconds(frame))))
    })
}

/// Storeys of building `i`: a few are towers.
fn storeys(i: u64) -> u64 {
    let tower = if stage::random_below(8, i, 1) == 0 { 12 } else { 0 };
    5 + stage::random_below(12, i, 2) + tower
}

/// Adds a building: a slab and a somewhat narrower block for each storey.
fn with_building(mut mesh: Mesh, i: u64, size: u32, reach: f64) -> Mesh {
    let [column, row] = [i % u64::from(size), i / u64::from(size)].map(|k| k as f64 + 0.5);
    let middle = DVec3::new(column * BLOCK - reach, row * BLOCK - reach, 0.0);
    let half = [3, 4].map(|what| 0.5 * PLOT * stage::between(0.6, 1.0, i, what));
    for storey in 0..storeys(i) {
        let z = STOREY * storey as f64;
        for (share, from, to) in [(1.0, 0.0, 0.2), (0.93, 0.2, 1.0)] {
            let corner = |side: f64, part: f64| {
                let wide = DVec3::new(half[0], half[1], 0.0) * (side * share);
                middle + wide + DVec3::new(0.0, 0.0, z + STOREY * part)
            };
            mesh = mesh.with(&Mesh::block(corner(-1.0, from), corner(1.0, to)));
        }
    }
    mesh
}

/// A car: a body and a cabin. It drives towards +x.
fn car() -> Mesh {
    let body = Mesh::block(DVec3::new(-0.1, -0.04, 0.015), DVec3::new(0.1, 0.04, 0.05));
    let cabin = Mesh::block(DVec3::new(-0.06, -0.035, 0.05), DVec3::new(0.04, 0.035, 0.08));
    body.with(&cabin)
}

/// Where car `i` is: the first half drives along x, the second along y, each in the street of its
/// number and on the right-hand side.
fn car_at(i: u32, size: u32, reach: f64, time: f64) -> DAffine3 {
    let number = u64::from(i);
    let street = f64::from(i % size) * BLOCK - reach;
    let speed = stage::between(0.4, 1.2, number, 6);
    let length = 2.0 * reach;
    // it stays in the city: 60 frames are 2.4 seconds
    let room = (length - 3.0 * speed).max(0.0);
    let along = -reach + room * stage::unit(number, 5) + speed * time;
    let turn = DMat3::from_rotation_z(if i < size { 0.0 } else { std::f64::consts::FRAC_PI_2 });
    let back = stage::random_below(2, number, 7) == 1;
    let around = DMat3::from_rotation_z(if back { std::f64::consts::PI } else { 0.0 });
    let lane = if back { 0.08 } else { -0.08 };
    let place = DVec3::new(if back { -along } else { along }, lane, 0.0);
    let street = if i < size { DVec3::new(0.0, street, 0.0) } else { DVec3::new(street, 0.0, 0.0) };
    DAffine3::from_mat3_translation(turn * around, turn * place + street)
}
