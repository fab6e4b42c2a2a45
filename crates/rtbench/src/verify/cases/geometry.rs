//! Awkward primitives.

use accel_core::primitives::PrimitiveError;
use accel_core::structures::Buildable;
use glam::{DVec3, dvec3};

use super::{point_within, soup_round, toward};
use crate::case;
use crate::random::Random;
use crate::verify::draw::{direction, one_of, point, single, unit};
use crate::verify::expect::{on_lattice, on_mesh};
use crate::verify::meshes::{icosphere, sheet, soup};
use crate::verify::model::{Corners, Model};
use crate::verify::registry::{Case, Group};
use crate::verify::round::{Expected, RAYS_A_ROUND, Round, ray};
use crate::verify::twin::{Original, Twin};

/// The group.
pub static GROUP: Group =
    Group { name: "geometry", cases: &[G1, G1_FAR, G2, G3, G4, G5, G7, G8, G9, G10, G13] };

const G1: Case = case!("G1", "exact", closed_mesh, "rays at vertices and edges of a closed mesh");
const G1_FAR: Case =
    case!("G1far", "exact", closed_mesh_far, "the same far from the origin of coordinates");
const G2: Case =
    case!("G2", "exact", bumpy_sheet, "rays at vertices and edges within a bumpy sheet");
const G3: Case = case!(
    "G3",
    "exact",
    flat_sheet,
    "axis-parallel and diagonal rays through a lattice's vertices"
);
const G4: Case = case!("G4", "exact", needle, "a triangle 10^8 times as long as wide");
const G5: Case = case!("G5", "exact, without them", degenerate, "points and lines among triangles");
const G7: Case =
    case!("G7", "exact, renumbered", twins, "triangles in the same place: the lowest id wins");
const G8: Case = case!("G8", "exact", duplicates, "a thousand times the same triangle");
const G9: Case = case!("G9", "closed form", small_far_sphere, "a small sphere seen from afar");
const G10: Case = case!(
    "G10",
    "closed form",
    spheres_within,
    "rays from within a sphere and just above a huge one"
);
const G13: Case =
    case!("G13", "exact", fine_detail_far_away, "details of 0.01 at coordinates of 10^6");

fn closed_mesh<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    around_mesh(random, DVec3::ZERO)
}

fn closed_mesh_far<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    around_mesh(random, dvec3(148_376.0, 1234.0, -223_423.0))
}

/// Rays from within and from without, at a corner or at a point of an edge that faces them.
fn around_mesh<S: Buildable>(
    random: &mut Random,
    center: DVec3,
) -> Result<Round<S>, PrimitiveError> {
    let mesh = icosphere(3, center);
    let mut round = Round::new(Model::triangles(&mesh)?);
    for _ in 0..RAYS_A_ROUND {
        let target = on_edge(random, &mesh);
        let out = target - center;
        let from = match random.below(2) {
            0 => point(random) * 0.3,
            _ => out * (1.6 + 3.0 * unit(random)) + point(random) * 0.2,
        };
        let origin = single(center + from);
        let ray = ray(origin, target - origin);
        if let Some(expected) = on_mesh(&mesh, &ray, 0.25) {
            round.push(ray, expected);
        }
    }
    Ok(round)
}

/// A corner, or a point of an edge that f64 holds exactly.
fn on_edge(random: &mut Random, mesh: &[Corners]) -> DVec3 {
    let [a, b, _]: Corners = one_of(random, mesh);
    let part = if random.below(2) == 0 { 0.0 } else { random.below(1 << 10) as f64 / 1024.0 };
    a + (b - a) * part
}

fn bumpy_sheet<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    let side = one_of(random, &[2, 4, 8, 16, 32, 48]);
    let phase = unit(random) * 6.0;
    let mesh = sheet(side, |x, y| (x * 7.3 + phase).sin() * (y * 5.1).cos() * 0.2);
    let mut round = Round::new(Model::triangles(&mesh)?);
    let far = f64::from(side);
    for _ in 0..RAYS_A_ROUND {
        let target = on_edge(random, &mesh);
        let is_inner = |x: f64| x > 0.0 && x < far;
        if !is_inner(target.x) || !is_inner(target.y) {
            continue;
        }
        let up = one_of(random, &[3.0, -3.0]) + unit(random);
        let origin = single(target + point(random).with_z(0.0) + dvec3(0.0, 0.0, up));
        let ray = ray(origin, target - origin);
        if let Some(expected) = on_mesh(&mesh, &ray, 0.2) {
            round.push(ray, expected);
        }
    }
    Ok(round)
}

