//! `marbles`: marbles that fall into a bowl, of 80 triangles each and 110 of them by default, as
//! those of I. Wald, T. Ize, A. Kensler, A. Knoll, S. Parker, "Ray Tracing Animated Scenes using
//! Coherent Grid Traversal", SIGGRAPH 2006. Deviation: theirs is not public; bowl, course and
//! camera are ours.
//!
//! Balls that touch exchange impulses with a coefficient of restitution and are pushed apart, one
//! pair after the other, as often as it says; the usual sequential impulses with projection: J.
//! Hahn, "Realistic animation of rigid bodies", SIGGRAPH 1988. Deviations: balls turn as if they
//! rolled where they touch bowl or ground and do not pass on spin; nothing but sums, products and
//! roots, so that the course is the same on every machine.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DQuat, DVec3};

use crate::animation::generated::stage::{self, Frames, Mesh, RATE, Replay, Stage};
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
    stage.part_at_rest(Mesh::quadrangle(ground(8.0, -BOWL)), matte([0.6, 0.55, 0.5]));
    stage.part_at_rest(bowl(), matte([0.5, 0.38, 0.25]));
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
        let place = |ball: &Ball| DAffine3::from_rotation_translation(ball.turn, ball.at);
        stage.placed(balls.all.iter().map(place))
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

/// Radius of the bowl, the lower half of a sphere around the origin, metres.
const BOWL: f64 = 1.0;

/// Steps of the simulation per second.
const STEPS: u32 = 500;

const STEP: f64 = 1.0 / STEPS as f64;
const GRAVITY: f64 = 9.81;

/// How often contacts are dealt with in a step.
const ROUNDS: u32 = 3;

/// Share of the speed that a bounce keeps, and below which speed there is none, metres per second.
const BOUNCE: f64 = 0.45;
const QUIET: f64 = 0.15;

/// Share of the speed along a surface that is lost in a second of contact.
const FRICTION: f64 = 1.5;

/// The balls at a moment.
#[derive(Clone)]
struct Balls {
    radius: f64,
    all: Vec<Ball>,
}

#[derive(Clone)]
struct Ball {
    at: DVec3,
    turn: DQuat,
    velocity: DVec3,
    spin: DVec3,
}

impl Balls {
    /// In layers above the bowl, which they will fill to about a half.
    fn above_the_bowl(count: u32) -> Self {
        let radius = (0.14 / f64::from(count)).cbrt().min(0.25);
        let pitch = 2.2 * radius;
        let across = ((0.6 - radius).max(0.0) / pitch) as i64;
        let row = move || -across..=across;
        let places =
            (0..).flat_map(|layer| row().flat_map(move |x| row().map(move |y| (x, y, layer))));
        let places = places.filter(|(x, y, _)| x * x + y * y <= across * across);
        let ball = |(i, (x, y, layer)): (u64, (i64, i64, u32))| {
            let place = DVec3::new(x as f64, y as f64, f64::from(layer));
            let at = (place + 0.04 * stage::vector(i, 0)) * pitch;
            Ball { at, turn: DQuat::IDENTITY, velocity: DVec3::ZERO, spin: DVec3::ZERO }
        };
        Self { radius, all: (0..).zip(places).take(count as usize).map(ball).collect() }
    }

    fn step(&mut self) {
        for Ball { at, turn, velocity, spin } in &mut self.all {
            velocity.z -= GRAVITY * STEP;
            *at += *velocity * STEP;
            let spin = 0.5 * STEP * *spin;
            let change = DQuat::from_xyzw(spin.x, spin.y, spin.z, 0.0) * *turn;
            *turn = (*turn + change).normalize();
        }
        let pairs = self.near_pairs();
        for _ in 0..ROUNDS {
            for &[i, j] in &pairs {
                self.part(i as usize, j as usize);
            }
            for ball in &mut self.all {
                ball.touch_bowl(self.radius);
                ball.touch(self.radius, DVec3::Z, self.radius - (ball.at.z + BOWL));
            }
        }
    }

