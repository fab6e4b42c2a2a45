//! Transformations that must not change a picture: of the unit of length, and of the names and
//! signs of the axes.
//!
//! Under IEEE 754 a power of two and a change of sign commute with every operation, barring
//! underflow, overflow and absolute lengths in the program: answers must keep their bits. Another
//! order of the axes changes the order of sums: ids must stay.

use super::*;
use crate::verify::meshes::torus;

/// Loose triangles, some far larger than others, and rays at them.
fn scene<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut triangles = soup(random, 120, 0.3);
    triangles.extend(soup(random, 6, 1.5));
    aimed_round(random, rays, &triangles, 2.0)
}

pub fn scaled<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut round = scene::<S>(random, rays)?;
    // a magnitude of up to 2 and rays of up to 4 stay within what is served
    let (down, up): (&[i32], &[i32]) = match S::NAME {
        "f32" => (&[-27, -20, -8], &[1, 13, 28]),
        // obvhs as shipped computes in f32 and refuses what only f64 holds
        _ => (&[-200, -27, -1], &[1, 28, 200]),
    };
    let exponents = [one_of(random, down), one_of(random, up)];
    round.pairs = exponents.into_iter().filter_map(|e| round.scaled(e)).collect();
    Ok(round)
}

pub fn turned<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut round = scene::<S>(random, rays)?;
    let mirrored = round.mirrored(1 + random.below(7) as u8);
    let permuted = round.permuted(1 + random.below(5), random.below(8) as u8);
    round.pairs = [mirrored, permuted].into_iter().flatten().collect();
    Ok(round)
}

/// Scales of a round.
const PARTS: usize = 16;

/// The whole served range of scales, power of two by power of two: a sparse set of scales passes
/// over a fault at one of them. Each round tries one exponent from each of [`PARTS`] equal parts: a
/// few rounds try all of f32, a few hundred all of f64.
pub fn scaled_densely<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles: Vec<Corners> = match random.below(4) {
        0 => soup(random, 80, 0.3),
        1 => icosphere(1, DVec3::ZERO),
        2 => torus(12, 6),
        _ => {
            let level = one_of(random, &[0.0, 0.5]);
            let small = |t: &Corners| t.map(|p| (p / 4.0 - 1.0).with_z(level));
            sheet(8, |_, _| 0.0).iter().map(small).collect()
        }
    };
    let mut round: Round<S> = aimed_round(random, rays, &triangles, 2.0)?;
    // what lies within the served exponents is refused on neither side
    let own = largest(&triangles).log2().floor() as i32;
    let [low, high] = S::SCENE_EXPONENTS.map(|e| e - own);
    let parts = PARTS.min((high - low) as usize);
    let edge = |i: usize| low + ((high - low) as usize * i / parts) as i32;
    let one_of_part = |i| {
        let [from, to] = [edge(i), edge(i + 1)];
        from + random.below((to - from) as usize) as i32
    };
    round.pairs = (0..parts).map(one_of_part).filter_map(|e| round.scaled(e)).collect();
    Ok(round)
}
