//! Writes the lists of the parts; a list is shared by the cells that have it.

use crate::geometry::scalar::Scalar;
use crate::primitives::{PrimSet, blocks};
use crate::query::lists::Lists;
use crate::structures::irregular_grid::cells::{Cells, DIVIDED};

/// The lists of all cells, which get their numbers. Blocks where all primitives are triangles
/// at rest, and not too many.
pub(super) fn of_cells<S: Scalar, P: PrimSet<S>>(cells: &mut Cells, prims: &P) -> Lists<S> {
    if blocks::serve(prims)
        && let Some(lists) = number::<S>(cells)
    {
        let lists: Vec<&[u32]> = lists.iter().map(|&list| cells.list(list)).collect();
        return Lists::Blocks(blocks::of_lists(prims, 1, &lists));
    }
    Lists::Ids(std::mem::take(&mut cells.lists))
}

/// Gives cells the numbers that their lists begin with as blocks, the first being that of the empty
/// one: the lists in their order. `None` when there are too many blocks for their numbers.
fn number<S: Scalar>(cells: &mut Cells) -> Option<Vec<u32>> {
    // the first block of the list that begins at that place
    let mut known = vec![0u32; cells.lists.len()];
    let mut lists = Vec::new();
    let mut next = 1u32;
    for cell in cells.cells.iter().filter(|cell| cell.list != 0) {
        let first = &mut known[cell.list as usize];
        if *first == 0 {
            *first = next;
            lists.push(cell.list);
            let blocks = blocks::number_of::<S>(cells.list(cell.list).len());
            let after = u32::try_from(blocks).ok().and_then(|n| next.checked_add(n));
            next = after.filter(|next| next & DIVIDED == 0)?;
        }
    }
    for cell in &mut cells.cells {
        cell.list = known[cell.list as usize];
    }
    Some(lists)
}
