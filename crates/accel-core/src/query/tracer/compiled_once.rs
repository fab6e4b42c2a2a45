//! Traversals that are compiled once for a structure and a scalar, whatever is asked of them.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::query::sink::{ErasedSink, RelayedSink};
use crate::structure::Structure;

/// The traversal of all passes that count.
#[inline(never)]
pub(crate) fn counted<S: Scalar, T: Structure<S>>(
    structure: &T,
    ray: &Ray<S>,
    mut sink: ErasedSink<'_, S>,
) {
    structure.traverse(ray, &mut sink);
}

/// The traversal of passes that are timed, for sets that are not compiled into it.
#[inline(never)]
pub(crate) fn relayed<S: Scalar, T: Structure<S>>(
    structure: &T,
    ray: &Ray<S>,
    mut sink: RelayedSink<'_, S>,
) {
    structure.traverse(ray, &mut sink);
}
