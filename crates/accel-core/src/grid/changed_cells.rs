//! Lists in one array, changed in the cells alone that primitives left or entered.
//!
//! The lists of the other cells are moved as they are, stretch by stretch, so that what an update
//! costs beside a pass over memory grows with what has moved. The lists are those that a build
//! would make.

use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::{CellLists, ListOrder};
use crate::grid::regular_grid::Contents;
use crate::primitives::IdSet;
use crate::update::ChangedLists;

/// The cells that moved primitives are in now.
pub(crate) struct NewCells {
    /// Cell and id, by cell, those of a cell in the order of its list.
    pairs: Vec<(u32, u32)>,
    order: ListOrder,
    max_references: u64,
}

impl NewCells {
    /// Cells of the `moved` primitives; `cell` maps a cell to its list. `None` if there are too
    /// many.
    pub(crate) fn of<S: Scalar>(
        contents: &Contents<S>,
        moved: &[u32],
        mut cell: impl FnMut([i32; 3]) -> usize,
    ) -> Option<Self> {
        let (order, max_references) = (contents.order, contents.max_references);
        let mut pairs = Vec::with_capacity(2 * moved.len());
        for &id in moved {
            contents.cells_of(id, |coords| {
                if pairs.len() as u64 <= max_references {
                    pairs.push((cell(coords) as u32, id));
                }
            });
        }
        if pairs.len() as u64 > max_references {
            return None;
        }
        match order {
            ListOrder::File => pairs.sort_unstable(),
            ListOrder::Reverse => pairs.sort_unstable_by_key(|&(cell, id)| (cell, !id)),
        }
        Some(Self { pairs, order, max_references })
    }
}

impl CellLists {
    /// Takes the `moved` primitives (ascending ids) out of all lists and puts them where they are
    /// `gained`. `None`, and nothing done, where the references become too many.
    pub(crate) fn change(&mut self, moved: &[u32], gained: &NewCells) -> Option<ChangedLists> {
        let moved = IdSet::of(moved);
        let (starts, ids) = (self.starts(), self.ids());
        // ascending: the cells that held one, those that hold one now
        let mut changed: Vec<u32> = Vec::new();
        let mut cell = 0;
        let mut lost = 0;
        for (place, &id) in ids.iter().enumerate() {
            if moved.contains(id) {
                lost += 1;
                // the cell of this place is not before that of the last one
                cell += starts[cell + 1..].partition_point(|&end| end as usize <= place);
                changed.push(cell as u32);
            }
        }
        changed.extend(gained.pairs.iter().map(|&(cell, _)| cell));
        changed.sort_unstable();
        changed.dedup();
        let total = (ids.len() - lost + gained.pairs.len()) as u64;
        if total > gained.max_references.min(u64::from(u32::MAX)) {
            return None;
        }
        let mut all = Vec::with_capacity(total as usize);
        let mut begins = Vec::with_capacity(starts.len());
        let mut pairs = gained.pairs.as_slice();
        let mut next = 0;
        for &number in &changed {
            copy(starts, ids, next..number as usize, &mut begins, &mut all);
            next = number as usize + 1;
            begins.push(all.len() as u32);
            let own = pairs.partition_point(|&(cell, _)| cell <= number);
            let (here, rest) = pairs.split_at(own);
            pairs = rest;
            let list = &ids[starts[number as usize] as usize..starts[next] as usize];
            let stay = list.iter().copied().filter(|&id| !moved.contains(id));
            merge(stay, here.iter().map(|&(_, id)| id), gained.order, &mut all);
        }
        copy(starts, ids, next..starts.len() - 1, &mut begins, &mut all);
        begins.push(all.len() as u32);
        let before = std::mem::replace(self, Self::of_parts(begins, all)).into_parts().0;
        Some(ChangedLists { before, changed })
    }
}

/// Appends the lists of consecutive cells.
fn copy(
    starts: &[u32],
    ids: &[u32],
    cells: std::ops::Range<usize>,
    begins: &mut Vec<u32>,
    all: &mut Vec<u32>,
) {
    let (from, to) = (starts[cells.start], starts[cells.end]);
    let at = all.len() as u32;
    begins.extend(starts[cells].iter().map(|&start| start - from + at));
    all.extend_from_slice(&ids[from as usize..to as usize]);
}

/// Appends both, each in that order, in that order.
fn merge(
    a: impl Iterator<Item = u32>,
    b: impl Iterator<Item = u32>,
    order: ListOrder,
    into: &mut Vec<u32>,
) {
    let (mut a, mut b) = (a.peekable(), b.peekable());
    while let (Some(&x), Some(&y)) = (a.peek(), b.peek()) {
        let is_first = match order {
            ListOrder::File => x < y,
            ListOrder::Reverse => x > y,
        };
        into.push(if is_first { x } else { y });
        if is_first {
            a.next()
        } else {
            b.next()
        };
    }
    into.extend(a);
    into.extend(b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::cell_lists::Placement;

    /// Primitive `i` goes to two or three cells from `self.0[i]` on.
    struct CellOffsets(Vec<usize>);

    impl Placement for CellOffsets {
        fn cells_of(&self, id: u32, emit: impl FnMut(usize)) {
            let first = self.0[id as usize];
            (first..first + 2 + first % 2).for_each(emit);
        }
    }

    #[test]
    fn changed_lists_are_those_of_a_build() {
        const CELLS: usize = 53;
        let place = |i: usize, frame: usize| ((i + 1) * (7919 + frame * 31)) % (CELLS - 3);
        for order in [ListOrder::File, ListOrder::Reverse] {
            let build = |at: &CellOffsets| CellLists::build(CELLS, 200, order, 9999, at).unwrap();
            let mut at = CellOffsets((0..200).map(|i| place(i, 0)).collect());
            let mut lists = build(&at);
            for (frame, stride) in [(1, 1), (2, 50), (3, 7), (4, 300), (5, 3)] {
                let moved: Vec<u32> = (0..200).step_by(stride).collect();
                moved.iter().for_each(|&id| at.0[id as usize] = place(id as usize, frame));
                let mut pairs = Vec::new();
                for &id in &moved {
                    at.cells_of(id, |cell| pairs.push((cell as u32, id)));
                }
                match order {
                    ListOrder::File => pairs.sort_unstable(),
                    ListOrder::Reverse => pairs.sort_unstable_by_key(|&(cell, id)| (cell, !id)),
                }
                let gained = |pairs| NewCells { pairs, order, max_references: 9999 };
                let old = lists.clone();
                let change = lists.change(&moved, &gained(pairs.clone())).unwrap();
                assert_eq!(lists, build(&at), "frame {frame} {order:?}");
                for cell in 0..CELLS {
                    let is_changed = change.changed.contains(&(cell as u32));
                    assert!(is_changed || lists.list(cell) == old.list(cell));
                    assert_eq!(change.had_ids(cell), !old.list(cell).is_empty());
                }
                // planted: the first one is not said to have moved
                let mut wrong = old;
                pairs.retain(|&(_, id)| id != 0);
                wrong.change(&moved[1..], &gained(pairs));
                assert_ne!(wrong, lists, "frame {frame}");
            }
            let too_many = NewCells { pairs: vec![(0, 0); 50], order, max_references: 20 };
            assert!(lists.change(&[0], &too_many).is_none());
            assert_eq!(lists, build(&at));
        }
    }
}
