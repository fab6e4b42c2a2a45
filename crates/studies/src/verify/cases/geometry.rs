//! Awkward primitives.

use super::*;
use crate::verify::among_triangles::{exact, on_mesh};
use crate::verify::round::MetamorphicPair;

pub fn closed_mesh<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    around_mesh(random, rays, DVec3::ZERO)
}

pub fn closed_mesh_far<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    around_mesh(random, rays, dvec3(148_376.0, 1234.0, -223_423.0))
}

/// Rays from within and from without, at a corner or at a point of an edge that faces them.
fn around_mesh<S: Buildable>(random: &mut Random, rays: usize, center: DVec3) -> RoundResult<S> {
    let mesh = icosphere(3, center);
    let oracle = |exact: &Soup, ray: &Ray<S>| on_mesh(exact, ray, 0.25);
    exact_round(random, rays, &mesh, oracle, |random| {
        let target = on_edge(random, &mesh);
        let out = target - center;
        let from = match random.below(2) {
            0 => point(random) * 0.3,
            _ => out * (1.6 + 3.0 * unit(random)) + point(random) * 0.2,
        };
        let origin = single(center + from);
        (origin, target - origin)
    })
}

pub fn bumpy_sheet<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let side = one_of(random, &[2, 4, 8, 16, 32, 48]);
    let phase = unit(random) * 6.0;
    let mesh = sheet(side, |x, y| (x * 7.3 + phase).sin() * (y * 5.1).cos() * 0.2);
    let exact = Soup::new(&mesh);
    let mut round = Round::new(model_of(&mesh)?);
    let far = f64::from(side);
    for _ in 0..rays {
        let target = on_edge(random, &mesh);
        let is_inner = |x: f64| x > 0.0 && x < far;
        if !is_inner(target.x) || !is_inner(target.y) {
            continue;
        }
        let up = one_of(random, &[3.0, -3.0]) + unit(random);
        let origin = single(target + point(random).with_z(0.0) + dvec3(0.0, 0.0, up));
        let ray = ray(origin, target - origin);
        if let Some(expected) = on_mesh(&exact, &ray, 0.2) {
            round.push(ray, expected);
        }
    }
    Ok(round)
}

pub fn flat_sheet<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mesh = sheet(64, |_, _| 0.0);
    exact_round(random, rays, &mesh, on_lattice, |random| {
        let mut half = || random.below(129) as f64 / 2.0;
        let target = dvec3(half(), half(), 0.0);
        let mut sign = || one_of(random, &[-1.0, -0.0, 0.0, 1.0]);
        let (x, y) = (sign(), sign());
        let d = dvec3(x, y, one_of(random, &[1.0, -1.0, 2.0, -4.0]));
        (target - d * 4.0, d)
    })
}

pub fn needle<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = [[DVec3::ZERO, dvec3(1e4, 0.0, 0.0), dvec3(0.0, 1e-4, 0.0)].map(single)];
    exact_round(random, rays, &triangles, in_soup, |random| {
        let target = dvec3(unit(random) * 1e4, unit(random) * 1.2e-4, 0.0);
        let down = one_of(random, &[1.0, -1.0]);
        (single(target - dvec3(0.0, 0.0, down * 4.0)), dvec3(0.0, 0.0, down))
    })
}

pub fn degenerate<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let clean = soup(random, 80, 0.4);
    let mut triangles: Vec<Corners> = (0..40)
        .map(|_| {
            let (p, along) = (point(random), single(point(random) * 0.25));
            match random.below(3) {
                0 => [p, p, p],
                1 => [p, single(p + along), p],
                // whole multiples: collinear in any precision
                _ => [DVec3::ZERO, along, along * 2.0],
            }
        })
        .collect();
    let first = triangles.len() as u32;
    triangles.extend_from_slice(&clean);
    let mut round: Round<S> = aimed_round(random, rays, &triangles, 2.0)?;
    let ids = (first..triangles.len() as u32).collect();
    let (model, rays) = (model_of(&clean)?, round.rays.clone());
    let pair = MetamorphicPair::new("without them", model, rays);
    round.pairs.push(MetamorphicPair { ids, ..pair });
    Ok(round)
}