fn flat_sheet<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    let mesh = sheet(64, |_, _| 0.0);
    let mut round = Round::new(Model::triangles(&mesh)?);
    for _ in 0..RAYS_A_ROUND {
        let mut half = || random.below(129) as f64 / 2.0;
        let target = dvec3(half(), half(), 0.0);
        let mut sign = || one_of(random, &[-1.0, -0.0, 0.0, 1.0]);
        let (x, y) = (sign(), sign());
        let d = dvec3(x, y, one_of(random, &[1.0, -1.0, 2.0, -4.0]));
        let ray = ray(target - d * 4.0, d);
        if let Some(expected) = on_lattice(&mesh, &ray) {
            round.push(ray, expected);
        }
    }
    Ok(round)
}

fn needle<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    let triangles = [[DVec3::ZERO, dvec3(1e4, 0.0, 0.0), dvec3(0.0, 1e-4, 0.0)].map(single)];
    soup_round(random, &triangles, |random| {
        let target = dvec3(unit(random) * 1e4, unit(random) * 1.2e-4, 0.0);
        let down = one_of(random, &[1.0, -1.0]);
        (single(target - dvec3(0.0, 0.0, down * 4.0)), dvec3(0.0, 0.0, down))
    })
}

fn degenerate<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
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
    let mut round: Round<S> = soup_round(random, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 2.0)
    })?;
    let ids = (first..triangles.len() as u32).collect();
    let (model, rays) = (Model::triangles(&clean)?, round.rays.clone());
    round.twins.push(Twin { name: "without them".into(), model, rays, factor: 1.0, ids });
    Ok(round)
}

fn twins<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    let mut triangles = soup(random, 60, 0.6);
    triangles.extend_from_within(..);
    random.shuffle(&mut triangles);
    let mut round: Round<S> = soup_round(random, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 2.0)
    })?;
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    random.shuffle(&mut order);
    let twin = Original { triangles: &triangles, rays: &round.rays }.renumbered(order);
    round.twins.extend(twin);
    Ok(round)
}

fn duplicates<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    let mut triangles = soup(random, 20, 0.5);
    let same: Corners = one_of(random, &triangles);
    triangles.extend(std::iter::repeat_n(same, 1000));
    soup_round(random, &triangles, |random| {
        let target = point_within(random, &triangles);
        toward(random, target, 2.0)
    })
}

fn small_far_sphere<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    const RADIUS: f64 = 0.1;
    let model = Model::mixed(|set| set.sphere(DVec3::ZERO, RADIUS))?;
    let mut round = Round::new(model);
    for _ in 0..RAYS_A_ROUND {
        let far = one_of(random, &[1e2, 1e3, 1e4, 1e5, 1e6]);
        let offset: f64 = one_of(random, &[0.095, 0.105]);
        let (axis, sign) = (random.below(3), one_of(random, &[1.0, -1.0]));
        let turned = |v: DVec3| match axis {
            0 => v,
            1 => dvec3(v.z, v.x, v.y),
            _ => dvec3(v.y, v.z, v.x),
        };
        let depth = (RADIUS * RADIUS - offset * offset).max(0.0).sqrt();
        let hit = Expected::hit_at(far - depth, far * 4.0 * f64::from(f32::EPSILON));
        let expected = if offset < RADIUS { hit } else { Expected::Miss };
        let ray = ray(turned(dvec3(-sign * far, offset, 0.0)), turned(dvec3(sign, 0.0, 0.0)));
        round.push(ray, expected);
    }
    Ok(round)
}

fn spheres_within<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    let radius: f64 = one_of(random, &[1.0, 1e6]);
    let model = Model::mixed(|set| set.sphere(DVec3::ZERO, radius))?;
    let mut round = Round::new(model);
    for _ in 0..RAYS_A_ROUND {
        let toward = direction(random);
        let (origin, along) = match random.below(2) {
            // through the centre from within: the way out is the radius and what was gone
            0 => (toward * radius * -0.5, toward),
            _ => (toward * (radius + radius.min(1.0)), -toward),
        };
        let ray = ray(origin, along);
        // as they were rounded
        let (o, d) = (single(origin), single(along));
        let (a, b) = (d.dot(d), o.dot(d));
        let root = (b * b - a * (o.dot(o) - radius * radius)).sqrt();
        let t = if o.length() < radius { (root - b) / a } else { (-root - b) / a };
        // what the rounding of the origin changes
        let slack = if radius > 1.0 { radius * 3e-7 } else { 1e-5 };
        round.push(ray, Expected::hit_at(t, slack));
    }
    Ok(round)
}

fn fine_detail_far_away<S: Buildable>(random: &mut Random) -> Result<Round<S>, PrimitiveError> {
    let center = dvec3(1e6, -1e6, 1e6);
    let far = |t: &Corners| t.map(|p| single(center + p));
    let triangles: Vec<Corners> = soup(random, 200, 0.4).iter().map(far).collect();
    soup_round(random, &triangles, |random| {
        let target = point_within(random, &triangles);
        let d = point(random);
        (single(target - d * 2.0), d)
    })
}
