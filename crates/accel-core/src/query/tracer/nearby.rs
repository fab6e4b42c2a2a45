//! Rays that begin far away are brought near before a structure sees them.

use crate::geometry::far_ray::{self, Parameters, PlacedRay};
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::query::mailbox::MailboxSource;

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

/// Calls `query` with the ray, brought near, and what its parameters became.
#[inline(always)]
pub(crate) fn near<S: Scalar, R>(
    reach: S,
    ray: &Ray<S>,
    nowhere: R,
    query: impl FnOnce(&Ray<S>, Parameters<S>) -> R,
) -> R {
    match rebase_origin(ray, reach, &mut None) {
        Some((near, parameters)) => query(near, parameters),
        None => nowhere,
    }
}

/// Closest hits with one kind of mailbox; `one` asks for one of them.
#[inline(always)]
pub(crate) fn closest<S: Scalar, B: MailboxSource>(
    reach: S,
    rays: &[Ray<S>],
    hits: &mut [Hit<S>],
    mut mailboxes: B,
    mut one: impl for<'r> FnMut(&'r Ray<S>, B::Mailbox<'_>) -> Hit<S>,
) {
    for (ray, hit) in rays.iter().zip(hits) {
        let miss = Hit { t: ray.t_max, ..Hit::NONE };
        *hit = near(reach, ray, miss, |near, parameters| {
            let found = one(near, mailboxes.next_ray());
            if found.is_hit() { Hit { t: parameters.restored(found.t), ..found } } else { miss }
        });
    }
}
