//! `wall`: a wall of bricks that is hit in the middle and breaks. Each brick flies on its own, from
//! when the shock reaches it, and lies flat where it lands; bricks pass through one another.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec3};

use crate::animation::generated::stage::{self, Frames, Mesh, Stage, seconds};
use crate::procedural::parts::{Z_UP, ground, matte, stage, view};

/// Point at which the wall is hit: above the middle of its foot, for a wall 2 wide and 1 high.
const HIT: DVec3 = DVec3::new(0.1, 0.0, 0.45);

/// When it is hit, seconds.
const HIT_AT: f64 = 0.08;

/// How fast the shock runs, units per second.
const SHOCK: f64 = 2.5;

/// Units per second squared.
const GRAVITY: f64 = 9.81 / 3.0;

/// The ground, and 12 triangles a brick.
pub(super) fn count(size: u32) -> u64 {
    2 + 12 * u64::from(size).pow(2)
}

pub(super) fn frames(size: u32) -> Frames {
    let view = view([2.3, 4.6, 2.0], [0.0, 0.9, 0.3], Z_UP, 42.0, 0.0);
    let mut stage = Stage::new(stage(view, &[[2.0, 4.0, 5.0], [-4.0, 2.0, 3.0]]));
    stage.part_at_rest(Mesh::quadrangle(ground(20.0, 0.0)), matte([0.55, 0.6, 0.5]));
    let kinds = [[0.6, 0.25, 0.18], [0.52, 0.2, 0.15], [0.68, 0.33, 0.25]];
    let kinds = kinds.map(|color| stage.scene.push_material(matte(color)));
    let height = 1.0 / f64::from(size);
    // narrower than its place, so that a wall at rest has no two faces in one plane
    let half = DVec3::new(height, height, 0.5 * height) * 0.98;
    let brick = stage.mesh(Mesh::block(-half, half));
    let bricks: Vec<Brick> = (0..size * size)
        .map(|i| Brick::new(u64::from(i), [i % size, i / size].map(f64::from), height))
        .collect();
    for i in 0..bricks.len() as u64 {
        stage.part(brick, kinds[stage::random_below(3, i, 0) as usize]);
    }
    Box::new(move |frame| stage.placed(bricks.iter().map(|brick| brick.at(seconds(frame)))))
}

/// The flight of a brick.
struct Brick {
    from: DVec3,
    velocity: DVec3,
    /// When the shock reaches it, seconds.
    starts: f64,
    /// How long it flies, seconds.
    flies: f64,
    /// By what it turns in the air: whole turns about this axis, and an angle about the vertical.
    axis: DVec3,
    turns: f64,
    yaw: f64,
}

impl Brick {
    /// Brick `i`, in a column and a row of bricks that are 2 heights long.
    fn new(i: u64, [column, row]: [f64; 2], height: f64) -> Self {
        let shift = if row % 2.0 == 0.0 { 0.25 } else { 0.75 };
        let from = DVec3::new((column + shift) * 2.0 * height - 1.0, 0.0, (row + 0.5) * height);
        let off = from - HIT;
        let near = 1.0 / (1.0 + 6.0 * off.length_squared());
        let strength = stage::between(0.7, 1.3, i, 1);
        let out = DVec3::new(1.6 * off.x, 0.3 + 2.4 * near, 0.4 + 1.2 * off.z + 0.6 * near);
        let mut velocity = (out + 0.35 * stage::vector(i, 2)) * strength;
        velocity.z = velocity.z.max(0.05);
        // until it lies on the ground
        let drop = from.z - 0.5 * height;
        let rise = velocity.z;
        let flies = (rise + (rise * rise + 2.0 * GRAVITY * drop).sqrt()) / GRAVITY;
        Self {
            from,
            velocity,
            starts: HIT_AT + off.length() / SHOCK,
            flies,
            axis: (stage::vector(i, 5) + DVec3::new(1.5, 0.0, 0.0)).normalize(),
            turns: (flies * stage::between(0.5, 3.0, i, 8) * (0.4 + near)).round(),
            yaw: stage::between(-PI, PI, i, 9),
        }
    }

    fn at(&self, time: f64) -> DAffine3 {
        let t = (time - self.starts).clamp(0.0, self.flies);
        let fallen = DVec3::new(0.0, 0.0, 0.5 * GRAVITY * t * t);
        let share = t / self.flies;
        let turn = DMat3::from_rotation_z(self.yaw * share)
            * DMat3::from_axis_angle(self.axis, TAU * self.turns * share);
        DAffine3::from_mat3_translation(turn, self.from + self.velocity * t - fallen)
    }
}
