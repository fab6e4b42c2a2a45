//! Primitives that let shadow rays pass, before and behind others that do not.

use accel_core::Ray;
use accel_core::primitives::{PrimSet, PrimitiveError, TriangleSet};
use accel_core::registry::Buildable;

use super::{point_within, toward};
use crate::case;
use crate::verify::draw::{one_of, point, unit};
use crate::verify::every_hit::{every_hit, first_within};
use crate::verify::meshes::soup;
use crate::verify::model::Model;
use crate::verify::registry::Case;
use crate::verify::round::{Round, ray};
use statistics::random::Random;

pub const Q9: Case = case!(
    "Q9",
    "all tests",
    glass,
    "shadow rays through transmissive primitives, equal to opaque ones, before and behind them"
);

fn glass<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let size = one_of(random, &[0.3, 0.8]);
    let mut triangles = soup(random, 60, size);
    // glass and what is not in one place
    triangles.extend_from_within(..20);
    random.shuffle(&mut triangles);
    let of = 2 + random.below(3);
    let is_glass = |id: u32| !(id as usize).is_multiple_of(of);
    let model = match random.below(2) {
        0 => {
            let rounded = triangles.iter().map(|t| t.map(|p| p.to_array().map(S::from_f64)));
            Model::Triangles(TriangleSet::new(rounded.collect(), is_glass)?)
        }
        _ => Model::mixed(|set| {
            for (triangle, id) in triangles.iter().zip(0..) {
                match random.below(3) {
                    0 => set.sphere(point(random), 0.05 + 0.2 * unit(random))?,
                    _ => set.triangle(*triangle)?,
                }
                if is_glass(id) {
                    set.last_is_transmissive();
                }
            }
            Ok(())
        })?,
    };
    let mut round = Round::new(model);
    while round.rays.len() < rays {
        let target = point_within(random, &triangles);
        let (origin, along) = toward(random, target, 2.0);
        let t_max = S::from_f64(one_of(random, &[1.0, 0.5, 2.0, f64::INFINITY]));
        let ray: Ray<S> = Ray { t_max, ..ray(origin, along) };
        if !ray.is_traceable() {
            continue;
        }
        let hits = every_hit(&round.model, &ray);
        let is_opaque = |id: u32| match &round.model {
            Model::Triangles(set) => set.is_opaque(id),
            Model::Mixed(set) => set.is_opaque(id),
        };
        let is_blocked = hits.iter().any(|hit| is_opaque(hit.id));
        round.push(ray, first_within(&hits, ray.t_min, ray.t_max));
        round.blocked.push(is_blocked);
    }
    Ok(round)
}
