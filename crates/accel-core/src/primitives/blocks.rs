//! Lists of primitives as blocks of triangles.

use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::prim_set::PrimSet;
use crate::primitives::triangle_block::TriangleBlock;

/// Whether blocks can stand for lists of this set: all its primitives are triangles at rest under the
/// watertight test, and not too many.
pub(crate) fn serve<S: Scalar, P: PrimSet<S>>(prims: &P) -> bool {
    prims.is_watertight()
        && prims.len() <= TriangleBlock::<S>::MOST_IDS
        && (0..prims.len() as u32).all(|id| prims.corners(id).is_some())
}

/// Blocks that a list of so many primitives takes.
pub(crate) fn number_of<S: Scalar>(primitives: usize) -> usize {
    primitives.div_ceil(TriangleBlock::<S>::LANES)
}

/// The blocks of a list, in its order.
pub(crate) fn of_list<'a, S: Scalar, P: PrimSet<S>>(
    prims: &'a P,
    ids: &'a [u32],
) -> impl ExactSizeIterator<Item = TriangleBlock<S>> + 'a {
    let corners = |id| prims.corners(id).map(|corners| corners.map(|p| p.to_array()));
    let last = number_of::<S>(ids.len()).saturating_sub(1);
    ids.chunks(TriangleBlock::<S>::LANES).enumerate().map(move |(i, part)| {
        TriangleBlock::new(part.iter().filter_map(|&id| Some((id, corners(id)?))), i < last)
    })
}
