//! Writes the lists of the parts; a list is shared by the cells that have it.

use crate::geometry::scalar::Scalar;
use crate::primitives::{PrimSet, TriangleBlock, blocks};
use crate::query::lists::Lists;
use crate::structures::irregular_grid::cells::{Cells, DIVIDED};

/// Where the blocks of a list begin.
struct Run {
    list: u32,
    first: usize,
}

/// Writes the blocks of all these lists; `blocks` begins with block `first`.
fn write_all<B: Send>(
    runs: &[Run],
    first: usize,
    blocks: &mut [B],
    write: &(impl Fn(&Run, &mut [B]) + Sync),
) {
    if runs.len() < 512 {
        for run in runs {
            write(run, &mut blocks[run.first - first..]);
        }
        return;
    }
    let (before, after) = runs.split_at(runs.len() / 2);
    let middle = after[0].first;
    let (low, high) = blocks.split_at_mut(middle - first);
    rayon::join(|| write_all(before, first, low, write), || write_all(after, middle, high, write));
}

/// The lists of all cells, which get their numbers. Blocks where all primitives are triangles
/// at rest, and not too many.
pub(super) fn of_cells<S: Scalar, P: PrimSet<S>>(cells: &mut Cells, prims: &P) -> Lists<S> {
    if blocks::serve(prims)
        && let Some((runs, n)) = number::<S>(cells)
    {
        return Lists::Blocks(blocks_of(cells, prims, &runs, n));
    }
    Lists::Ids(std::mem::take(&mut cells.lists))
}

/// Numbers the blocks of all lists, the first being that of the empty one: where each list's
/// begin, and how many there are. `None` when there are too many for their numbers.
fn number<S: Scalar>(cells: &mut Cells) -> Option<(Vec<Run>, usize)> {
    // the first block of the list that begins at that place
    let mut known = vec![0u32; cells.lists.len()];
    let mut runs: Vec<Run> = Vec::new();
    let mut next = 1u32;
    for cell in cells.cells.iter().filter(|cell| cell.list != 0) {
        let first = &mut known[cell.list as usize];
        if *first == 0 {
            *first = next;
            runs.push(Run { list: cell.list, first: next as usize });
            let blocks = blocks::number_of::<S>(cells.list(cell.list).len());
            let after = u32::try_from(blocks).ok().and_then(|n| next.checked_add(n));
            next = after.filter(|next| next & DIVIDED == 0)?;
        }
    }
    for cell in &mut cells.cells {
        cell.list = known[cell.list as usize];
    }
    Some((runs, next as usize))
}

fn blocks_of<S: Scalar, P: PrimSet<S>>(
    cells: &Cells,
    prims: &P,
    runs: &[Run],
    n: usize,
) -> Vec<TriangleBlock<S>> {
    let mut all = vec![TriangleBlock::new(std::iter::empty(), false); n];
    let write = |run: &Run, into: &mut [TriangleBlock<S>]| {
        for (block, into) in blocks::of_list(prims, cells.list(run.list)).zip(into) {
            *into = block;
        }
    };
    write_all(runs, 1, &mut all[1..], &write);
    all
}
