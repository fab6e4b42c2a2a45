//! Rays in the plane of triangles, or nearly: what they meet is left to rounding.

use super::*;
use crate::verify::every_hit::{is_beside_it, is_out_of_its_box};

/// Rays within a plane of triangles at any slant: the triangles are lines to them, one behind the
/// other, often several at the same parameter. Whatever the tests say, all structures must say it:
/// of equal parameters the lowest id; and no hit may lie before or behind its triangle.
pub fn tilted_planes<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
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
    let mut round = Round::new(model_of(&triangles)?);
    let (far, largest) = (f64::from(side), largest(&triangles));
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
        let hits = lawful_hits(&round.model, &ray, is_beside_it);
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

/// Slivers, and rays half a degree off their plane. Reported of another library: a triangle with
/// edges of 11.2, 9.7 and 1.4, all corners within 600, was met at 12,291. The exact oracle says where
/// rays that it can judge meet the sliver; where it cannot, no hit may lie beyond the triangle's own
/// bounds, by more than rounding explains at that angle.
pub fn slivers<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let spread = one_of(random, &[0.0, 30.0, 600.0]);
    let many = 1 + random.below(40);
    let triangles: Vec<Corners> = (0..many).map(|_| sliver(random, spread)).collect();
    let exact = Soup::new(&triangles);
    let largest = largest(&triangles);
    let mut round = Round::new(model_of::<S>(&triangles)?);
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
        round.push_traceable(ray, |round| expected(&round.model, &exact, &ray));
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
fn expected<S: Buildable>(model: &Geometry<S>, exact: &Soup, ray: &Ray<S>) -> OracleAnswer {
    match expected_in(exact, ray) {
        OracleAnswer::Anything => {
            let hits = lawful_hits(model, ray, is_out_of_its_box);
            first_within(&hits, ray.t_min, ray.t_max)
        }
        said => said,
    }
}

/// The hits of a ray but for those that break a law of their triangles.
fn lawful_hits<S: Buildable>(
    model: &Geometry<S>,
    ray: &Ray<S>,
    is_broken: fn(&[[S; 3]; 3], &Ray<S>, S) -> bool,
) -> Vec<Hit<S>> {
    let mut hits = every_hit(model, ray);
    if let Geometry::Triangles(set) = model {
        hits.retain(|hit| !is_broken(&set.triangles()[hit.id as usize], ray, hit.t));
    }
    hits
}
