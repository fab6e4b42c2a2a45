//! The cases: one file per group, and one for each case that takes more than a page.

mod copies;
mod crossings;
mod crowds;
mod extreme_components;
mod far_intervals;
mod frames;
mod from_hits;
pub mod geometry;
mod glass;
pub mod grid;
mod intervals;
mod lights;
mod moving;
mod nested_planes;
mod normals;
mod polygons;
pub mod ray;
pub mod reported;
mod scale_sweep;
pub mod secondary;
pub mod shapes;
pub mod shells;
mod slender_cones;
mod slivers;
pub mod symmetry;
mod threads;
mod tilted_planes;
pub mod traversal;

use accel_core::Ray;
use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use glam::{DVec3, dvec3};

use super::draw::{one_of, point, random_integer, unit};
use super::exact::Soup;
use super::expect::{in_soup, on_lattice};
use super::model::{Corners, Model};
use super::round::{OracleAnswer, Round, ray};
use statistics::random::Random;

/// Side of the cube that holds the lattice scenes.
const LATTICE: u32 = 16;

/// Triangles with corners on the lattice of whole numbers.
fn lattice_soup(random: &mut Random, count: usize) -> Vec<Corners> {
    let mut corner = || {
        let mut at = || random.below(LATTICE as usize + 1) as f64;
        dvec3(at(), at(), at())
    };
    (0..count).map(|_| [corner(), corner(), corner()]).collect()
}

/// A direction of components -1, -0, 0 and 1.
fn sign_direction(random: &mut Random) -> DVec3 {
    loop {
        let mut sign = || one_of(random, &[-1.0, -0.0, 0.0, 1.0]);
        let d = dvec3(sign(), sign(), sign());
        if d != DVec3::ZERO {
            return d;
        }
    }
}

/// A round over lattice triangles: rays of `draw`, whole-numbered as well, compared with the
/// exact oracle.
fn lattice_round<S: Buildable>(
    random: &mut Random,
    rays: usize,
    triangles: &[Corners],
    draw: impl FnMut(&mut Random) -> (DVec3, DVec3),
) -> Result<Round<S>, PrimitiveError> {
    exact_round(random, rays, triangles, on_lattice, draw)
}

/// A round over loose triangles: rays of `draw`, compared with the exact oracle.
fn soup_round<S: Buildable>(
    random: &mut Random,
    rays: usize,
    triangles: &[Corners],
    draw: impl FnMut(&mut Random) -> (DVec3, DVec3),
) -> Result<Round<S>, PrimitiveError> {
    exact_round(random, rays, triangles, in_soup, draw)
}

/// A round over triangles: rays of `draw`, but for those of which `oracle` says nothing.
fn exact_round<S: Buildable>(
    random: &mut Random,
    rays: usize,
    triangles: &[Corners],
    oracle: fn(&Soup, &Ray<S>) -> Option<OracleAnswer>,
    mut draw: impl FnMut(&mut Random) -> (DVec3, DVec3),
) -> Result<Round<S>, PrimitiveError> {
    let mut round = Round::new(Model::triangles(triangles)?);
    let exact = Soup::new(triangles);
    for _ in 0..rays {
        let (origin, direction) = draw(random);
        let ray = ray(origin, direction);
        if let Some(expected) = oracle(&exact, &ray) {
            round.push(ray, expected);
        }
    }
    Ok(round)
}

/// A point within one of the triangles.
pub(super) fn point_within(random: &mut Random, triangles: &[Corners]) -> DVec3 {
    let [a, b, c]: Corners = one_of(random, triangles);
    let (u, v) = (unit(random) * 0.5, unit(random) * 0.5);
    a + (b - a) * u + (c - a) * v
}

/// A corner, or a point of an edge that f64 holds exactly.
pub(super) fn on_edge(random: &mut Random, mesh: &[Corners]) -> DVec3 {
    let [a, b, _]: Corners = one_of(random, mesh);
    let part = if random.below(2) == 0 { 0.0 } else { random.below(1 << 10) as f64 / 1024.0 };
    a + (b - a) * part
}

/// From around `target`, `distance` away, to it.
pub(super) fn toward(random: &mut Random, target: DVec3, distance: f64) -> (DVec3, DVec3) {
    let origin = super::draw::single(target + point(random) * distance);
    (origin, target - origin)
}

/// A point of the lattice.
fn lattice_point(random: &mut Random) -> DVec3 {
    let mut at = || random_integer(random, LATTICE / 2) + f64::from(LATTICE / 2);
    dvec3(at(), at(), at())
}
