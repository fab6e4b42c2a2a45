//! `marbles`: marbles that fall into a bowl, of 80 triangles each and 110 of them by default, as
//! those of I. Wald, T. Ize, A. Kensler, A. Knoll, S. Parker, "Ray Tracing Animated Scenes using
//! Coherent Grid Traversal", SIGGRAPH 2006. Deviation: theirs is not public; bowl, course and
//! camera are ours.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec3};

use crate::animation::generated::falling::{BOWL, Balls, STEPS};
use crate::animation::generated::mesh::Mesh;
use crate::animation::generated::stage::{Frames, RATE, Replay, Stage};
use crate::procedural::parts::{Z_UP, glossy, ground, matte, stage, view};

/// Rings of the bowl from its lowest point to its rim, and squares in each.
const RINGS: u32 = 10;
const AROUND: u32 = 32;

/// The ground, the bowl with a ring of triangles at its lowest point, 80 triangles a marble.
pub(super) fn count(size: u32) -> u64 {
    2 + u64::from(AROUND * (2 * RINGS - 1)) + 80 * u64::from(size)
}

pub(super) fn frames(size: u32) -> Frames {
    let view = view([1.1, -3.8, 2.7], [0.0, 0.0, 0.3], Z_UP, 46.0, 0.0);
    let mut stage = Stage::new(stage(view, &[[2.0, -2.0, 5.0], [-4.0, -3.0, 4.0]]));
    let floor = stage.scene.push_material(matte([0.6, 0.55, 0.5]));
    stage.part_of(Mesh::quadrangle(ground(8.0, -BOWL)), floor);
    let wood = stage.scene.push_material(matte([0.5, 0.38, 0.25]));
    stage.part_of(bowl(), wood);
    let colors = [[0.8, 0.2, 0.15], [0.2, 0.55, 0.25], [0.2, 0.35, 0.8], [0.9, 0.75, 0.25]];
    let kinds = colors.map(|color| stage.scene.push_material(glossy(color, 0.8, 0.15, 10.0)));
    let first = Balls::above_the_bowl(size);
    let marble = stage.mesh(Mesh::ball(2).scaled(DVec3::splat(first.radius)));
    for i in 0..size as usize {
        stage.part(marble, kinds[i % kinds.len()]);
    }
    let mut course = Replay::new(first);
    Box::new(move |frame| {
        let balls = course.after(frame, |balls| (0..STEPS / RATE).for_each(|_| balls.step()));
        let places = balls.turns.iter().zip(&balls.positions);
        let places = places.map(|(&turn, &at)| DAffine3::from_rotation_translation(turn, at));
        stage.placed([DAffine3::IDENTITY; 2].into_iter().chain(places))
    })
}

/// The lower half of a sphere, seen from within; everywhere at least a bowl's radius wide.
fn bowl() -> Mesh {
    let least = (PI / f64::from(AROUND)).cos() * (PI / 4.0 / f64::from(RINGS)).cos();
    let radius = BOWL / least;
    let at = |ring: u32, i: u32| {
        let (sin, cos) = (PI / 2.0 * f64::from(ring) / f64::from(RINGS)).sin_cos();
        let (y, x) = (TAU * f64::from(i) / f64::from(AROUND)).sin_cos();
        // the lowest point stands on the ground
        DMat3::from_diagonal(DVec3::new(radius, radius, BOWL)) * DVec3::new(x * sin, y * sin, -cos)
    };
    let mut mesh = Mesh { vertices: vec![at(0, 0)], ..Mesh::default() };
    for ring in 1..=RINGS {
        mesh.vertices.extend((0..AROUND).map(|i| at(ring, i)));
    }
    let corner = |ring: u32, i: u32| match ring {
        0 => 0,
        _ => 1 + (ring - 1) * AROUND + i % AROUND,
    };
    for ring in 0..RINGS {
        for i in 0..AROUND {
            let [a, b] = [corner(ring, i), corner(ring, i + 1)];
            let [c, d] = [corner(ring + 1, i), corner(ring + 1, i + 1)];
            mesh.triangles.push([a, d, c]);
            if ring > 0 {
                mesh.triangles.push([a, b, d]);
            }
        }
    }
    mesh
}
