//! Rays from far away, and rays of extreme lengths, brought to common sizes before anything else
//! looks at them.
//!
//! A ray that starts a thousand scene sizes away has lost the digits that tell cells apart, and
//! every structure would lose them in a way of its own. So its origin is first moved along the ray
//! to just before the scene, once, for all structures and the brute-force oracle alike; a ray that
//! passes the scene at a distance, or whose interval does, is a miss at once. (Our own remedy; the
//! loss is case R6 of the hard cases.) Its interval becomes the parameters that are told as ones
//! within it.
//!
//! A direction so long or so short that its reciprocal, or a parameter, loses digits to subnormal
//! numbers or overflows is multiplied by a power of two first, and the parameters are divided by
//! it. So the primitive is found whatever the length; where the parameter itself cannot be told in
//! the scalar, it is the nearest that can, zero and infinity included.

use crate::geometry::lanes::{Eight, Lanes};
use crate::geometry::ray::Ray;
use crate::geometry::ray_lanes::{LANES, RayLanes};
use crate::geometry::scalar::{EightOf, Scalar, Vector};

/// Where a query should start.
#[derive(Debug, Clone, Copy)]
pub enum PlacedRay<S: Scalar> {
    /// Where the ray starts.
    Near,
    /// On this ray, whose parameters differ.
    Moved(Ray<S>, Parameters<S>),
    /// It cannot hit anything, or is no ray at all.
    Nowhere,
}

/// How the parameters of a ray become those of the ray it was made from.
#[derive(Debug, Clone, Copy)]
pub struct Parameters<S> {
    smaller_by: S,
    factor: S,
}

impl<S: Scalar> Parameters<S> {
    /// The identity: parameters of the ray itself.
    pub const SAME: Self = Self { smaller_by: S::ZERO, factor: S::ONE };

    /// The parameter on the ray it was made from.
    #[inline(always)]
    pub fn restored(&self, t: S) -> S {
        (t + self.smaller_by) * self.factor
    }

    /// The least and the largest parameter that are restored to one within the interval. Far away
    /// many are restored to the same: what is hit at a parameter that was told is hit again in an
    /// interval that begins or ends there.
    fn interval(&self, t_min: S, t_max: S) -> [S; 2] {
        let first = if t_min == -S::INFINITY { t_min } else { self.least(t_min, |t| t >= t_min) };
        let last = if t_max == S::INFINITY {
            t_max
        } else {
            self.least(t_max.next_up(), |t| t > t_max).next_down()
        };
        [first, last]
    }

    /// The least parameter whose restored one meets a condition, which holds from `from` on.
    fn least(&self, from: S, holds: impl Fn(S) -> bool) -> S {
        let guess = from * (S::ONE / self.factor) - self.smaller_by;
        let is_met = |t: S| holds(self.restored(t));
        if is_met(guess) && !is_met(guess.next_down()) {
            return guess;
        }
        let of = |key: i128| S::from_f64(from_key(key as i64));
        let [mut low, mut high] = [-f64::INFINITY, f64::INFINITY].map(|x| i128::from(to_key(x)));
        while high - low > 1 {
            let middle = low.midpoint(high);
            *(if is_met(of(middle)) { &mut high } else { &mut low }) = middle;
        }
        of(high)
    }
}

