//! Copies of an object: mirrored, sheared, a millionth of its size, one replaced by another.

use accel_core::primitives::Instance;
use glam::{DAffine3, DQuat};

use super::prelude::*;

/// Triangles of the object.
const TRIANGLES: usize = 24;

pub fn copies<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let object = soup(random, TRIANGLES, 0.5);
    let far = one_of(random, &[3.0, 3.0, 1e3, 1e5]);
    let (mut all, mut claims): (Vec<Corners>, Vec<Instance>) = (Vec::new(), Vec::new());
    for copy in 0..12 {
        let placement = match claims.last() {
            Some(last) if copy == 7 => last.placement,
            _ => placement(random, far),
        };
        let first = all.len() as u32;
        claims.push(Instance { object: 0, first, count: TRIANGLES as u32, placement });
        // what a set holds is what the copy is: rounded in its place
        let placed =
            |p: DVec3| DVec3::from_array(placement.transform_point3(p).to_array().map(held::<S>));
        all.extend(object.iter().map(|t| t.map(placed)));
    }
    let model = match Model::<S>::triangles(&all)? {
        Model::Triangles(set) => Model::Triangles(set.with_instances(&claims)),
        mixed => mixed,
    };
    let exact = Soup::new(&all);
    let mut round = Round::new(model);
    while round.rays.len() < rays {
        let copy = random.below(claims.len());
        let own = &all[copy * TRIANGLES..(copy + 1) * TRIANGLES];
        let size = own[0][0].distance(own[TRIANGLES / 2][0]);
        let target = within_or_on_edge(random, own);
        let away = one_of(random, &[2.0 * size, 3.0, far]);
        let (origin, along) = toward(random, target, away);
        let ray = ray(origin, along);
        if ray.is_traceable() {
            let expected = expected_in(&exact, &ray);
            round.push(ray, expected);
        }
    }
    Ok(round)
}

fn held<S: Scalar>(x: f64) -> f64 {
    S::from_f64(x).to_f64()
}

fn placement(random: &mut Random, far: f64) -> DAffine3 {
    let size = one_of(random, &[1.0, 1.0, 1e-1, 1e-3, 1e-6]);
    let mut stretch = DVec3::splat(size);
    let mut shear = DVec3::ZERO;
    match random.below(4) {
        0 => stretch *= dvec3(1.0, -1.0, 1.0),
        1 => stretch *= dvec3(1.0, 0.2 + unit(random), -2.0),
        2 => shear = point(random) * size,
        _ => {}
    }
    let turn = DQuat::from_axis_angle(direction(random), unit(random) * 6.0);
    let mut place =
        DAffine3::from_scale_rotation_translation(stretch, turn, single(point(random) * far));
    place.matrix3.x_axis += shear;
    place
}