pub fn coplanar<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut triangles = soup(random, 60, 0.6);
    triangles.extend_from_within(..);
    random.shuffle(&mut triangles);
    let mut round: Round<S> = aimed_round(random, rays, &triangles, 2.0)?;
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    random.shuffle(&mut order);
    round.pairs.extend(round.renumbered(order));
    Ok(round)
}

pub fn duplicates<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let mut triangles = soup(random, 20, 0.5);
    let same: Corners = one_of(random, &triangles);
    triangles.extend(std::iter::repeat_n(same, 10_000));
    aimed_round(random, rays, &triangles, 2.0)
}

pub fn fine_detail_far_away<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let center = dvec3(1e6, -1e6, 1e6);
    let far = |t: &Corners| t.map(|p| single(center + p));
    let triangles: Vec<Corners> = soup(random, 200, 0.4).iter().map(far).collect();
    exact_round(random, rays, &triangles, in_soup, |random| {
        let target = point_within(random, &triangles);
        let d = point(random);
        (single(target - d * 2.0), d)
    })
}

/// A ray at an angle of 10^-1 to 10^-6 to the plane of a triangle of size 1 to 10^3. Its shadow on
/// the plane passes beside the triangle, or it crosses the plane beyond it and is still high above.
pub fn nearly_parallel<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let size = one_of(random, &[1.0, 32.0, 1024.0]);
    let normal = direction(random);
    let along = normal.any_orthonormal_vector();
    let side = normal.cross(along);
    let triangle = [-along - side, along - side, side].map(|p| single(p * size));
    let oracle = |soup: &Soup, ray: &Ray<S>| {
        let meetings = exact(ray)?.meetings(soup, 0.0, 0.0);
        meetings.is_empty().then_some(OracleAnswer::Miss)
    };
    exact_round(random, rays, &[triangle], oracle, |random| {
        let tilt = one_of(random, &[0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]);
        let turn = unit(random) * std::f64::consts::TAU;
        let heading = along * turn.cos() + side * turn.sin();
        let beside = normal.cross(heading);
        let away = one_of(random, &[1.0, -1.0]) * (1.5 + unit(random));
        // where it crosses the plane: beside the triangle, or so far on that it has risen by a
        // part of the size that rounding cannot bridge
        let crossing = match random.below(2) {
            0 => beside * away + heading * signed(random),
            _ => heading * (2.0 + 0.02 / tilt) * away.signum() + beside * signed(random) * 0.4,
        };
        let d = heading + normal * (tilt * one_of(random, &[1.0, -1.0]));
        let crossing = crossing * size;
        let back = size * (3.0 + crossing.length() / size);
        (single(crossing - d * back), single(d))
    })
}

pub fn tiny_or_huge<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    // about the powers of ten; no rounding
    let scale = one_of(random, &[-83, -27, 27, 67].map(|k| 2f64.powi(k)));
    let unscaled = soup(random, 100, 0.4);
    let triangles: Vec<Corners> = unscaled.iter().map(|t| t.map(|p| p * scale)).collect();
    let exact = Soup::new(&unscaled);
    let mut round = Round::new(model_of(&triangles)?);
    for _ in 0..rays {
        let target = point_within(random, &unscaled);
        let (origin, along) = toward(random, target, 2.0);
        // exact predicates underflow as well: the oracle sees everything at its usual size
        let usual: Ray<S> = ray(origin, along);
        let expected = match in_soup(&exact, &usual) {
            Some(OracleAnswer::Hit { id, t }) => OracleAnswer::Hit { id, t: t.map(|t| t * scale) },
            Some(other) => other,
            None => continue,
        };
        round.push(ray(origin * scale, usual.direction.to_dvec3()), expected);
    }
    Ok(round)
}
