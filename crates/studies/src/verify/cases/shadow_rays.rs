//! Shadow rays: through primitives that let them pass, and to lights in awkward places.

use accel_core::primitives::TriangleSet;

use super::*;

/// Glass before and behind opaque primitives, and in the same place.
pub fn glass<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
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
            Geometry::Triangles(TriangleSet::new(rounded.collect(), is_glass)?)
        }
        _ => mixed_model(|set| {
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
    Ok(Round::new(model).filled(rays, |round| {
        let target = point_within(random, &triangles);
        let (origin, along) = toward(random, target, 2.0);
        let t_max = S::from_f64(one_of(random, &[1.0, 0.5, 2.0, f64::INFINITY]));
        let ray: Ray<S> = Ray { t_max, ..ray(origin, along) };
        if !ray.is_traceable() {
            return;
        }
        let hits = every_hit(&round.model, &ray);
        let prims = round.model.prims().primitives();
        let is_blocked = hits.iter().any(|hit| prims.is_opaque(hit.id));
        round.push(ray, first_within(&hits, ray.t_min, ray.t_max));
        round.blocked.push(is_blocked);
    }))
}

const LIGHTS: usize = 3;

pub fn lights<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let size = one_of(random, &[0.2, 0.8]);
    let triangles: Vec<Corners> = match random.below(3) {
        0 => icosphere(2, DVec3::ZERO),
        1 => soup(random, 120, size),
        _ => soup(random, 80, size).iter().map(|t| t.map(|p| p.with_z(0.25))).collect(),
    };
    let has_balls = random.below(2) == 0;
    let mut round = Round::new(if has_balls {
        mixed_model(|set| {
            triangles.iter().try_for_each(|t| set.triangle(*t))?;
            (0..6).try_for_each(|_| set.sphere(point(random), 0.05 + 0.3 * unit(random)))
        })?
    } else {
        model_of::<S>(&triangles)?
    });
    round.lights = (0..LIGHTS).map(|_| light(random, &triangles)).collect();
    Ok(round.filled(rays, |round| {
        let number = random.below(LIGHTS);
        let light = round.lights[number];
        let target = match random.below(3) {
            0 => point(random) * 1.5,
            1 => on_edge(random, &triangles),
            _ => point_within(random, &triangles),
        };
        // to the light, from a surface or anywhere
        let origin = single(target);
        let part = one_of(random, &[1.0, 1.0 - 1e-6, 0.999]);
        let ray: Ray<S> = ray(origin, light - origin);
        let [t_min, t_max] = [one_of(random, &[0.0, 1e-6, 1e-3]), part].map(S::from_f64);
        let ray = Ray { t_min, t_max, ..ray };
        if !ray.is_traceable() {
            return;
        }
        let hits = every_hit(&round.model, &ray);
        round.push(ray, first_within(&hits, t_min, t_max));
        round.blocked.push(!hits.is_empty());
        round.light_of.push(number as u32);
    }))
}

fn light(random: &mut Random, triangles: &[Corners]) -> DVec3 {
    let [a, b, c]: Corners = one_of(random, triangles);
    let light = match random.below(6) {
        0 => point_within(random, triangles),
        1 => a,
        // in the plane of a triangle
        2 => a + (b - a) * (3.0 * signed(random)) + (c - a) * (3.0 * signed(random)),
        3 => point(random) * 0.1,
        4 => direction(random) * 1e9,
        _ => point(random) * 3.0,
    };
    single(light)
}
