//! A triangle test for libraries that leave it to their users: Moeller and Trumbore's, of both sides, without an
//! epsilon.

use std::ops::{Add, Div, Mul, Sub};

use crate::{Ray, Real, Triangle};

/// A number type with arithmetic: `f32` or `f64`.
pub trait Number:
    Real
    + PartialOrd
    + From<f32>
    + Into<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
}

impl Number for f32 {}
impl Number for f64 {}

type Vector<T> = [T; 3];

/// The parameter of the hit, if there is one from `t_min` to `t_max`.
#[inline(always)]
pub fn intersect<T: Number>([a, b, c]: &Triangle<T>, ray: &Ray<T>, t_max: T) -> Option<T> {
    let [zero, one] = [0.0, 1.0].map(T::from);
    let (ab, ac) = (minus(b, a), minus(c, a));
    let p = cross(&ray.direction, &ac);
    let determinant = dot(&ab, &p);
    if determinant == zero {
        return None;
    }
    let inverse = one / determinant;
    let from_a = minus(&ray.origin, a);
    let u = dot(&from_a, &p) * inverse;
    let q = cross(&from_a, &ab);
    let v = dot(&ray.direction, &q) * inverse;
    // a NaN is outside
    if !(u >= zero && v >= zero && u + v <= one) {
        return None;
    }
    let t = dot(&ac, &q) * inverse;
    (t >= ray.t_min && t <= t_max).then_some(t)
}

#[inline(always)]
fn minus<T: Number>(a: &Vector<T>, b: &Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<T: Number>(a: &Vector<T>, b: &Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<T: Number>(a: &Vector<T>, b: &Vector<T>) -> Vector<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
