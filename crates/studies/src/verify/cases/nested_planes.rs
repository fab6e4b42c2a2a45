//! Rays along planes on which the cells of nested grids end, a little askew.
//!
//! Blocks and checkerboards of unit cubes: a grid over them, and the grids within its cells, have
//! planes where the cubes have faces. A ray runs along one axis; its other two coordinates are
//! whole numbers, and its direction leaves those planes by 10^-45 to 10^-3, or not at all. Rounding
//! may then put it on either side of a plane, and a parent and its child may disagree.

use std::collections::BTreeMap;

use super::*;
use crate::verify::meshes::{Cubes, cube};

/// Cubes along a side of the largest checkerboard, and of the largest block: of that only the
/// outside is ever hit.
const MOST_CUBES: [f64; 2] = [24.0, 12.0];

/// Rounding error of the position of a ray, in epsilons of the distance to the farthest corner.
const ROUNDING: f64 = 64.0;

pub fn nested_planes<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let is_solid = random.below(4) == 0;
    let most = if is_solid { MOST_CUBES[1] } else { MOST_CUBES[0] };
    // small ones more often: large ones take long to build
    let part = unit(random).powf(1.5);
    let cubes = Cubes { side: 2 + ((most - 1.0) * part) as i32, is_solid };
    let triangles: Vec<_> = cubes.all().flat_map(cube).collect();
    let mut round = Round::new(model_of(&triangles)?);
    let numbers: BTreeMap<[i32; 3], u32> = cubes.all().zip(0..).collect();
    for _ in 0..rays {
        let aim = AxisRay::draw(random, cubes.side);
        let reach = f64::from(cubes.side) + aim.outside;
        let tolerance = ROUNDING * S::EPSILON.to_f64() * reach;
        round.push(ray(aim.origin(cubes.side), aim.direction()), aim.expected(&cubes, tolerance));
        let columns = aim.columns().into_iter();
        let places = columns.flat_map(|column| (0..cubes.side).map(move |k| aim.cube(k, column)));
        let mut met: Vec<u32> = places.filter_map(|at| numbers.get(&at)).copied().collect();
        met.sort_unstable();
        let ids = met.into_iter().flat_map(|number| 12 * number..12 * (number + 1));
        round.near.push(ids.collect());
    }
    Ok(round)
}

#[derive(Clone, Copy)]
struct AxisRay {
    axis: usize,
    /// 1: towards rising coordinates; -1.
    sign: f64,
    /// How far from the cubes it starts.
    outside: f64,
    /// Its coordinates on the next axis, and on the one after.
    at: [i32; 2],
    /// Its direction on the other two axes.
    off: [f64; 2],
}

impl AxisRay {
    fn draw(random: &mut Random, side: i32) -> Self {
        let mut at = || random.below(side as usize + 1) as i32;
        let at = [at(), at()];
        // f32 holds it, and the origin stays near (8 times the largest coordinate)
        let outside = (3.0 + 10.0 * unit(random)) as f32;
        Self {
            axis: random.below(3),
            sign: one_of(random, &[1.0, -1.0]),
            outside: f64::from(outside),
            at,
            off: off_planes(random),
        }
    }

    fn placed(&self, along: f64, [next, last]: [f64; 2]) -> DVec3 {
        DVec3::from(turned([along, next, last], 3 - self.axis))
    }

    fn origin(&self, side: i32) -> DVec3 {
        let start = if self.sign > 0.0 { 0.0 } else { f64::from(side) };
        self.placed(start - self.sign * self.outside, self.at.map(f64::from))
    }

    fn direction(&self) -> DVec3 {
        self.placed(self.sign, self.off)
    }

    /// The four columns of cubes around its line: all that it can meet, since it leaves the line by
    /// less than a cube.
    fn columns(&self) -> [[i32; 2]; 4] {
        let [next, last] = self.at;
        [[next - 1, last - 1], [next - 1, last], [next, last - 1], [next, last]]
    }

    /// Where the cube of a column is that is so far along the axis.
    fn cube(&self, along: i32, [next, last]: [i32; 2]) -> [i32; 3] {
        turned([along, next, last], 3 - self.axis)
    }

    /// The first cube of the columns in which the ray lies, on their faces included; but it may
    /// meet one earlier in a column that it passes within the rounding.
    fn expected(&self, cubes: &Cubes, tolerance: f64) -> OracleAnswer {
        let side = cubes.side;
        let (mut lies, mut touches) = (f64::INFINITY, f64::INFINITY);
        for column in self.columns() {
            let along = |depth| if self.sign > 0.0 { depth } else { side - 1 - depth };
            let is_there = |depth: &i32| cubes.has(self.cube(along(*depth), column));
            let Some(depth) = (0..side).find(is_there) else { continue };
            let t = self.outside + f64::from(depth);
            let beside = |k: usize| {
                let is_below = column[k] < self.at[k];
                let is_there = if is_below { self.off[k] <= 0.0 } else { self.off[k] >= 0.0 };
                if is_there { 0.0 } else { self.off[k].abs() * t }
            };
            let away = beside(0).max(beside(1));
            if away == 0.0 {
                lies = lies.min(t);
            }
            // it is in that column's neighbour, and closest to it at the end it starts from
            if away < tolerance {
                touches = touches.min(t);
            }
        }
        let slack = 4.0 * tolerance / ROUNDING;
        if lies.is_finite() {
            OracleAnswer::Hit { id: None, t: [touches - slack, lies + slack] }
        } else if touches.is_finite() {
            OracleAnswer::Anything
        } else {
            OracleAnswer::Miss
        }
    }
}

/// Other two components of a direction: of one size or of two, of either sign.
fn off_planes(random: &mut Random) -> [f64; 2] {
    let next = off_plane(random);
    let last = if random.below(2) == 0 { next } else { off_plane(random) };
    [next, last].map(|size| f64::copysign(size, signed(random)))
}

/// How far a direction leaves a plane; f32 holds it.
fn off_plane(random: &mut Random) -> f64 {
    // the least of f32, where less would become nothing
    let least = f64::from(f32::from_bits(1));
    let size: f64 = match random.below(8) {
        0 => 0.0,
        // the cosine of a quarter turn, in f64 and in f32
        1 => one_of(random, &[6.123e-17, 4.371e-8]),
        _ => 10.0_f64.powf(-45.0 + 42.0 * unit(random)).max(least),
    };
    f64::from(size as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::answers::Answers;
    use crate::verify::subject::with_brute_force;
    use accel_core::Hit;

    #[test]
    fn the_four_columns_are_all_that_a_ray_can_meet() {
        for seed in 0..6 {
            let round = nested_planes::<f32>(&mut Random::new(seed, "columns"), 60).unwrap();
            let Round { model, rays, near, .. } = round;
            let mut hits = vec![Hit::NONE; rays.len()];
            with_brute_force(model.prims(), |t| t.closest_hits(&rays, &mut hits)).unwrap();
            let near = Answers::near(&model, &rays, &near);
            assert_eq!(near.closest, hits, "{seed}");
            assert!(hits.iter().filter(|h| h.is_hit()).count() > 20);
        }
    }
}
