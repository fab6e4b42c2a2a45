//! Whether a ray hits a triangle, in integers, and how far from its outline it passes.

use super::float::Toy;
use crate::geometry::scalar::Scalar;

/// Coordinates are whole multiples of 2^-24 here.
const UNIT: f64 = (1 << 24) as f64;

type Point = [i128; 3];

pub(super) fn point<const P: u32>(p: [Toy<P>; 3]) -> Point {
    p.map(|x| {
        let units = x.to_f64() * UNIT;
        assert_eq!(units, units.trunc(), "{x} is no multiple of the unit");
        units as i128
    })
}

fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|k| a[k] - b[k])
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The exact answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Answer {
    /// Edge-on, or without area.
    Flat,
    Miss,
    /// Also on the outline.
    Hit,
}

/// A ray from `o` along `d`, from its origin on.
pub(super) fn answer(triangle: [Point; 3], o: Point, d: Point) -> Answer {
    let [a, b, c] = triangle.map(|v| minus(v, o));
    let signs = [(b, c), (c, a), (a, b)].map(|(p, q)| dot(d, cross(p, q)).signum());
    let normal = cross(minus(b, a), minus(c, a));
    let (along, depth) = (dot(normal, d), dot(normal, a));
    if along == 0 {
        return Answer::Flat;
    }
    let is_within = !(signs.contains(&1) && signs.contains(&-1));
    // a depth of 0 is at the origin
    let is_ahead = depth == 0 || depth.signum() == along.signum();
    if is_within && is_ahead { Answer::Hit } else { Answer::Miss }
}

/// How far across the ray its nearest point of a triangle's outline is: on the axes across its
/// longest one, the larger of both. In f64: a measure, not a decision.
pub(super) fn across(triangle: [Point; 3], o: Point, d: Point) -> f64 {
    let long = (0..3).max_by_key(|&k| d[k].abs()).unwrap_or(0);
    let [x, y] = [(long + 1) % 3, (long + 2) % 3];
    let sheared = triangle.map(|v| {
        let v = minus(v, o);
        // exact before it is divided
        let at = |k: usize| (v[k] * d[long] - d[k] * v[long]) as f64 / d[long] as f64 / UNIT;
        [at(x), at(y)]
    });
    let distance = |i: usize| to_segment(sheared[i], sheared[(i + 1) % 3]);
    distance(0).min(distance(1)).min(distance(2))
}

/// Distance of a ray's origin from the plane of a triangle that has an area.
pub(super) fn height([a, b, c]: [Point; 3], o: Point) -> f64 {
    let normal = cross(minus(b, a), minus(c, a));
    let length = normal.map(|x| x as f64 * x as f64).iter().sum::<f64>().sqrt();
    dot(normal, minus(a, o)).abs() as f64 / length / UNIT
}

/// Distance of a segment from 0, by the larger coordinate: it is least at an end, or where the
/// coordinates are equal, opposite, or zero.
fn to_segment([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let stops = [0.0, 1.0, (ay - ax) / (dx - dy), -(ax + ay) / (dx + dy), -ax / dx, -ay / dy];
    let within = stops.into_iter().filter(|s| (0.0..=1.0).contains(s));
    within.map(|s| (ax + s * dx).abs().max((ay + s * dy).abs())).fold(f64::INFINITY, f64::min)
}

#[test]
fn exact_answers_and_distances() {
    let p = |x: f64, y: f64, z: f64| point([x, y, z].map(Toy::<14>::from_f64));
    let triangle = [p(0.0, 0.0, 1.0), p(1.0, 0.0, 1.0), p(0.0, 1.0, 1.0)];
    let down = p(0.0, 0.0, -1.0);
    for (o, expected, distance) in [
        (p(0.25, 0.25, 2.0), Answer::Hit, 0.25),
        (p(0.5, 0.5, 1.0), Answer::Hit, 0.0),
        (p(0.25, 0.25, 0.5), Answer::Miss, 0.25),
        (p(1.0, 1.0, 2.0), Answer::Miss, 0.5),
        (p(-0.5, 0.5, 2.0), Answer::Miss, 0.5),
    ] {
        assert_eq!(answer(triangle, o, down), expected, "{o:?}");
        assert_eq!(across(triangle, o, down), distance, "{o:?}");
    }
    assert_eq!(height(triangle, p(9.0, 3.0, -1.5)), 2.5);
    assert_eq!(answer(triangle, p(0.0, 0.0, 1.0), p(1.0, 1.0, 0.0)), Answer::Flat);
}
