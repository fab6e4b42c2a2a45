//! The cases, by what they are about; [`super::catalogue`] lists them. Here is what they are written
//! with: drawing, meshes, oracles, and rounds of rays that an exact oracle judges.

pub(super) mod cells;
pub(super) mod crossings;
pub(super) mod crowds;
pub(super) mod edge_on;
pub(super) mod geometry;
pub(super) mod intervals;
pub(super) mod motion;
pub(super) mod nested_planes;
pub(super) mod normals;
pub(super) mod polygons;
pub(super) mod ray;
pub mod secondary;
pub(super) mod shadow_rays;
pub(super) mod shapes;
pub(super) mod symmetry;

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar, Vector};
use glam::{DVec2, DVec3, dvec2, dvec3};
use renderer::Geometry;
use statistics::random::Random;

use crate::verify::among_triangles::{in_soup, on_lattice};
use crate::verify::draw::{
    LATTICE, direction, lattice_point, lattice_soup, on_edge, one_of, point, point_within,
    random_integer, sign_direction, signed, single, soup, toward, unit, within_or_on_edge,
};
use crate::verify::every_hit::{every_hit, first_within, push_chain, push_hits};
use crate::verify::meshes::{icosphere, sheet};
use crate::verify::round::{Corners, OracleAnswer, Round, magnitude, mixed_model, model_of, ray};
use exact_geometry::triangles::Soup;

/// A round of a case, or why its scene cannot be made.
type RoundResult<S> = Result<Round<S>, PrimitiveError>;

/// A round over loose triangles: rays at points within them, from about `distance` away.
fn aimed_round<S: Buildable>(
    random: &mut Random,
    rays: usize,
    triangles: &[Corners],
    distance: f64,
) -> RoundResult<S> {
    exact_round(random, rays, triangles, in_soup, |random| {
        let target = point_within(random, triangles);
        toward(random, target, distance)
    })
}

/// A round over triangles: rays of `draw`, but for those of which `oracle` says nothing.
fn exact_round<S: Buildable>(
    random: &mut Random,
    rays: usize,
    triangles: &[Corners],
    oracle: impl Fn(&Soup, &Ray<S>) -> Option<OracleAnswer>,
    mut draw: impl FnMut(&mut Random) -> (DVec3, DVec3),
) -> RoundResult<S> {
    let mut round = Round::new(model_of(triangles)?);
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

/// The point with another coordinate on that axis.
fn with(mut p: DVec3, axis: usize, x: f64) -> DVec3 {
    p[axis] = x;
    p
}

/// The axes moved on by so many places of three.
fn turned<T: Copy>(v: [T; 3], by: usize) -> [T; 3] {
    [0, 1, 2].map(|k| v[(k + by) % 3])
}

/// The largest coordinate of any corner.
fn largest(triangles: &[Corners]) -> f64 {
    triangles.as_flattened().iter().fold(0.0, |m, p| p.abs().max_element().max(m))
}

/// Expected answer among loose triangles; anything where the exact oracle says nothing.
fn expected_in<S: Scalar>(exact: &Soup, ray: &Ray<S>) -> OracleAnswer {
    in_soup(exact, ray).unwrap_or(OracleAnswer::Anything)
}
