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
        let places = balls.turns.iter().zip(&balls.positions);
        stage.placed(places.map(|(&turn, &at)| DAffine3::from_rotation_translation(turn, at)))
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
    positions: Vec<DVec3>,
    turns: Vec<DQuat>,
    velocities: Vec<DVec3>,
    spins: Vec<DVec3>,
}

impl Balls {
    /// In layers above the bowl, which they will fill to about a half.
    fn above_the_bowl(count: u32) -> Self {
        let radius = (0.14 / f64::from(count)).cbrt().min(0.25);
        let pitch = 2.2 * radius;
        let across = ((0.6 - radius).max(0.0) / pitch) as i64;
        let mut positions = Vec::with_capacity(count as usize);
        for layer in 0.. {
            for (x, y) in (-across..=across).flat_map(|x| (-across..=across).map(move |y| (x, y))) {
                if positions.len() == count as usize {
                    break;
                }
                if x * x + y * y <= across * across {
                    let i = positions.len() as u64;
                    let place = DVec3::new(x as f64, y as f64, f64::from(layer));
                    positions.push((place + 0.04 * stage::vector(i, 0)) * pitch);
                }
            }
            if positions.len() == count as usize {
                break;
            }
        }
        let still = vec![DVec3::ZERO; positions.len()];
        let turns = vec![DQuat::IDENTITY; positions.len()];
        Self { radius, positions, turns, velocities: still.clone(), spins: still }
    }

    fn step(&mut self) {
        for (i, velocity) in self.velocities.iter_mut().enumerate() {
            velocity.z -= GRAVITY * STEP;
            self.positions[i] += *velocity * STEP;
            let spin = 0.5 * STEP * self.spins[i];
            let turn = self.turns[i];
            let change = DQuat::from_xyzw(spin.x, spin.y, spin.z, 0.0) * turn;
            self.turns[i] = (turn + change).normalize();
        }
        let pairs = self.near_pairs();
        for _ in 0..ROUNDS {
            for &[i, j] in &pairs {
                self.part(i as usize, j as usize);
            }
            for i in 0..self.positions.len() {
                self.touch_bowl(i);
                self.touch(i, DVec3::Z, self.radius - (self.positions[i].z + BOWL));
            }
        }
    }

    /// Pairs that may touch in this step, in a fixed order: from a grid of cubes.
    fn near_pairs(&self) -> Vec<[u32; 2]> {
        let reach = 2.3 * self.radius;
        let cell = |p: DVec3| (p / reach).floor().to_array().map(|k| k as i64);
        let mut order: Vec<([i64; 3], u32)> =
            self.positions.iter().zip(0..).map(|(&p, i)| (cell(p), i)).collect();
        order.sort_unstable();
        let mut pairs = Vec::new();
        for &([x, y, z], i) in &order {
            for (dx, dy) in [-1, 0, 1].into_iter().flat_map(|x| [-1, 0, 1].map(|y| (x, y))) {
                // the three cubes along z are neighbours in the list
                let [low, high] = [z - 1, z + 1].map(|z| [x + dx, y + dy, z]);
                let from = order.partition_point(|entry| entry.0 < low);
                let column = order[from..].iter().take_while(|entry| entry.0 <= high);
                let at = self.positions[i as usize];
                let near = |j: u32| at.distance_squared(self.positions[j as usize]) < reach * reach;
                pairs.extend(column.filter(|entry| i < entry.1 && near(entry.1)).map(|e| [i, e.1]));
            }
        }
        pairs
    }

    /// Two balls, where they touch.
    fn part(&mut self, i: usize, j: usize) {
        let between = self.positions[j] - self.positions[i];
        let distance = between.length();
        let overlap = 2.0 * self.radius - distance;
        if overlap <= 0.0 || distance == 0.0 {
            return;
        }
        let normal = between / distance;
        self.positions[i] -= normal * (0.5 * overlap);
        self.positions[j] += normal * (0.5 * overlap);
        let closing = (self.velocities[i] - self.velocities[j]).dot(normal);
        if closing > 0.0 {
            let impulse = normal * (0.5 * closing * (1.0 + bounce(closing)));
            self.velocities[i] -= impulse;
            self.velocities[j] += impulse;
        }
    }

    /// A ball and the bowl, on whichever side of it the ball is.
    fn touch_bowl(&mut self, i: usize) {
        let p = self.positions[i];
        let distance = p.length();
        if p.z >= 0.0 || distance == 0.0 {
            return;
        }
        let out = p / distance;
        if distance < BOWL {
            self.touch(i, -out, distance + self.radius - BOWL);
        } else {
            self.touch(i, out, BOWL + self.radius - distance);
        }
    }

    /// A ball and a surface, into which it is by an overlap, where that is positive.
    fn touch(&mut self, i: usize, normal: DVec3, overlap: f64) {
        if overlap <= 0.0 {
            return;
        }
        self.positions[i] += normal * overlap;
        let velocity = self.velocities[i];
        let closing = -velocity.dot(normal);
        let along = (velocity + normal * closing) * (1.0 - FRICTION * STEP);
        self.velocities[i] = if closing > 0.0 {
            along + normal * (closing * bounce(closing))
        } else {
            along - normal * closing
        };
        self.spins[i] = normal.cross(along) / self.radius;
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
            assert_eq!(balls.positions.len(), count as usize);
            for _ in 0..3 * STEPS {
                balls.step();
            }
            let within = balls.positions.iter().filter(|p| p.length() < BOWL + 0.01).count();
            assert!(within * 10 >= count as usize * 9, "{within} of {count}");
            let deepest = (0..count as usize)
                .flat_map(|i| (0..i).map(move |j| (i, j)))
                .map(|(i, j)| balls.positions[i].distance(balls.positions[j]))
                .fold(f64::INFINITY, f64::min);
            assert!(deepest > 1.7 * balls.radius, "{deepest} for {}", balls.radius);
            let speed = balls.velocities.iter().map(|v| v.length()).sum::<f64>() / f64::from(count);
            assert!(speed < 0.7, "{speed}");
        }
    }
}
