//! Directions with one or two components that are denormal or huge.
//!
//! Such a component changes the ray by less than f64 can tell, or makes the others so. The oracle
//! is exact: rays in the plane of a flat scene, from outside it, leave the plane at once and meet
//! nothing; elsewhere a denormal component is as good as 0, and a huge direction as good as one a
//! power of two smaller, whose parameters are as much larger.

use super::prelude::*;
use crate::verify::exact::in_soup_within;

/// A component this much smaller than the largest moves no hit by as much as the oracle leaves
/// open.
const NOTHING: f64 = 1.0 / (1_u64 << 27) as f64;

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
    let mut round = Round::new(Model::triangles(&triangles)?);
    for _ in 0..rays {
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
        round.push(ray(origin, put(along, off)), OracleAnswer::Miss);
    }
    Ok(round)
}

fn in_loose_triangles<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let triangles = soup(random, 100, 0.4);
    let exact = Soup::new(&triangles);
    let mut round = Round::new(Model::triangles(&triangles)?);
    for _ in 0..rays {
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
        let ray: Ray<S> = ray(origin, along);
        if ray.is_traceable() {
            let expected = expected(&exact, &ray);
            round.push(ray, expected);
        }
    }
    Ok(round)
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
