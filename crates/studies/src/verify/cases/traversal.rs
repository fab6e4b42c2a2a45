//! Rays that are awkward to walk through cells.

use accel_core::primitives::{PrimSet, PrimitiveError, TriangleSet};
use accel_core::structures::Buildable;
use accel_core::{Ray, Scalar};
use glam::dvec3;

use super::{
    LATTICE, lattice_point, lattice_round, lattice_soup, point_within, soup_round, toward,
};
use crate::case;
use crate::verify::draw::{one_of, unit, whole};
use crate::verify::meshes::soup;
use crate::verify::model::Model;
use crate::verify::parts::walks;
use crate::verify::registry::{Case, Group};
use crate::verify::round::{Expected, Round};
use crate::verify::twin::Original;
use statistics::random::Random;

/// The group.
pub static GROUP: Group = Group { name: "traversal", cases: &[T1, T2, T3, T4, T5, T6, T7] };

const T1: Case = case!(
    "T1",
    "whole numbers",
    parts walks::LATTICE_RAYS,
    "grids of 16^3 to 1024^3, so many rays for each: every cell that is crossed is visited"
);
const T3: Case = case!(
    "T3",
    "whole numbers",
    parts walks::PUBLISHED_RAYS,
    "two rays that broke other walks, and rays like them"
);
const T4: Case = case!(
    "T4",
    "the ray in f64",
    parts walks::FAR_ORIGINS,
    "origins 10^6 grids away, aimed at the grid's outer planes"
);
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
        let (a, b) = (whole(random, 4), whole(random, 4));
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
    let original = Original { triangles: &triangles, rays: &round.rays };
    let twin = original.mirrored(random.below(8) as u8);
    round.twins.extend(twin);
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
    let Model::Triangles(set) = &round.model else { return Ok(round) };
    for (ray, expected) in round.rays.iter_mut().zip(&mut round.expected) {
        let all = all_hits(set, ray);
        let start = S::from_f64(unit(random) * 0.8);
        ray.t_min = match (random.below(4), all.get(random.below(all.len()))) {
            (0, Some(&(t, _))) => t,
            (1, Some(&(t, _))) => t.next_up(),
            (2, Some(&(t, _))) => t.next_down(),
            _ => start,
        };
        ray.t_max = ray.t_min + S::from_f64(0.1 + unit(random));
        let is_within = |t: S| ray.t_min <= t && t <= ray.t_max;
        // in the order of the parameter, then of ids: the first is the closest
        *expected = match all.into_iter().find(|(t, _)| is_within(*t)) {
            Some((t, id)) => Expected::Hit { id: Some(id), t: [t.to_f64(); 2] },
            None => Expected::Miss,
        };
    }
    Ok(round)
}

/// Every hit of the ray's line ahead of its origin, by parameter and id, found without a structure.
fn all_hits<S: Scalar>(set: &TriangleSet<S>, ray: &Ray<S>) -> Vec<(S, u32)> {
    let setup = set.setup(ray);
    let hit = |id| set.intersect(id, ray, &setup, S::INFINITY).map(|t| (t, id));
    let mut all: Vec<(S, u32)> = (0..set.len() as u32).filter_map(hit).collect();
    all.sort_by(|a, b| a.0.to_f64().total_cmp(&b.0.to_f64()).then(a.1.cmp(&b.1)));
    all
}
