//! A triangle test for libraries that leave it to their users: Moeller and Trumbore's, of both sides, without an
//! epsilon.

use crate::{Ray, Triangle};

type Vector = [f32; 3];

/// The parameter of the hit, if there is one from `t_min` to `t_max`.
#[inline(always)]
pub fn intersect([a, b, c]: &Triangle, ray: &Ray, t_max: f32) -> Option<f32> {
    let (ab, ac) = (minus(b, a), minus(c, a));
    let p = cross(&ray.direction, &ac);
    let determinant = dot(&ab, &p);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let from_a = minus(&ray.origin, a);
    let u = dot(&from_a, &p) * inverse;
    let q = cross(&from_a, &ab);
    let v = dot(&ray.direction, &q) * inverse;
    // a NaN is outside
    if !(u >= 0.0 && v >= 0.0 && u + v <= 1.0) {
        return None;
    }
    let t = dot(&ac, &q) * inverse;
    (t >= ray.t_min && t <= t_max).then_some(t)
}

#[inline(always)]
fn minus(a: &Vector, b: &Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: &Vector, b: &Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
