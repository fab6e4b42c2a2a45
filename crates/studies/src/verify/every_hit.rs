//! Every hit of a ray, found without a structure: each primitive is tested alone.

use std::cmp::Ordering;

use accel_core::primitives::PrimSet;
use accel_core::{Hit, Ray, Scalar};

use super::model::Model;
use super::round::{OracleAnswer, Round};

/// A line meets a convex surface twice; more hits of one primitive are a fault, and enough of one.
const MOST_OF_ONE: usize = 8;

/// All hits within the ray's interval, by parameter and id.
pub fn every_hit<S: Scalar>(model: &Model<S>, ray: &Ray<S>) -> Vec<Hit<S>> {
    match model {
        Model::Triangles(set) => hits_of(set, ray),
        Model::Mixed(set) => hits_of(set, ray),
    }
}

fn hits_of<S: Scalar>(prims: &impl PrimSet<S>, ray: &Ray<S>) -> Vec<Hit<S>> {
    let setup = prims.setup(ray);
    let mut all = Vec::new();
    for id in 0..prims.len() as u32 {
        let mut ahead = *ray;
        for _ in 0..MOST_OF_ONE {
            let Some(t) = prims.intersect(id, &ahead, &setup, ray.t_max) else { break };
            all.push(Hit { t, id });
            ahead.t_min = t.next_up();
        }
    }
    all.sort_by(order);
    all
}

/// By parameter, zeros of both signs being equal, then by id.
fn order<S: Scalar>(a: &Hit<S>, b: &Hit<S>) -> Ordering {
    a.t.partial_cmp(&b.t).unwrap_or(Ordering::Equal).then(a.id.cmp(&b.id))
}

/// Closest hit in `[t_min, t_max]`, bit by bit, among these sorted hits: the first, and so the
/// lowest id of equal ones.
pub fn first_within<S: Scalar>(hits: &[Hit<S>], t_min: S, t_max: S) -> OracleAnswer {
    let first = hits.iter().find(|hit| t_min <= hit.t && hit.t <= t_max);
    first.map_or(OracleAnswer::Miss, |hit| OracleAnswer::Hit {
        id: Some(hit.id),
        t: [hit.t.to_f64(); 2],
    })
}

/// Adds the ray, and again with its interval begun just after each of its hits (`hits`, sorted):
/// every hit must be found once and in order, of equal ones that of the lowest id; then nothing.
/// A structure that answers each link so answers the chain so. No more than `most` links.
pub fn push_chain<S: Scalar>(round: &mut Round<S>, ray: Ray<S>, hits: &[Hit<S>], most: usize) {
    let mut link = ray;
    for _ in 0..most {
        round.push(link, first_within(hits, link.t_min, link.t_max));
        let Some(hit) = hits.iter().find(|hit| link.t_min <= hit.t) else { return };
        link.t_min = hit.t.next_up();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::round::ray;
    use glam::{DVec3, dvec3};

    #[test]
    fn both_sides_of_a_ball_and_both_of_equal_triangles() {
        let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        let model = Model::<f32>::mixed(|set| {
            set.sphere(dvec3(1.0, 1.0, 0.0), 0.5)?;
            set.triangle(corners)?;
            set.triangle(corners)
        })
        .unwrap();
        let mut line: Ray<f32> = ray(dvec3(1.0, 1.0, 0.25), -DVec3::Z);
        line.t_min = f32::NEG_INFINITY;
        let hits = every_hit(&model, &line);
        let told: Vec<(f32, u32)> = hits.iter().map(|h| (h.t, h.id)).collect();
        assert_eq!(told, [(-0.25, 0), (0.25, 1), (0.25, 2), (0.75, 0)]);
        let mut round = Round::new(model);
        push_chain(&mut round, line, &hits, 9);
        let hit = |t, id| OracleAnswer::Hit { id: Some(id), t: [t, t] };
        assert_eq!(round.expected, [hit(-0.25, 0), hit(0.25, 1), hit(0.75, 0), OracleAnswer::Miss]);
        assert_eq!(round.rays[2].t_min, 0.25_f32.next_up());
    }
}
