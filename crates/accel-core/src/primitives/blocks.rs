//! Lists of primitives as blocks of triangles.

use std::mem::MaybeUninit;

use crate::geometry::scalar::{Scalar, Vector};
use crate::primitives::prim_set::{IdSet, Primitives};
use crate::primitives::triangle::prefetch_triangle;
use crate::primitives::triangle_block::TriangleBlock;

/// Returns whether blocks can stand for lists of this set: all its primitives are triangles under
/// the watertight test, and not too many.
pub(crate) fn serve<S: Scalar>(prims: &dyn Primitives<S>) -> bool {
    prims.len() <= TriangleBlock::<S>::MOST_IDS
        && (prims.is_watertight()
            || (0..prims.len() as u32).all(|id| prims.corners_in_block(id).is_some()))
}

/// Blocks that a list of so many primitives takes.
pub(crate) fn number_of<S: Scalar>(primitives: usize) -> usize {
    primitives.div_ceil(TriangleBlock::<S>::LANES)
}

/// Blocks of the list that begins with the first of these.
pub(crate) fn length<S: Scalar>(blocks: &[TriangleBlock<S>]) -> usize {
    (blocks.iter().take_while(|block| block.has_next()).count() + 1).min(blocks.len())
}

/// Makes an empty block that of these primitives.
#[inline(always)]
fn fill<S: Scalar>(
    prims: &dyn Primitives<S>,
    ids: &[u32],
    more: bool,
    into: &mut TriangleBlock<S>,
) {
    let corners = |&id| Some((id, prims.corners_in_block(id)?.map(|p| p.to_array())));
    into.fill(ids.iter().filter_map(corners), more, prims.move_as_one(ids));
}

/// Adds the blocks of a list, in its order.
pub(crate) fn push_list<S: Scalar>(
    prims: &dyn Primitives<S>,
    ids: &[u32],
    into: &mut Vec<TriangleBlock<S>>,
) {
    let first = into.len();
    into.resize(first + number_of::<S>(ids.len()), TriangleBlock::empty());
    set_list(prims, ids, &mut into[first..]);
}

/// Makes the first of these the blocks of a list, in its order.
pub(crate) fn set_list<S: Scalar>(
    prims: &dyn Primitives<S>,
    ids: &[u32],
    into: &mut [TriangleBlock<S>],
) {
    for (block, (part, more)) in into.iter_mut().zip(parts::<S>(ids)) {
        *block = TriangleBlock::empty();
        fill(prims, part, more, block);
    }
}

/// The ids of each block of a list, and whether another follows.
fn parts<S: Scalar>(ids: &[u32]) -> impl Iterator<Item = (&[u32], bool)> {
    let last = number_of::<S>(ids.len()).saturating_sub(1);
    ids.chunks(TriangleBlock::<S>::LANES).enumerate().map(move |(i, part)| (part, i < last))
}

/// Makes blocks anew of the same primitives, of which some have moved.
pub(crate) fn refresh<S: Scalar>(
    prims: &dyn Primitives<S>,
    blocks: &mut [TriangleBlock<S>],
    moved: &IdSet,
) {
    for block in blocks {
        let (ids, n) = block.ids();
        if !ids[..n].iter().any(|&id| moved.contains(id)) {
            continue;
        }
        let more = block.has_next();
        *block = TriangleBlock::empty();
        fill(prims, &ids[..n], more, block);
    }
}

/// So many empty blocks, then those of lists, one list after the other; made by the threads of the
/// current rayon pool.
pub(crate) fn of_lists<S: Scalar>(
    prims: &dyn Primitives<S>,
    empty: usize,
    lists: &[&[u32]],
) -> Vec<TriangleBlock<S>> {
    let number: usize = lists.iter().map(|list| number_of::<S>(list.len())).sum();
    let mut all = Vec::with_capacity(empty + number);
    all.resize(empty, TriangleBlock::empty());
    let into = &mut all.spare_capacity_mut()[..number];
    // what is known to be triangles is copied without a call for each
    match prims.triangles() {
        Some(triangles) => {
            let fill = |ids: &[u32], more, into: &mut TriangleBlock<S>| {
                into.fill(ids.iter().map(|&id| (id, triangles[id as usize])), more, true);
            };
            let prefetch = |id: u32| prefetch_triangle(&triangles[id as usize]);
            write(&(fill, prefetch), lists, into);
        }
        None => {
            let fill = |ids: &[u32], more, into: &mut _| fill(prims, ids, more, into);
            write(&(fill, |_| ()), lists, into);
        }
    }
    // SAFETY: `write` has written each of them
    unsafe { all.set_len(empty + number) };
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

/// The triangles of a list are asked for so many lists before it is written.
const AHEAD: usize = 4;

/// Writes the blocks of the lists, of which there are as many: makes each that of ids, and asks for
/// the memory of those that follow soon.
fn write<S: Scalar>(
    by: &(impl Fn(&[u32], bool, &mut TriangleBlock<S>) + Sync, impl Fn(u32) + Sync),
    lists: &[&[u32]],
    into: &mut [MaybeUninit<TriangleBlock<S>>],
) {
    let (fill, prefetch) = by;
    if lists.len() < 512 {
        let (blocks, mut written) = (into.len(), 0);
        let (mut slots, mut soon) = (into.iter_mut(), lists.iter().skip(AHEAD));
        for list in lists {
            soon.next().into_iter().copied().flatten().for_each(|&id| prefetch(id));
            for ((part, more), slot) in parts::<S>(list).zip(&mut slots) {
                fill(part, more, slot.write(TriangleBlock::empty()));
                written += 1;
            }
        }
        assert_eq!(written, blocks);
        return;
    }
    let (before, after) = lists.split_at(lists.len() / 2);
    let middle = before.iter().map(|list| number_of::<S>(list.len())).sum();
    let (low, high) = into.split_at_mut(middle);
    rayon::join(|| write(by, before, low), || write(by, after, high));
}
