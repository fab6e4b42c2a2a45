//! Lists of primitives as blocks of triangles.

use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::prim_set::PrimSet;
use crate::primitives::triangle_block::TriangleBlock;
use crate::update::MovedIds;

/// Whether blocks can stand for lists of this set: all its primitives are triangles under the watertight
/// test, and not too many.
pub(crate) fn serve<S: Scalar, P: PrimSet<S>>(prims: &P) -> bool {
    prims.len() <= TriangleBlock::<S>::MOST_IDS
        && (0..prims.len() as u32).all(|id| prims.corners_in_block(id).is_some())
}

/// Blocks that a list of so many primitives takes.
pub(crate) fn number_of<S: Scalar>(primitives: usize) -> usize {
    primitives.div_ceil(TriangleBlock::<S>::LANES)
}

/// Blocks of the list that begins with the first of these.
pub(crate) fn length<S: Scalar>(blocks: &[TriangleBlock<S>]) -> usize {
    (blocks.iter().take_while(|block| block.has_next()).count() + 1).min(blocks.len())
}

/// The blocks of a list, in its order.
pub(crate) fn of_list<'a, S: Scalar, P: PrimSet<S>>(
    prims: &'a P,
    ids: &'a [u32],
) -> impl ExactSizeIterator<Item = TriangleBlock<S>> + 'a {
    let corners = |id| prims.corners_in_block(id).map(|corners| corners.map(|p| p.to_array()));
    let last = number_of::<S>(ids.len()).saturating_sub(1);
    ids.chunks(TriangleBlock::<S>::LANES).enumerate().map(move |(i, part)| {
        TriangleBlock::new(part.iter().filter_map(|&id| Some((id, corners(id)?))), i < last)
            .moving(prims.move_as_one(part))
    })
}

/// Makes blocks anew of the same primitives, of which some have moved.
pub(crate) fn refresh<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    blocks: &mut [TriangleBlock<S>],
    moved: &MovedIds,
) {
    for block in blocks {
        let (ids, n) = block.ids();
        if !ids[..n].iter().any(|&id| moved.has(id)) {
            continue;
        }
        let corners = |id| Some((id, prims.corners_in_block(id)?.map(|p| p.to_array())));
        *block =
            TriangleBlock::new(ids[..n].iter().filter_map(|&id| corners(id)), block.has_next())
                .moving(prims.move_as_one(&ids[..n]));
    }
}

/// So many empty blocks, then those of lists, one list after the other; made by the threads of the
/// current rayon pool.
pub(crate) fn of_lists<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    empty: usize,
    lists: &[&[u32]],
) -> Vec<TriangleBlock<S>> {
    let number: usize = lists.iter().map(|list| number_of::<S>(list.len())).sum();
    let mut all = vec![TriangleBlock::new(std::iter::empty(), false); empty + number];
    write(prims, lists, &mut all[empty..]);
    all
}

/// Adds the ids of the list that begins with the first of these blocks.
pub(crate) fn ids_of_list<S: Scalar>(blocks: &[TriangleBlock<S>], into: &mut Vec<u32>) {
    for block in blocks {
        let (ids, n) = block.ids();
        into.extend_from_slice(&ids[..n]);
        if !block.has_next() {
            return;
        }
    }
}

fn write<S: Scalar, P: PrimSet<S>>(prims: &P, lists: &[&[u32]], into: &mut [TriangleBlock<S>]) {
    if lists.len() < 512 {
        let blocks = lists.iter().flat_map(|list| of_list(prims, list));
        into.iter_mut().zip(blocks).for_each(|(into, block)| *into = block);
        return;
    }
    let (before, after) = lists.split_at(lists.len() / 2);
    let middle = before.iter().map(|list| number_of::<S>(list.len())).sum();
    let (low, high) = into.split_at_mut(middle);
    rayon::join(|| write(prims, before, low), || write(prims, after, high));
}