    /// Pairs that may touch in this step, in a fixed order: from a grid of cubes.
    fn near_pairs(&self) -> Vec<[u32; 2]> {
        let reach = 2.3 * self.radius;
        let cell = |p: DVec3| (p / reach).floor().to_array().map(|k| k as i64);
        let mut order: Vec<([i64; 3], u32)> =
            self.all.iter().zip(0..).map(|(ball, i)| (cell(ball.at), i)).collect();
        order.sort_unstable();
        let mut pairs = Vec::new();
        for &([x, y, z], i) in &order {
            for (dx, dy) in [-1, 0, 1].into_iter().flat_map(|x| [-1, 0, 1].map(|y| (x, y))) {
                // the three cubes along z are neighbours in the list
                let [low, high] = [z - 1, z + 1].map(|z| [x + dx, y + dy, z]);
                let from = order.partition_point(|entry| entry.0 < low);
                let column = order[from..].iter().take_while(|entry| entry.0 <= high);
                let at = self.all[i as usize].at;
                let near = |j: u32| at.distance_squared(self.all[j as usize].at) < reach * reach;
                pairs.extend(column.filter(|entry| i < entry.1 && near(entry.1)).map(|e| [i, e.1]));
            }
        }
        pairs
    }

    /// Two balls, where they touch.
    fn part(&mut self, i: usize, j: usize) {
        let Ok([a, b]) = self.all.get_disjoint_mut([i, j]) else { return };
        let between = b.at - a.at;
        let distance = between.length();
        let overlap = 2.0 * self.radius - distance;
        if overlap <= 0.0 || distance == 0.0 {
            return;
        }
        let normal = between / distance;
        a.at -= normal * (0.5 * overlap);
        b.at += normal * (0.5 * overlap);
        let closing = (a.velocity - b.velocity).dot(normal);
        if closing > 0.0 {
            let impulse = normal * (0.5 * closing * (1.0 + bounce(closing)));
            a.velocity -= impulse;
            b.velocity += impulse;
        }
    }
}

impl Ball {
    /// The ball and the bowl, on whichever side of it the ball is.
    fn touch_bowl(&mut self, radius: f64) {
        let distance = self.at.length();
        if self.at.z >= 0.0 || distance == 0.0 {
            return;
        }
        let out = self.at / distance;
        if distance < BOWL {
            self.touch(radius, -out, distance + radius - BOWL);
        } else {
            self.touch(radius, out, BOWL + radius - distance);
        }
    }

    /// The ball and a surface, into which it is by an overlap, where that is positive.
    fn touch(&mut self, radius: f64, normal: DVec3, overlap: f64) {
        if overlap <= 0.0 {
            return;
        }
        self.at += normal * overlap;
        let closing = -self.velocity.dot(normal);
        let along = (self.velocity + normal * closing) * (1.0 - FRICTION * STEP);
        self.velocity = if closing > 0.0 {
            along + normal * (closing * bounce(closing))
        } else {
            along - normal * closing
        };
        self.spin = normal.cross(along) / radius;
    }
}

/// The share of a speed that is left after a collision.
fn bounce(closing: f64) -> f64 {
    if closing > QUIET { BOUNCE } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_end_in_the_bowl_beside_one_another() {
        for count in [1, 40, 300] {
            let mut balls = Balls::above_the_bowl(count);
            assert_eq!(balls.all.len(), count as usize);
            for _ in 0..3 * STEPS {
                balls.step();
            }
            let within = balls.all.iter().filter(|ball| ball.at.length() < BOWL + 0.01).count();
            assert!(within * 10 >= count as usize * 9, "{within} of {count}");
            let deepest = (0..count as usize)
                .flat_map(|i| (0..i).map(move |j| (i, j)))
                .map(|(i, j)| balls.all[i].at.distance(balls.all[j].at))
                .fold(f64::INFINITY, f64::min);
            assert!(deepest > 1.7 * balls.radius, "{deepest} for {}", balls.radius);
            let speed =
                balls.all.iter().map(|ball| ball.velocity.length()).sum::<f64>() / f64::from(count);
            assert!(speed < 0.7, "{speed}");
        }
    }
}
