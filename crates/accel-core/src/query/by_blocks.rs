//! A structure whose lists are [blocks](crate::query::kernel): how they are made, and how a ray is
//! traced.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::memory::{Limits, OutOfMemory};
use crate::primitives::PrimSet;
use crate::query::kernel::{BlockSink, ListBlocks};
use crate::query::sink::Sink;
use crate::structure::Structure;

/// The lists of a structure over this set, where it has lists and blocks serve the set.
///
/// # Errors
/// [`OutOfMemory`] where memory does not allow them.
pub(crate) fn of_structure<S: Scalar, P: PrimSet<S>, T: Structure<S>>(
    prims: &P,
    structure: &T,
    limits: Limits,
) -> Result<Option<ListBlocks<S>>, OutOfMemory> {
    if !T::HAS_LISTS {
        return Ok(None);
    }
    let mut lists = Vec::new();
    structure.lists(&mut |list| lists.push(list));
    limits.fits(ListBlocks::<S>::bytes_for(&lists))?;
    Ok(ListBlocks::of(prims, &lists))
}

/// [`Structure::traverse`] of a ray, with the blocks in place of the lists.
#[inline(always)]
pub(crate) fn traverse<S: Scalar, T: Structure<S>, K: Sink<S>>(
    structure: &T,
    blocks: &ListBlocks<S>,
    ray: &Ray<S>,
    sink: &mut K,
) {
    structure.traverse(ray, &mut BlockSink::new(blocks, sink));
}