/// Maps floating-point numbers to integers in the same order.
fn to_key(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

fn from_key(key: i64) -> f64 {
    f64::from_bits((key ^ (((key >> 63) as u64) >> 1) as i64) as u64)
}

/// Origins within this many magnitudes of the scene on every axis are near: `proofs/` has them, in
/// corners, parameter, voxel_planes, box_clip and sphere (`.gappa`).
const NEAR: f64 = 8.0;

/// The largest coordinate of a near origin, for a scene whose largest coordinate is `magnitude`.
pub fn reach<S: Scalar>(magnitude: S) -> S {
    magnitude * S::from_f64(NEAR)
}

#[inline(always)]
pub fn place<S: Scalar>(ray: &Ray<S>, reach: S) -> PlacedRay<S> {
    let [x, y, z] = ray.origin.to_array();
    // NaN fails all comparisons
    let is_near = (x.abs() <= reach) & (y.abs() <= reach) & (z.abs() <= reach);
    if is_near & has_common_length(ray) & (ray.t_min <= ray.t_max) {
        PlacedRay::Near
    } else {
        place_of_other(ray, reach)
    }
}

/// Whether [`place`] finds all of them [near](PlacedRay::Near), and none begins before its origin.
#[inline(always)]
pub fn are_near<S: Scalar>(rays: &RayLanes<S>, reach: S) -> bool {
    let (vector, splat) = (EightOf::<S>::new, EightOf::<S>::splat);
    let absolute = |lanes: [S; LANES]| vector(lanes).absolute();
    let is_within = |lanes: [S; LANES]| absolute(lanes).at_most(splat(reach));
    let ([x, y, z], [dx, dy, dz]) = (rays.origin, rays.direction);
    let length = absolute(dx) + absolute(dy) + absolute(dz);
    let [least, most] = S::DIRECTION_LENGTHS.map(splat);
    let t_min = vector(rays.t_min);
    // NaN fails all comparisons
    let near = is_within(x)
        & is_within(y)
        & is_within(z)
        & least.at_most(length)
        & length.at_most(most)
        & t_min.at_most(vector(rays.t_max))
        & splat(S::ZERO).at_most(t_min);
    near.high_bits() == (1 << LANES) - 1
}

#[inline(always)]
fn has_common_length<S: Scalar>(ray: &Ray<S>) -> bool {
    // a sum: infinity and NaN show in it
    let [x, y, z] = ray.direction.to_array();
    let length = x.abs() + y.abs() + z.abs();
    (length >= S::DIRECTION_LENGTHS[0]) & (length <= S::DIRECTION_LENGTHS[1])
}

/// Places a ray that is not near, has an uncommon length, or is invalid.
#[cold]
#[inline(never)]
fn place_of_other<S: Scalar>(ray: &Ray<S>, reach: S) -> PlacedRay<S> {
    if !ray.is_traceable() {
        return PlacedRay::Nowhere;
    }
    let factor = if has_common_length(ray) { S::ONE } else { ray.unit_factor() };
    let common = Ray { direction: ray.direction * factor, ..*ray };
    let Some((origin, smaller_by)) = moved(&common, reach, factor) else {
        return PlacedRay::Nowhere;
    };
    let parameters = Parameters { smaller_by, factor };
    let [t_min, t_max] = parameters.interval(ray.t_min, ray.t_max);
    if t_min <= t_max {
        PlacedRay::Moved(Ray { origin, t_min, t_max, ..common }, parameters)
    } else {
        PlacedRay::Nowhere
    }
}

/// Origin near the scene, and the difference of ray parameters there; `None` if the ray, or its
/// interval (that of its direction over `factor`), misses the scene.
fn moved<S: Scalar>(ray: &Ray<S>, reach: S, factor: S) -> Option<(crate::Vec3<S>, S)> {
    let [x, y, z] = ray.origin.to_array();
    if x.abs() <= reach && y.abs() <= reach && z.abs() <= reach {
        return Some((ray.origin, S::ZERO));
    }
    // in f64: far origins overflow the squares of f32
    let (o, d) = (ray.origin.to_dvec3(), ray.direction.to_dvec3());
    let length = d.length();
    let unit = d / length;
    let along = -o.dot(unit);
    let passing = (o + unit * along).length();
    // the scene lies in a ball of sqrt(3) magnitudes; 2 leaves room for rounding
    let radius = reach.to_f64() * (2.0 / NEAR);
    let slack = along.abs() * S::EPSILON.to_f64() * 4.0;
    let [first, last] = [ray.t_min, ray.t_max].map(|t| t.to_f64() / factor.to_f64() * length);
    let room = radius + slack;
    if passing > room || last < along - room || first > along + room {
        return None;
    }
    let by = S::from_f64((along - 1.5 * radius) / length);
    // one rounding: the product alone may be far larger than the scene
    let moved = [0, 1, 2].map(|k| d[k].mul_add(by.to_f64(), o[k]));
    Some((crate::Vec3::<S>::from_dvec3(moved.into()), by))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::scalar::Vec3;
    use crate::structures::test_scenes::Random;

    fn ray(o: [f32; 3], d: [f32; 3]) -> Ray<f32> {
        Ray::new(o.into(), d.into())
    }

    fn is_lost(ray: &Ray<f32>) -> bool {
        matches!(place(ray, reach(1.0)), PlacedRay::Nowhere)
    }

    #[test]
    fn near_far_and_lost() {
        let reach = reach(1.0f32);
        assert!(matches!(place(&ray([7.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), reach), PlacedRay::Near));
        let PlacedRay::Moved(near, by) = place(&ray([-1e6, 0.5, 0.0], [2.0, 0.0, 0.0]), reach)
        else {
            panic!("not moved")
        };
        assert!((near.origin.x + 3.0).abs() < 0.1 && near.origin.y == 0.5);
        assert!((by.restored(0.0) - 5e5).abs() < 2.0 && near.t_min < 0.0);
        for lost in [
            ray([-1e6, 0.0, 0.0], [-1.0, 0.0, 0.0]),
            ray([-1e6, 100.0, 0.0], [1.0, 0.0, 0.0]),
            ray([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ray([f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ] {
            assert!(is_lost(&lost), "{lost:?}");
        }
        let mut window = ray([-1e6, 0.5, 0.0], [1.0, 0.0, 0.0]);
        (window.t_min, window.t_max) = (f32::NAN, 1.0);
        assert!(is_lost(&window));
        // extreme but finite numbers neither overflow nor hang
        for x in [1e30f32, 3e38] {
            assert!(!matches!(place(&ray([-x, 0.0, 0.0], [x, 0.0, 0.0]), reach), PlacedRay::Near));
        }
    }
    #[test]
    fn directions_of_any_length_are_the_same_ray() {
        let reach = reach(1.0f32);
        for length in [1e-45f32, 1e-40, 1e-20, 1e20, 3e38] {
            for from in [-3.0, -1e6] {
                let mut query = ray([from, 0.0, 0.0], [length, -length, 0.0]);
                query.t_max = 8.0 / length;
                if from < -100.0 {
                    // it must pass near the scene, and reach it
                    query.origin.y = -from;
                    query.t_max = f32::INFINITY;
                }
                let PlacedRay::Moved(near, parameters) = place(&query, reach) else {
                    panic!("{query:?}")
                };
                let d = near.direction;
                assert!(d.x == -d.y && d.z == 0.0 && (1e-9..4.0).contains(&d.x), "{near:?}");
                if from == -3.0 {
                    let t = parameters.restored(3.0 / d.x);
                    assert!((t / (3.0 / length) - 1.0).abs() < 1e-6 || !t.is_normal(), "{t}");
                    assert!(near.t_max / (8.0 / d.x) > 0.999_99);
                }
            }
        }
        let zero = ray([0.0; 3], [0.0, -0.0, 0.0]);
        assert!(is_lost(&zero));
        let endless = ray([0.0; 3], [f32::INFINITY, 1.0, 0.0]);
        assert!(is_lost(&endless));
    }

    /// A hit at a parameter lies in exactly the intervals that contain that parameter.
    fn intervals_are_closed<S: Scalar>() {
        let mut random = Random(21);
        let reach = reach(S::ONE);
        let (mut asked, mut shifted) = (0, 0);
        for i in 0..2000 {
            let mut point = |size: f64| random.point([2.0 * size; 3]) - glam::DVec3::splat(size);
            let target = point(0.9);
            let far = point(1.0) * [1e2, 1e4, 1e6, 1e9][i % 4];
            let sizes = [1.0, 1.0, 0.3, 1e-25, 1e25, 1e-41].map(|x: f64| x.max(1e-300));
            let size = sizes[i / 4 % 6];
            let sign = if i % 3 == 0 { -1.0 } else { 1.0 };
            let d = Vec3::<S>::from_dvec3((target - far) * (sign * size / far.length()));
            let mut ray = Ray::new(Vec3::<S>::from_dvec3(far), d);
            if !ray.is_traceable() {
                continue;
            }
            ray.t_min = -S::INFINITY;
            let PlacedRay::Moved(near, parameters) = place(&ray, reach) else { continue };
            let length = near.direction.length().to_f64();
            let t = S::from_f64((1.5 + 3.0 * random.unit()) / length);
            let told = parameters.restored(t);
            if !told.is_finite() {
                continue;
            }
            let holds = |t_min: S, t_max: S| match place(&Ray { t_min, t_max, ..ray }, reach) {
                PlacedRay::Moved(near, of_part) => {
                    assert_eq!(of_part.restored(t).to_f64(), told.to_f64());
                    near.t_min <= t && t <= near.t_max
                }
                _ => false,
            };
            let [none, all] = [-S::INFINITY, S::INFINITY];
            assert!(holds(told, told) && holds(none, told) && holds(told, all), "{ray:?} {t}");
            let [above, below] = [told.next_up(), told.next_down()];
            assert!(!holds(above, all) && !holds(none, below), "{ray:?} {t}");
            assert!(holds(below, above), "{ray:?} {t}");
            // planted fault: the interval moved as the origin is
            let by = parameters.smaller_by;
            shifted += usize::from(told * (S::ONE / parameters.factor) - by < t);
            asked += 1;
        }
        assert!(asked > 1000 && shifted > 100, "{} {asked} {shifted}", S::NAME);
    }

    #[test]
    fn intervals_contain_the_reported_parameters() {
        intervals_are_closed::<f32>();
        intervals_are_closed::<f64>();
    }

    #[test]
    fn the_scene_behind_a_far_origin_is_found() {
        let reach = reach(1.0f32);
        let mut query = ray([1e6, 0.5, 0.0], [2.0, 0.0, 0.0]);
        assert!(is_lost(&query));
        query.t_min = -1e6;
        let PlacedRay::Moved(near, by) = place(&query, reach) else { panic!("not moved") };
        assert!((near.origin.x + 3.0).abs() < 0.1, "{near:?}");
        assert!((by.restored(1.5) + 5e5).abs() < 2.0 && near.t_max == f32::INFINITY);
        query.t_max = -6e5;
        assert!(is_lost(&query));
    }

    fn lanes_agree<S: Scalar>() {
        let mut random = Random(9);
        let reach = S::from_f64(8.0);
        let special = [f64::NAN, f64::INFINITY, -9.0, 1e30, -1e-30, -0.5, 0.0];
        let (mut near, mut others) = (0, 0);
        for round in 0..4000 {
            let mut rays: [Ray<S>; LANES] = std::array::from_fn(|_| {
                let mut point = |size: f64| {
                    let axis = [0; 3].map(|_| S::from_f64((random.unit() - 0.5) * size));
                    Vec3::<S>::from_array(axis)
                };
                let (origin, direction) = (point(15.9), point(2.0));
                Ray { t_max: S::from_f64(2.0), ..Ray::new(origin, direction) }
            });
            if round % 4 > 0 {
                let ray = &mut rays[round % LANES];
                let x = S::from_f64(special[round % special.len()]);
                match round % 5 {
                    0 => ray.origin = Vec3::<S>::new(ray.origin.to_array()[1], x, S::ZERO),
                    1 => ray.direction = Vec3::<S>::new(x, S::ONE, x),
                    2 => ray.t_min = x,
                    3 => ray.t_max = x,
                    _ => ray.direction = Vec3::<S>::splat(x),
                }
            }
            let is_near = |ray: &Ray<S>| matches!(place(ray, reach), PlacedRay::Near);
            let expected = rays.iter().all(|ray| is_near(ray) && ray.t_min >= S::ZERO);
            assert_eq!(are_near(&RayLanes::of(&rays), reach), expected, "{rays:?}");
            near += u32::from(expected);
            others += u32::from(!expected);
        }
        assert!(near > 1000 && others > 1000, "{near} {others}");
    }

    #[test]
    fn rays_in_lanes_are_near_where_all_of_them_are() {
        lanes_agree::<f32>();
        lanes_agree::<f64>();
    }
}
