//! Awkward rays.

use super::*;
use crate::verify::among_triangles::in_soup_within;
use crate::verify::round::MetamorphicPair;

pub fn signs<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = lattice_soup(random, 60);
    let mut round: Round<S> = exact_round(random, rays, &triangles, on_lattice, |random| {
        let d = sign_direction(random);
        (lattice_point(random) - d * random_integer(random, 20).abs(), d)
    })?;
    let other_zeros = |r: &Ray<S>| {
        let d = r.direction.to_dvec3();
        let flipped = DVec3::from_array(d.to_array().map(|x| if x == 0.0 { -x } else { x }));
        ray(r.origin.to_dvec3(), flipped)
    };
    let flipped = round.rays.iter().map(other_zeros).collect();
    let model = model_of(&triangles)?;
    let pair = MetamorphicPair::new("zeros of the other sign", model, flipped);
    round.pairs.push(pair);
    round.pairs.extend(round.mirrored(random.below(8) as u8));
    Ok(round)
}

pub fn tiny_components<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    const HALF: f64 = 1e-4;
    const FAR: f64 = 1e3;
    let [a, b] = [-HALF, HALF];
    let corner = |y: f64, z: f64| dvec3(0.0, y, z);
    let square =
        [[corner(a, a), corner(b, a), corner(b, b)], [corner(a, a), corner(b, b), corner(a, b)]];
    let mut round = Round::new(model_of(&square)?);
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
    let exponents = [one_of(random, &[-60, -37, -10]), one_of(random, &[-1, 3, 20]), 60];
    let pairs = exponents.into_iter().filter_map(|e| round.with_direction_scaled(e));
    round.pairs = pairs.collect();
    Ok(round)
}

pub fn meaningless<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, 100, 0.3);
    let mut round = Round::new(model_of(&triangles)?);
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
    let mut round = Round::new(model_of(&triangles)?);
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
    exact_round(random, rays, &triangles, in_soup, |random| {
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
    let mut round: Round<S> = exact_round(random, rays, &triangles, on_lattice, |random| {
        let mut origin = lattice_point(random);
        for _ in 0..=random.below(3) {
            let end = one_of(random, &[0.0, side]);
            origin[random.below(3)] = end;
        }
        (origin, sign_direction(random))
    })?;
    round.pairs.extend(round.mirrored(random.below(8) as u8));
    Ok(round)
}

/// A component this much smaller than the largest moves no hit by as much as the oracle leaves
/// open.
const NOTHING: f64 = 1.0 / (1_u64 << 27) as f64;

/// Directions with one or two components that are denormal or huge. Such a component changes the
/// ray by less than f64 can tell, or makes the others so. The oracle is exact: rays in the plane of
/// a flat scene, from outside it, leave the plane at once and meet nothing; elsewhere a denormal
/// component is as good as 0, and a huge direction as good as one a power of two smaller, whose
/// parameters are as much larger.
pub fn extreme_components<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    if random.below(2) == 0 {
        in_a_flat_scene(random, rays)
    } else {
        in_loose_triangles(random, rays)
    }
}

/// All triangles lie in a plane across an axis, and so do the origins, outside.
fn in_a_flat_scene<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let axis = random.below(3);
    let level = one_of(random, &[0.0, 1.0, -0.75, 3.5]);
    let put = |p: DVec3, x: f64| with(p, axis, x);
    let flat = |t: &Corners| t.map(|p| put(p, level));
    let triangles: Vec<Corners> = soup(random, 200, 0.3).iter().map(flat).collect();
    exact_round(
        random,
        rays,
        &triangles,
        |_, _| Some(OracleAnswer::Miss),
        |random| {
            // corners lie within 1.3 of the axis
            let beside = one_of(random, &[0, 1].map(|k| (axis + 1 + k) % 3));
            let origin = put(point(random) * 2.0, level);
            let origin = with(origin, beside, one_of(random, &[1.5, -1.5, 7.0, -7.0]));
            let target = put(point_within(random, &triangles), level);
            let mut along = target - origin;
            if random.below(3) == 0 {
                // along an axis, the third component tiny as well
                let tiny = put(DVec3::splat(denormal::<S>(random)), 0.0);
                along = with(tiny, beside, along[beside]);
            }
            let off = match random.below(4) {
                0 => one_of(random, &[1e-30, -1e-30, 0.0, -0.0]),
                _ => denormal::<S>(random),
            };
            (origin, put(along, off))
        },
    )
}

fn in_loose_triangles<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, 100, 0.4);
    let oracle = |exact: &Soup, ray: &Ray<S>| ray.is_traceable().then(|| expected(exact, ray));
    exact_round(random, rays, &triangles, oracle, |random| {
        let target = single(point_within(random, &triangles));
        let (mut origin, mut along) = toward(random, target, 2.0);
        let many = 1 + random.below(2);
        let first = random.below(3);
        let is_huge = random.below(2) == 0;
        for k in (0..many).map(|k| (first + k) % 3) {
            if is_huge {
                along[k] *= huge::<S>(random);
            } else {
                along[k] = denormal::<S>(random);
                // still at the target
                origin[k] = if unit(random) < 0.9 { target[k] } else { denormal::<S>(random) };
            }
        }
        if is_huge {
            // along what is huge, the others but a little off the target
            let rest = (0..3).filter(|k| (k + 3 - first) % 3 >= many);
            rest.for_each(|k| origin[k] = target[k] + 1e-3 * signed(random));
        }
        (origin, along)
    })
}

/// Answer of the exact oracle for the ray as it can represent it, which is off by the rounding to
/// f32 in either precision.
fn expected<S: Scalar>(exact: &Soup, ray: &Ray<S>) -> OracleAnswer {
    let d = ray.direction.to_dvec3();
    let largest = d.abs().max_element();
    let exponent = largest.log2().floor();
    // in two steps: the inverse of the largest power of two is none of f64's normal numbers
    let half = (-exponent / 2.0).floor();
    let d = d * half.exp2() * (-exponent - half).exp2();
    let seen = |x: f64| if x.abs() < NOTHING { 0.0 } else { f64::from(x as f32) };
    let d = dvec3(seen(d.x), seen(d.y), seen(d.z));
    let from = |x: f64| if x.abs() < NOTHING { 0.0 } else { x };
    let o = ray.origin.to_dvec3();
    let o = dvec3(from(o.x), from(o.y), from(o.z));
    let seen = Ray::<S>::from_dvec3(o, d);
    match in_soup_within(f64::from(f32::EPSILON), exact, &seen) {
        Some(OracleAnswer::Hit { id, t }) => {
            let by = |t: f64| t * half.exp2() * (-exponent - half).exp2();
            OracleAnswer::Hit { id, t: t.map(by) }
        }
        Some(other) => other,
        None => OracleAnswer::Anything,
    }
}

fn denormal<S: Scalar>(random: &mut Random) -> f64 {
    let least = S::ZERO.next_up().to_f64();
    let bits = if S::NAME == "f32" { 23.0 } else { 52.0 };
    let size = match random.below(2) {
        0 => 1.0,
        _ => (unit(random) * bits).exp2().floor(),
    };
    least * size * one_of(random, &[1.0, -1.0])
}

fn huge<S: Scalar>(random: &mut Random) -> f64 {
    let [least, most] = if S::NAME == "f32" { [60.0, 126.0] } else { [500.0, 1022.0] };
    (least + (most - least) * unit(random)).floor().exp2()
}
