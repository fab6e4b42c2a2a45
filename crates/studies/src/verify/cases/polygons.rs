//! Polygons that share edges and vertices, seen from above, edge-on and from within.

use super::*;
use crate::verify::every_hit::outside_box;
use crate::verify::meshes::{body, placed, tangled, tiling, wound};
use crate::verify::surface::{Outlines, Surface};

/// Links of a chain that are asked.
const LINKS: usize = 12;

pub fn at_edges<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let outlines = surface(random, 1.0);
    surface_round(random, rays, &outlines, at_edge)
}

pub fn nearly_in_plane<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let outlines = surface(random, 1.0);
    surface_round(random, rays, &outlines, near_plane)
}

pub fn slivers<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let most = one_of(random, &[1e1, 1e2, 1e3, 1e4]);
    let outlines = surface(random, most);
    surface_round(random, rays, &outlines, |random, outlines| match random.below(2) {
        0 => at_edge(random, outlines),
        _ => near_plane(random, outlines),
    })
}

fn surface(random: &mut Random, most: f64) -> Outlines {
    let outlines = match random.below(2) {
        0 => {
            let side = 1 + random.below(10);
            tiling(random, side)
        }
        _ => body(random),
    };
    placed(random, &outlines, most)
}

struct Aim {
    target: DVec3,
    /// To the origin, any length.
    from: DVec3,
}

/// At a vertex, an edge or within a polygon, and a few ulps beside.
fn at_edge(random: &mut Random, outlines: &Outlines) -> Aim {
    let target = target(random, outlines);
    let beside = one_of(random, &[0.0, 0.0, 1e-7, 1e-6, 1e-15]) * target.abs().max_element();
    let target = target + point(random) * beside;
    Aim { target, from: direction(random) * (0.1 + 3.0 * unit(random)) }
}

fn near_plane(random: &mut Random, outlines: &Outlines) -> Aim {
    let outline = &outlines[random.below(outlines.len())];
    let target = target(random, &vec![outline.clone()]);
    let (a, b, c) = (outline[0], outline[1], outline[outline.len() - 1]);
    let normal = (b - a).cross(c - a).normalize_or(DVec3::Z);
    let any = direction(random);
    let any = one_of(random, &[b - a, c - b, any]);
    let along = (any - normal * any.dot(normal)).normalize_or_zero();
    let tilt = 10f64.powf(-1.0 - 8.0 * unit(random)) * one_of(random, &[1.0, -1.0, 1.0, -1.0, 0.0]);
    Aim { target, from: (along + normal * tilt) * (0.5 + 3.0 * unit(random)) }
}

fn target(random: &mut Random, outlines: &Outlines) -> DVec3 {
    let outline = &outlines[random.below(outlines.len())];
    let i = random.below(outline.len());
    let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
    match random.below(3) {
        0 => a,
        1 => a + (b - a) * (random.below(1 << 10) as f64 / 1024.0),
        _ => {
            let c = outline[random.below(outline.len())];
            let (u, v) = (unit(random) * 0.5, unit(random) * 0.5);
            a + (b - a) * u + (c - a) * v
        }
    }
}

/// Rays at a surface, their origins away by the size of its part in view.
fn surface_round<S: Buildable>(
    random: &mut Random,
    rays: usize,
    outlines: &Outlines,
    aim: impl Fn(&mut Random, &Outlines) -> Aim,
) -> RoundResult<S> {
    let surface = Surface::new(outlines);
    let magnitude = surface.magnitude();
    let model = mixed_model(|set| {
        wound(random, outlines).iter().try_for_each(|outline| set.polygon(outline))
    })?;
    let first = outlines[0][0];
    let size = outlines.iter().flatten().map(|p| p.distance(first)).fold(0.0, f64::max);
    Ok(Round::new(model).filled(rays, |round| {
        let Aim { target, from } = aim(random, outlines);
        let origin = single(target + from * size);
        // farther origins are brought near before they are asked
        if origin.abs().max_element() > 7.0 * magnitude {
            return;
        }
        let ray = ray(origin, target - origin);
        push_hits(round, ray, LINKS, |model, hits| {
            surface.fault(&ray, hits).or_else(|| outside_box(model, &ray, hits))
        });
    }))
}

/// One polygon in a plane of any slant: the arrow whose fan of triangles is nine times too large, a
/// star, a square with collinear and repeated vertices; some with vertices 10^-4 off the plane.
pub fn alone<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let square = [(0., 0.), (1., 0.), (2., 0.), (2., 0.), (2., 2.), (1.5, 2.), (0., 2.), (0., 1.)];
    let outline: Vec<DVec2> = match random.below(3) {
        0 => vec![dvec2(0.0, 0.0), dvec2(2.0, 0.0), dvec2(0.2, 0.2), dvec2(0.0, 2.0)],
        1 => star(random),
        _ => square.map(|(x, y)| dvec2(x, y)).to_vec(),
    };
    let bend = one_of(random, &[0.0, 1e-4]);
    let outline: Vec<DVec3> =
        outline.iter().map(|p| p.extend(bend * signed(random))).map(single).collect();
    outline_round(random, rays, outline)
}

pub fn tangled_alone<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let outline = tangled(random);
    outline_round(random, rays, outline)
}

fn outline_round<S: Buildable>(
    random: &mut Random,
    rays: usize,
    outline: Vec<DVec3>,
) -> RoundResult<S> {
    let outlines = placed(random, &vec![outline], 1.0);
    surface_round(random, rays, &outlines, |random, outlines| {
        let aim = at_edge(random, outlines);
        let outline = &outlines[0];
        let away = outline[random.below(outline.len())] - aim.target;
        // mostly anywhere around it
        let across = if random.below(4) > 0 { unit(random) } else { 0.0 };
        Aim { target: aim.target + away * across, ..aim }
    })
}

/// A star of many points around (1, 1).
fn star(random: &mut Random) -> Vec<DVec2> {
    let points = 5 + random.below(12);
    let corner = |i: usize| {
        let turn = i as f64 / (2 * points) as f64 * std::f64::consts::TAU;
        let radius = if i.is_multiple_of(2) { 1.0 } else { 0.3 + 0.3 * unit(random) };
        dvec2(1.0, 1.0) + dvec2(turn.cos(), turn.sin()) * radius
    };
    (0..2 * points).map(corner).collect()
}
