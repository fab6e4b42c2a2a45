//! Slivers, and rays half a degree off their plane.
//!
//! Reported of another library: a triangle with edges of 11.2, 9.7 and 1.4, all corners within 600,
//! was met at 12,291. The exact oracle says where rays that it can judge meet the sliver; where it
//! cannot, no hit may lie beyond the triangle's own bounds, by more than rounding explains at that
//! angle.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use accel_core::{Ray, Scalar};
use glam::DVec3;

use super::point_within;
use crate::case;
use crate::verify::draw::{direction, one_of, signed, single, unit};
use crate::verify::every_hit::{every_hit, first_within};
use crate::verify::exact::Soup;
use crate::verify::expect::in_soup;
use crate::verify::model::{Corners, Model};
use crate::verify::own_bounds::is_out_of_its_box;
use crate::verify::registry::Case;
use crate::verify::round::{OracleAnswer, Round, ray};
use statistics::random::Random;

pub const G16: Case = case!(
    "G16",
    "exact, own bounds",
    slivers,
    "slivers, and rays half a degree off their plane: no hit beyond their bounds"
);

fn slivers<S: Buildable>(random: &mut Random, rays: usize) -> Result<Round<S>, PrimitiveError> {
    let spread = one_of(random, &[0.0, 30.0, 600.0]);
    let many = 1 + random.below(40);
    let triangles: Vec<Corners> = (0..many).map(|_| sliver(random, spread)).collect();
    let exact = Soup::new(&triangles);
    let corners = triangles.as_flattened().iter();
    let largest = corners.fold(0.0, |m, p: &DVec3| p.abs().max_element().max(m));
    let mut round = Round::new(Model::<S>::triangles(&triangles)?);
    for _ in 0..rays {
        let triangle: Corners = one_of(random, &triangles);
        let [a, b, c] = triangle;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let within = point_within(random, &[triangle]);
        let target = match random.below(4) {
            0 => within,
            1 => within + normal * signed(random) * 0.1,
            2 => a + (b - a) * (2.0 * unit(random) - 0.5),
            _ => within + direction(random) * 2.0,
        };
        let any = direction(random);
        let in_plane = (any - normal * any.dot(normal)).normalize_or_zero();
        let degrees = one_of(random, &[0.5, -0.5, 0.05, 3.0]);
        let along = in_plane + normal * f64::to_radians(degrees).tan();
        // farther origins are brought near before they are asked
        let away = f64::min(one_of(random, &[3.0, 30.0, 300.0]), 5.0 * largest);
        let origin = single(target - along * away);
        let ray: Ray<S> = ray(origin, single(along));
        if ray.is_traceable() {
            let expected = expected(&round.model, &exact, &ray);
            round.push(ray, expected);
        }
    }
    Ok(round)
}

/// Edges of about 11.2, 9.7 and 1.4, hardly a triangle; anywhere in a cube of so many units.
fn sliver(random: &mut Random, spread: f64) -> Corners {
    let at = DVec3::from_array([0; 3].map(|_| signed(random) * spread * 0.98));
    let along = direction(random);
    let across = along.any_orthonormal_vector();
    let height = one_of(random, &[0.3, 0.1, 0.02]);
    [at, at + along * 11.2, at + along * 9.8 + across * height].map(single)
}

/// Answer of the exact oracle; otherwise the first hit that lies on its triangle.
fn expected<S: Scalar>(model: &Model<S>, exact: &Soup, ray: &Ray<S>) -> OracleAnswer {
    let hits = every_hit(model, ray);
    let Model::Triangles(set) = model else { return OracleAnswer::Anything };
    let is_lawful = |id: u32, t| {
        set.triangles().get(id as usize).is_some_and(|own| !is_out_of_its_box(own, ray, t))
    };
    match in_soup(exact, ray) {
        Some(OracleAnswer::Anything) | None => {
            let lawful: Vec<_> = hits.into_iter().filter(|h| is_lawful(h.id, h.t)).collect();
            first_within(&lawful, ray.t_min, ray.t_max)
        }
        Some(said) => said,
    }
}
