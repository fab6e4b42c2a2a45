//! Rays that begin far away are brought near before a structure sees them.

use crate::geometry::far_ray::{self, Parameters, PlacedRay};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::query::sink::Answer;

/// The ray, or the one that it was brought near as, kept in `moved`, and what its parameters
/// became; none where it cannot hit anything.
#[inline(always)]
pub(crate) fn rebase_origin<'r, S: Scalar>(
    ray: &'r Ray<S>,
    reach: S,
    moved: &'r mut Option<Ray<S>>,
) -> Option<(&'r Ray<S>, Parameters<S>)> {
    match far_ray::place(ray, reach) {
        PlacedRay::Near => Some((ray, Parameters::SAME)),
        PlacedRay::Moved(near, parameters) => Some((moved.insert(near), parameters)),
        PlacedRay::Nowhere => None,
    }
}

/// Answers each ray by what `one` says of the ray, brought near.
#[inline(always)]
pub(crate) fn each_near<S: Scalar, A: Answer<S>>(
    reach: S,
    rays: &[Ray<S>],
    answers: &mut [A],
    mut one: impl FnMut(&Ray<S>) -> A,
) {
    for (ray, answer) in rays.iter().zip(answers) {
        let found = match rebase_origin(ray, reach, &mut None) {
            Some((near, parameters)) => one(near).restored(parameters),
            None => None,
        };
        *answer = found.unwrap_or_else(|| A::miss(ray));
    }
}
