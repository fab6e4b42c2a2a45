//! Random points, directions, triangles and targets, drawn in single precision so that both
//! precisions hold them.

use glam::{DVec3, dvec3};

use super::round::Corners;
use statistics::random::Random;

/// Uniform in [0, 1), with 24 bits.
pub fn unit(random: &mut Random) -> f64 {
    (random.next_u64() >> 40) as f64 / f64::from(1_u32 << 24)
}

/// Uniform in [-1, 1).
pub fn signed(random: &mut Random) -> f64 {
    unit(random) * 2.0 - 1.0
}

/// A point of the cube [-1, 1)^3.
pub fn point(random: &mut Random) -> DVec3 {
    single(dvec3(signed(random), signed(random), signed(random)))
}

/// A direction, uniform over the sphere.
pub fn direction(random: &mut Random) -> DVec3 {
    loop {
        let p = point(random);
        if (0.01..1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}

/// One of `choices`, or the default where there are none.
pub fn one_of<T: Copy + Default>(random: &mut Random, choices: &[T]) -> T {
    choices.get(random.below(choices.len())).copied().unwrap_or_default()
}

/// A whole number in `-limit..=limit`.
pub fn random_integer(random: &mut Random, limit: u32) -> f64 {
    random.below(2 * limit as usize + 1) as f64 - f64::from(limit)
}

/// Rounded to single precision.
pub fn single(p: DVec3) -> DVec3 {
    p.as_vec3().as_dvec3()
}

/// Triangles of about `size` anywhere in the cube [-1, 1]^3.
pub fn soup(random: &mut Random, count: usize, size: f64) -> Vec<Corners> {
    (0..count)
        .map(|_| {
            let p = point(random);
            [p, single(p + point(random) * size), single(p + point(random) * size)]
        })
        .collect()
}

/// A point within one of the triangles.
pub fn point_within(random: &mut Random, triangles: &[Corners]) -> DVec3 {
    let [a, b, c]: Corners = one_of(random, triangles);
    let (u, v) = (unit(random) * 0.5, unit(random) * 0.5);
    a + (b - a) * u + (c - a) * v
}

/// A corner, or a point of an edge that f64 holds exactly.
pub fn on_edge(random: &mut Random, mesh: &[Corners]) -> DVec3 {
    let [a, b, _]: Corners = one_of(random, mesh);
    let part = if random.below(2) == 0 { 0.0 } else { random.below(1 << 10) as f64 / 1024.0 };
    a + (b - a) * part
}

/// Either, as often.
pub fn within_or_on_edge(random: &mut Random, triangles: &[Corners]) -> DVec3 {
    match random.below(2) {
        0 => point_within(random, triangles),
        _ => on_edge(random, triangles),
    }
}

/// From around `target`, `distance` away, to it.
pub fn toward(random: &mut Random, target: DVec3, distance: f64) -> (DVec3, DVec3) {
    let origin = single(target + point(random) * distance);
    (origin, target - origin)
}

/// Side of the cube that holds the lattice scenes.
pub const LATTICE: u32 = 16;

/// Triangles with corners on the lattice of whole numbers.
pub fn lattice_soup(random: &mut Random, count: usize) -> Vec<Corners> {
    (0..count).map(|_| [(); 3].map(|()| lattice_point(random))).collect()
}

pub fn lattice_point(random: &mut Random) -> DVec3 {
    let mut at = || random.below(LATTICE as usize + 1) as f64;
    dvec3(at(), at(), at())
}

/// A direction of components -1, -0, 0 and 1.
pub fn sign_direction(random: &mut Random) -> DVec3 {
    loop {
        let mut sign = || one_of(random, &[-1.0, -0.0, 0.0, 1.0]);
        let d = dvec3(sign(), sign(), sign());
        if d != DVec3::ZERO {
            return d;
        }
    }
}
