//! Rays that run within a plane of triangles, the plane at any slant.
//!
//! What such a ray meets is left to rounding: triangles that are lines to it, one behind the other,
//! often several at the same parameter. Whatever the tests say, all structures must say it: of
//! equal parameters the lowest id; and no hit may lie before or behind its triangle.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use accel_core::{Ray, Vector};
use glam::{DVec3, dvec3};

use crate::case;
use crate::verify::draw::{direction, one_of, random_integer, unit};
use crate::verify::every_hit::{every_hit, first_within};
use crate::verify::meshes::{sheet, soup};
use crate::verify::model::{Corners, Model};
use crate::verify::own_bounds::is_beside_it;
use crate::verify::registry::Case;
use crate::verify::round::{Round, ray};
use statistics::random::Random;

/// Ties decided by the lowest id.
pub const G14: Case = case!(
    "G14",
    "all tests, own bounds",
    tilted_planes,
    "rays within a plane of triangles at any slant: the lowest id of equal parameters",
    2,
    &[]
);

fn tilted_planes<S: Buildable>(
    random: &mut Random,
    rays: usize,
) -> Result<Round<S>, PrimitiveError> {
    let side = one_of(random, &[2, 4, 8, 12, 16, 24]);
    let normal = direction(random);
    let turn = unit(random) * std::f64::consts::TAU;
    let any = normal.any_orthonormal_vector();
    let x = any * turn.cos() + normal.cross(any) * turn.sin();
    let y = normal.cross(x);
    let at = direction(random) * one_of(random, &[0.0, 1.0, f64::from(side), 30.0]);
    let size = one_of(random, &[1.0, 0.1, 7.3]);
    let place = |p: DVec3| at + (x * p.x + y * p.y) * size;
    let triangles: Vec<Corners> = flat(random, side).iter().map(|t| t.map(place)).collect();
    let mut round = Round::new(Model::triangles(&triangles)?);
    let far = f64::from(side);
    let corners = triangles.as_flattened().iter();
    let largest = corners.fold(0.0, |m, p: &DVec3| p.abs().max_element().max(m));
    for _ in 0..rays {
        let mut corner = || {
            let mut at = || random.below(side as usize + 1) as f64;
            dvec3(at(), at(), 0.0)
        };
        let (target, other) = (corner(), corner());
        // through many corners, along edges, or from anywhere in the plane to a corner
        let along = match random.below(3) {
            0 => dvec3(random_integer(random, 3), random_integer(random, 3), 0.0),
            1 => other - target,
            _ => dvec3(unit(random) - 0.5, unit(random) - 0.5, 0.0) * far,
        };
        let from = target - along * one_of(random, &[0.0, 1.0, 2.0, far, far + 1.5]);
        let ray: Ray<S> = ray(place(from), (x * along.x + y * along.y) * size);
        // origins beyond 8 times the largest coordinate are brought near before they are asked
        if !ray.is_traceable() || ray.origin.to_dvec3().abs().max_element() > largest * 7.0 {
            continue;
        }
        let mut hits = every_hit(&round.model, &ray);
        if let Model::Triangles(set) = &round.model {
            hits.retain(|hit| {
                set.triangles().get(hit.id as usize).is_some_and(|t| !is_beside_it(t, &ray, hit.t))
            });
        }
        let expected = first_within(&hits, ray.t_min, ray.t_max);
        round.push(ray, expected);
    }
    Ok(round)
}

/// Triangles in the plane z = 0 within a square of that side: side by side, the same in pairs, or
/// over one another.
fn flat(random: &mut Random, side: u32) -> Vec<Corners> {
    let mut triangles = sheet(side, |_, _| 0.0);
    match random.below(3) {
        0 => {}
        1 => {
            triangles.extend_from_within(..);
            random.shuffle(&mut triangles);
        }
        _ => {
            let across = f64::from(side);
            let placed = |p: DVec3| ((p + 1.0) * across / 2.0).with_z(0.0);
            // a large one that a ray cuts at a corner is met anywhere in its slab
            let size = one_of(random, &[0.3, 1.0, 2.0]);
            triangles = soup(random, 200, size).iter().map(|t| t.map(placed)).collect();
        }
    }
    triangles
}
