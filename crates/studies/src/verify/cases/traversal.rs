//! Rays that are awkward to take through cells.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use glam::dvec3;

use super::{
    LATTICE, lattice_point, lattice_round, lattice_soup, point_within, soup_round, toward,
};
use crate::case;
use crate::verify::draw::{one_of, random_integer, unit};
use crate::verify::every_hit::{every_hit, first_within};
use crate::verify::meshes::soup;
use crate::verify::metamorphic::OriginalScene;
use crate::verify::registry::{Case, Group};
use crate::verify::round::Round;
use statistics::random::Random;

pub static GROUP: Group = Group { name: "traversal", cases: &[T2, T5, T6, T7] };

const T2: Case = case!(
    "T2",
    "exact",
    lattice_ties,
    "lattice origins, directions of whole numbers: ties of planes"
);
const T5: Case =
    case!("T5", "exact, mirrored", within_planes, "rays within cell planes, all axes and signs");
const T6: Case =
    case!("T6", "exact", spanning, "triangles across many cells, hit beyond the current one");
const T7: Case = case!(
    "T7",
    "all tests",
    any_and_closest,
    "the closest hit is the least of all, any hit is one of them; intervals that begin at hits"
);

fn lattice_ties<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    let triangles = lattice_soup(random, 80);
    lattice_round(random, rays, &triangles, |random| {
        // the largest component a power of two: all arithmetic stays exact
        let (a, b) = (random_integer(random, 4), random_integer(random, 4));
        let c = one_of(random, &[4.0, -4.0]);
        let d = one_of(random, &[dvec3(a, b, c), dvec3(b, c, a), dvec3(c, a, b)]);
        (lattice_point(random) - d * random.below(6) as f64, d)
    })
}

fn within_planes<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    let triangles = lattice_soup(random, 80);
    let mut round: Round<S> = lattice_round(random, rays, &triangles, |random| {
        let zero = one_of(random, &[0.0, -0.0]);
        let sign = one_of(random, &[1.0, -1.0]);
        let d = one_of(
            random,
            &[dvec3(sign, zero, zero), dvec3(zero, sign, zero), dvec3(zero, zero, sign)],
        );
        (lattice_point(random) - d * random.below(2 * LATTICE as usize) as f64, d)
    })?;
    let original = OriginalScene { triangles: &triangles, rays: &round.rays };
    let pair = original.mirrored(random.below(8) as u8);
    round.pairs.extend(pair);
    Ok(round)
}

fn spanning<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let mut triangles = soup(random, 30, 2.0);
    triangles.extend(soup(random, 150, 0.1));
    soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 2.0)
    })
}

fn any_and_closest<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    let triangles = soup(random, 150, 0.3);
    let mut round: Round<S> = soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 2.0)
    })?;
    for (ray, expected) in round.rays.iter_mut().zip(&mut round.expected) {
        let all = every_hit(&round.model, ray);
        let start = S::from_f64(unit(random) * 0.8);
        ray.t_min = match (random.below(4), all.get(random.below(all.len()))) {
            (0, Some(hit)) => hit.t,
            (1, Some(hit)) => hit.t.next_up(),
            (2, Some(hit)) => hit.t.next_down(),
            _ => start,
        };
        ray.t_max = ray.t_min + S::from_f64(0.1 + unit(random));
        *expected = first_within(&all, ray.t_min, ray.t_max);
    }
    Ok(round)
}
