//! Sets of one kind: points alone, equal triangles, a fan around one vertex, denormal coordinates
//! among ordinary ones, and so many triangles that several threads build.

use super::prelude::*;
use crate::verify::exact::on_mesh;

pub fn points<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let many = one_of(random, &[1, 2, 40, 300]);
    let places: Vec<DVec3> = (0..1 + many / 4).map(|_| point(random)).collect();
    let points: Vec<Corners> = (0..many).map(|_| [one_of(random, &places); 3]).collect();
    let mut round = Round::new(Model::<S>::triangles(&points)?);
    while round.rays.len() < rays {
        let target = one_of(random, &places);
        let (origin, along) = toward(random, target, 2.0);
        let ray = ray(one_of(random, &[origin, target]), along);
        if ray.is_traceable() {
            round.push(ray, OracleAnswer::Miss);
        }
    }
    Ok(round)
}

pub fn equal<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let others = soup(random, 3, 1.0);
    let one = soup(random, 1, 1.0);
    let mut all = others.clone();
    all.extend(std::iter::repeat_n(one[0], 100_000));
    let exact = Soup::new(&all[..4]);
    let mut round = Round::new(Model::triangles(&all)?);
    for _ in 0..rays {
        let target = point_within(random, &all[..4]);
        let (origin, along) = toward(random, target, 2.0);
        let ray: Ray<S> = ray(origin, along);
        round.push(ray, expected_in(&exact, &ray));
    }
    // of equal hits the lowest id counts
    let of = vec![0; round.rays.len()];
    round.near = Some(NearbyPrimitives { lists: vec![vec![0, 1, 2, 3]], of });
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
    let mut round = Round::new(Model::<S>::triangles(&triangles)?);
    while round.rays.len() < rays {
        let aim = random.below(4);
        let (origin, along) = match aim {
            0 => (vertex, direction(random)),
            1 => (vertex, rim[random.below(MANY)] - vertex),
            2 => (single(vertex + point(random) * 1e-6), direction(random)),
            _ => toward(random, vertex, 2.0),
        };
        let ray: Ray<S> = ray(origin, along);
        if !ray.is_traceable() {
            continue;
        }
        // where all of them are seen from above, they leave no gap
        if aim == 3 && height * along.truncate().length() < -0.9 * along.z {
            let slack = 1e-4 * (1.0 + height);
            round.push(ray, on_mesh(&mesh, &ray, slack).unwrap_or(OracleAnswer::Anything));
            continue;
        }
        let hits = every_hit(&round.model, &ray);
        push_chain(&mut round, ray, &hits, 3);
    }
    round.truncate(rays);
    Ok(round)
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
    let mut round = Round::new(Model::triangles(&triangles)?);
    while round.rays.len() < rays {
        let target = within_or_on_edge(random, &triangles);
        let away = 1.0 + unit(random);
        let (origin, along) = toward(random, target, away);
        let ray = ray(tiny(random, origin), along);
        if ray.is_traceable() {
            let expected = expected_in(&exact, &ray);
            round.push(ray, expected);
        }
    }
    Ok(round)
}

/// Enough for three parts.
const TRIANGLES: usize = 13_000;

pub fn threads<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, TRIANGLES, 0.05);
    let mut round = aimed_round(random, rays, &triangles, 2.0)?;
    round.threads = &[1, 3];
    Ok(round)
}
