//! Sets of one kind: points alone, equal triangles, a fan around one vertex, denormal coordinates
//! among ordinary ones, so many triangles that several threads build; and copies of an object:
//! mirrored, sheared, a millionth of its size, one replaced by another.

use accel_core::primitives::Instance;
use glam::{DAffine3, DQuat};

use super::*;
use crate::verify::among_triangles::on_mesh;

pub fn points<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let many = one_of(random, &[1, 2, 40, 300]);
    let places: Vec<DVec3> = (0..1 + many / 4).map(|_| point(random)).collect();
    let points: Vec<Corners> = (0..many).map(|_| [one_of(random, &places); 3]).collect();
    Ok(Round::new(model_of::<S>(&points)?).filled(rays, |round| {
        let target = one_of(random, &places);
        let (origin, along) = toward(random, target, 2.0);
        let ray = ray(one_of(random, &[origin, target]), along);
        round.push_traceable(ray, |_| OracleAnswer::Miss);
    }))
}

pub fn equal<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let others = soup(random, 3, 1.0);
    let one = soup(random, 1, 1.0);
    let mut all = others.clone();
    all.extend(std::iter::repeat_n(one[0], 100_000));
    let exact = Soup::new(&all[..4]);
    let mut round = Round::new(model_of(&all)?);
    for _ in 0..rays {
        let target = point_within(random, &all[..4]);
        let (origin, along) = toward(random, target, 2.0);
        let ray: Ray<S> = ray(origin, along);
        round.push(ray, expected_in(&exact, &ray));
    }
    // of equal hits the lowest id counts
    round.near = vec![vec![0, 1, 2, 3]; rays];
    Ok(round)
}

pub fn fan<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    const MANY: usize = 1000;
    let vertex = single(point(random) * one_of(random, &[0.0, 1.0, 10.0]));
    // up to a needle, down to a disc
    let height = one_of(random, &[0.0, 1e-3, 1.0, 30.0]);
    let rim: Vec<DVec3> = (0..MANY)
        .map(|i| {
            let turn = i as f64 / MANY as f64 * std::f64::consts::TAU;
            single(vertex + dvec3(turn.cos(), turn.sin(), -height))
        })
        .collect();
    let mut triangles: Vec<Corners> =
        (0..MANY).map(|i| [vertex, rim[i], rim[(i + 1) % MANY]]).collect();
    random.shuffle(&mut triangles);
    let mesh = Soup::new(&triangles);
    Ok(Round::new(model_of::<S>(&triangles)?).filled(rays, |round| {
        let aim = random.below(4);
        let (origin, along) = match aim {
            0 => (vertex, direction(random)),
            1 => (vertex, rim[random.below(MANY)] - vertex),
            2 => (single(vertex + point(random) * 1e-6), direction(random)),
            _ => toward(random, vertex, 2.0),
        };
        let ray: Ray<S> = ray(origin, along);
        // where all of them are seen from above, they leave no gap
        if aim == 3 && height * along.truncate().length() < -0.9 * along.z {
            let slack = 1e-4 * (1.0 + height);
            let expected = |_: &_| on_mesh(&mesh, &ray, slack).unwrap_or(OracleAnswer::Anything);
            round.push_traceable(ray, expected);
        } else {
            push_hits(round, ray, 3, |_, _| None);
        }
    }))
}

pub fn denormal<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let least = if S::NAME == "f32" { -140f64 } else { -1060f64 }.exp2();
    let tiny = |random: &mut Random, p: DVec3| {
        let mut p = p.to_array();
        for x in &mut p {
            if random.below(3) == 0 {
                *x = signed(random) * 100.0 * least;
            }
        }
        DVec3::from_array(p)
    };
    let triangles: Vec<Corners> =
        soup(random, 80, 0.8).iter().map(|t| t.map(|p| tiny(random, p))).collect();
    let exact = Soup::new(&triangles);
    Ok(Round::new(model_of::<S>(&triangles)?).filled(rays, |round| {
        let target = within_or_on_edge(random, &triangles);
        let away = 1.0 + unit(random);
        let (origin, along) = toward(random, target, away);
        let ray = ray(tiny(random, origin), along);
        round.push_traceable(ray, |_| expected_in(&exact, &ray));
    }))
}

pub fn threads<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    // enough for three parts
    let triangles = soup(random, 13_000, 0.05);
    let mut round = aimed_round(random, rays, &triangles, 2.0)?;
    round.threads = &[1, 3];
    Ok(round)
}

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
    let model = match model_of::<S>(&all)? {
        Geometry::Triangles(set) => Geometry::Triangles(set.with_instances(&claims)),
        mixed => mixed,
    };
    let exact = Soup::new(&all);
    Ok(Round::new(model).filled(rays, |round| {
        let copy = random.below(claims.len());
        let own = &all[copy * TRIANGLES..(copy + 1) * TRIANGLES];
        let size = own[0][0].distance(own[TRIANGLES / 2][0]);
        let target = within_or_on_edge(random, own);
        let away = one_of(random, &[2.0 * size, 3.0, far]);
        let (origin, along) = toward(random, target, away);
        let ray = ray(origin, along);
        round.push_traceable(ray, |_| expected_in(&exact, &ray));
    }))
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
