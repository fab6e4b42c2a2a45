//! Awkward rays.

use super::prelude::*;
use crate::verify::metamorphic::MetamorphicPair;

pub fn signs<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = lattice_soup(random, 60);
    let mut round: Round<S> = lattice_round(random, rays, &triangles, |random| {
        let d = sign_direction(random);
        (lattice_point(random) - d * random_integer(random, 20).abs(), d)
    })?;
    let other_zeros = |r: &Ray<S>| {
        let d = r.direction.to_dvec3();
        let flipped = DVec3::from_array(d.to_array().map(|x| if x == 0.0 { -x } else { x }));
        ray(r.origin.to_dvec3(), flipped)
    };
    let flipped = round.rays.iter().map(other_zeros).collect();
    let model = Model::triangles(&triangles)?;
    let pair = MetamorphicPair::new("zeros of the other sign", model, flipped);
    let mirrored =
        OriginalScene { triangles: &triangles, rays: &round.rays }.mirrored(random.below(8) as u8);
    round.pairs.push(pair);
    round.pairs.extend(mirrored);
    Ok(round)
}

pub fn tiny_components<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    const HALF: f64 = 1e-4;
    const FAR: f64 = 1e3;
    let [a, b] = [-HALF, HALF];
    let corner = |y: f64, z: f64| dvec3(0.0, y, z);
    let square =
        [[corner(a, a), corner(b, a), corner(b, b)], [corner(a, a), corner(b, b), corner(a, b)]];
    let mut round = Round::new(Model::triangles(&square)?);
    for _ in 0..rays {
        let tiny = one_of(random, &[1e-45, 1e-38, 1e-20, 1e-7, f64::from(f32::EPSILON)]);
        let (dy, dz) = (one_of(random, &[tiny, -tiny]), one_of(random, &[tiny, -tiny, 0.0, -0.0]));
        let sign = one_of(random, &[1.0, -1.0]);
        let (y, z) = (signed(random) * 2.0 * HALF, signed(random) * 2.0 * HALF);
        let reached = (y + FAR * dy).abs().max((z + FAR * dz).abs());
        let expected = match reached / HALF {
            x if x < 0.99 => OracleAnswer::hit_at(FAR, FAR * 1e-6),
            x if x > 1.01 => OracleAnswer::Miss,
            _ => OracleAnswer::Anything,
        };
        round.push(ray(dvec3(-sign * FAR, y, z), dvec3(sign, dy, dz)), expected);
    }
    Ok(round)
}

pub fn scaled_directions<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, 100, 0.3);
    let mut round: Round<S> = aimed_round(random, rays, &triangles, 2.0)?;
    let original = OriginalScene { triangles: &triangles, rays: &round.rays };
    let exponents = [one_of(random, &[-60, -37, -10]), one_of(random, &[-1, 3, 20]), 60];
    let pairs: Vec<_> =
        exponents.into_iter().filter_map(|e| original.with_direction_scaled(e)).collect();
    round.pairs = pairs;
    Ok(round)
}

pub fn meaningless<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, 100, 0.3);
    let mut round = Round::new(Model::triangles(&triangles)?);
    for i in 0..rays {
        let target = point_within(random, &triangles);
        let (origin, along) = toward(random, target, 2.0);
        let mut bad: Ray<S> = ray(origin, along);
        let strange = one_of(random, &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
        let spoiled = |p: DVec3, k: usize| with(p, k, strange);
        match i % 6 {
            0 => bad = ray(spoiled(origin, random.below(3)), along),
            1 => bad = ray(origin, spoiled(along, random.below(3))),
            2 => bad = ray(origin, DVec3::splat(one_of(random, &[0.0, -0.0]))),
            3 => bad.t_min = S::from_f64(f64::NAN),
            4 => bad.t_max = S::from_f64(f64::NAN),
            _ => (bad.t_min, bad.t_max) = (S::ONE, S::from_f64(unit(random) * 0.99)),
        }
        round.push(bad, OracleAnswer::Miss);
    }
    Ok(round)
}

pub fn interval_ends<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = sheet(12, |_, _| 0.0);
    let mut round = Round::new(Model::triangles(&triangles)?);
    for _ in 0..rays {
        // eighths: all products and sums of the test are exact, and so is t
        let mut eighths = |below: usize| random.below(below) as f64 / 8.0;
        let (x, y, height) = (eighths(97), eighths(97), 0.125 + eighths(64));
        let down = one_of(random, &[1.0, -1.0]);
        let mut ray: Ray<S> = ray(dvec3(x, y, height * down), dvec3(0.0, 0.0, -down));
        let t = S::from_f64(height);
        let (t_min, t_max, is_hit) = match random.below(6) {
            0 => (t, S::INFINITY, true),
            1 => (t.next_up(), S::INFINITY, false),
            2 => (t.next_down(), S::INFINITY, true),
            3 => (S::ZERO, t, true),
            4 => (S::ZERO, t.next_down(), false),
            _ => (t, t, true),
        };
        (ray.t_min, ray.t_max) = (t_min, t_max);
        let hit = OracleAnswer::Hit { id: None, t: [height, height] };
        round.push(ray, if is_hit { hit } else { OracleAnswer::Miss });
    }
    Ok(round)
}

pub fn far_origins<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, 60, 1.0);
    soup_round(random, rays, &triangles, |random| {
        let target = point_within(random, &triangles);
        let from = direction(random) * one_of(random, &[1e4, 1e6, 1e7]) * 3.5;
        (target + from, -from)
    })
}

pub fn on_the_box<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let side = f64::from(LATTICE);
    let mut triangles = lattice_soup(random, 60);
    // the scene's box is that of the lattice
    triangles.push([DVec3::ZERO, dvec3(side, 0.0, 0.0), dvec3(0.0, side, side)]);
    let mut round: Round<S> = lattice_round(random, rays, &triangles, |random| {
        let mut origin = lattice_point(random);
        for _ in 0..=random.below(3) {
            let end = one_of(random, &[0.0, side]);
            origin[random.below(3)] = end;
        }
        (origin, sign_direction(random))
    })?;
    let original = OriginalScene { triangles: &triangles, rays: &round.rays };
    let pair = original.mirrored(random.below(8) as u8);
    round.pairs.extend(pair);
    Ok(round)
}
