//! The lower level: which resolution each upper cell gets, and the lists of its leaf cells.
//!
//! Upper cells are independent of each other, so they are divided in stretches, one for each
//! thread of the current rayon pool, of about as many references each.

use crate::capacity::CapacityLimits;
use crate::geometry::scalar::Scalar;
use crate::grid::block_lists::rows_in;
use crate::grid::cell_lists::CellLists;
use crate::grid::nested_grids::build::references_in;
use crate::grid::regular_grid::Contents;
use crate::grid::resolution::resolve_by_density;
use crate::grid::voxel_traversal::{CellDivision, GridFrame};
use crate::historical::bounds_rule::smallest_cell;
use crate::parallel::{map, split_mut};
use crate::structure::BuildError;

/// A leaf grid that would list its primitives more often than this on average is made coarser.
const MAX_REFS_PER_PRIM: u64 = 16;

/// A cell of the upper level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct UpperCell {
    /// Its first leaf cell; x is fastest.
    first: u32,
    /// Leaf cells per axis; 0 where it holds no primitive.
    n: [u8; 3],
}

impl UpperCell {
    /// Returns whether it holds a grid.
    #[inline(always)]
    pub fn is_divided(&self) -> bool {
        self.n.iter().any(|&n| n > 1)
    }

    /// Returns whether it holds nothing.
    pub fn is_vacant(&self) -> bool {
        self.n == [0; 3]
    }

    /// Leaf cells per axis.
    #[inline(always)]
    pub fn resolution(&self) -> [u8; 3] {
        self.n
    }

    fn leaf_cells(&self) -> usize {
        self.n.iter().map(|&n| usize::from(n)).product()
    }
}

/// The lists of all leaf cells.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct LeafCells(CellLists);

impl LeafCells {
    /// The ids in a leaf cell of `cell`.
    #[inline(always)]
    pub fn list(&self, cell: &UpperCell, leaf: usize) -> &[u32] {
        self.0.list(cell.first as usize + leaf)
    }

    /// The ids of a cell that is not divided.
    #[inline(always)]
    pub fn only_list(&self, cell: &UpperCell) -> &[u32] {
        if cell.is_vacant() { &[] } else { self.list(cell, 0) }
    }

    /// All of them, in the order of their cells.
    pub fn lists(&self) -> &CellLists {
        &self.0
    }
}

/// The upper cells before their division.
pub(super) struct UpperCells<'a, 'p, S: Scalar> {
    pub contents: &'a Contents<'p, S>,
    pub division: &'a CellDivision<S>,
    /// What each lists.
    pub lists: &'a CellLists,
    /// Leaf cells for each reference of an upper cell.
    pub density: f64,
    /// For the cells of both levels, and the references in leaf cells.
    pub room: CapacityLimits,
}

impl<S: Scalar> UpperCells<'_, '_, S> {
    /// Divides the upper cells.
    ///
    /// # Errors
    /// [`BuildError`] where the limits do not suffice.
    pub(super) fn divide(&self) -> Result<(Vec<UpperCell>, LeafCells), BuildError> {
        let stretches = self.lists.stretches(rayon::current_num_threads());
        let planned: Vec<Vec<_>> =
            map(&stretches, &|cells| cells.clone().map(|cell| self.planned(cell)).collect());
        let mut cells = Vec::with_capacity(self.contents.frame.cells());
        // where the leaf cells and the references of each stretch end
        let (mut ends, mut ends_of) = ([0u64; 2], vec![[0; 2]]);
        for part in planned {
            for (cell, references) in part {
                cells.push(UpperCell { first: ends[0] as u32, ..cell });
                ends = [ends[0] + cell.leaf_cells() as u64, ends[1] + references];
            }
            ends_of.push(ends);
        }
        let [leaf_cells, references] = ends;
        let all_cells = leaf_cells + cells.len() as u64;
        self.room.check([all_cells, 0])?;
        self.room.check([all_cells, references])?;
        let (mut starts, mut ids) =
            (vec![0; leaf_cells as usize + 1], vec![0; references as usize]);
        let lengths = |k: usize| ends_of.windows(2).map(move |at| (at[1][k] - at[0][k]) as usize);
        let pieces = split_mut(&mut starts, lengths(0)).zip(split_mut(&mut ids, lengths(1)));
        let jobs: Vec<_> = stretches.iter().zip(&ends_of).zip(pieces).collect();
        map(jobs, &|((stretch, &[_, before]), (mut starts, mut ids))| {
            let mut before = before as u32;
            for at in stretch.clone() {
                let Some(own) = starts.split_off_mut(..cells[at].leaf_cells()) else { return };
                let filled = self.fill(at, &cells[at], own, ids, before);
                ids = &mut ids[filled..];
                before += filled as u32;
            }
        });
        if let Some(last) = starts.last_mut() {
            *last = references as u32;
        }
        Ok((cells, LeafCells(CellLists::of_parts(starts, ids))))
    }

    /// [`Self::divide`] where the lists of the `changed` upper cells alone (ascending) are others than
    /// before, or hold something that moved: the leaf cells of the others are copied, stretch by
    /// stretch.
    ///
    /// # Errors
    /// As [`Self::divide`].
    pub(super) fn redivide(
        &self,
        (old_cells, old): (&[UpperCell], &LeafCells),
        changed: &[u32],
    ) -> Result<(Vec<UpperCell>, LeafCells), BuildError> {
        let (old_starts, old_ids) = (old.0.starts(), old.0.ids());
        let mut cells: Vec<UpperCell> = Vec::with_capacity(old_cells.len());
        let mut starts: Vec<u32> = Vec::with_capacity(old_starts.len());
        let mut ids: Vec<u32> = Vec::with_capacity(old_ids.len());
        let first_leaf =
            |cell: usize| old_cells.get(cell).map_or(old.0.cells(), |cell| cell.first as usize);
        let ends = changed.iter().map(|&cell| cell as usize).chain([old_cells.len()]);
        let mut next = 0;
        for end in ends {
            let (from, to) = (first_leaf(next), first_leaf(end));
            let at = starts.len();
            let place = |first: u32| (first as usize - from + at) as u32;
            cells.extend(
                old_cells[next..end].iter().map(|c| UpperCell { first: place(c.first), ..*c }),
            );
            let (low, high) = (old_starts[from], old_starts[to]);
            let before = ids.len() as u32;
            starts.extend(old_starts[from..to].iter().map(|start| start - low + before));
            ids.extend_from_slice(&old_ids[low as usize..high as usize]);
            if end < old_cells.len() {
                let (cell, references) = self.planned(end);
                let (first, before) = (starts.len(), ids.len());
                let all = (first + cell.leaf_cells() + old_cells.len()) as u64;
                self.room.check([all, before as u64 + references])?;
                starts.resize(first + cell.leaf_cells(), 0);
                ids.resize(before + references as usize, 0);
                self.fill(end, &cell, &mut starts[first..], &mut ids[before..], before as u32);
                cells.push(UpperCell { first: first as u32, ..cell });
            }
            next = end + 1;
        }
        starts.push(ids.len() as u32);
        Ok((cells, LeafCells(CellLists::of_parts(starts, ids))))
    }

    /// The grid of an upper cell.
    fn leaf(&self, cell: usize, n: [u8; 3]) -> GridFrame<S> {
        self.division.grid(self.contents.frame.coords(cell), n)
    }

    /// The resolution of an upper cell, and the references in its leaf cells; where these begin is
    /// not yet known. Its grid is made coarser until its cells hold fewer primitives than the whole,
    /// and do not multiply them.
    fn planned(&self, cell: usize) -> (UpperCell, u64) {
        let list = self.lists.list(cell);
        let length = list.len() as u64;
        let mut n = [u8::from(!list.is_empty()); 3];
        if self.density * list.len() as f64 >= 2.0 {
            let bounds = self.contents.frame.cell_bounds(cell);
            let (most, smallest) = (self.room.most_cells(), smallest_cell(self.contents.padding()));
            let wanted = resolve_by_density(bounds, list.len(), self.density, most, smallest);
            n = wanted.map(|n| n.min(u32::from(u8::MAX)) as u8);
            while n != [1; 3] {
                let leaf = self.leaf(cell, n);
                let boxes = list.iter().map(|&id| self.contents.box_of(id));
                let references = references_in(&leaf, boxes);
                if 2 * references <= length * leaf.cells() as u64
                    && references <= length * MAX_REFS_PER_PRIM
                {
                    return (UpperCell { first: 0, n }, references);
                }
                n = n.map(|n| n.div_ceil(2));
            }
        }
        (UpperCell { first: 0, n }, length)
    }

    /// Calls `visit` with each leaf cell that primitive `id` goes to.
    #[inline(always)]
    fn leaf_cells_of(&self, leaf: &GridFrame<S>, id: u32, mut visit: impl FnMut(usize)) {
        rows_in(leaf.range(&self.contents.box_of(id)), |start, length| {
            let first = leaf.index(start);
            (first..first + length).for_each(&mut visit);
        });
    }

    /// Writes the ids in the leaf cells of a cell, and where the list of each starts, `before` ids
    /// being those of earlier cells; returns how many there are.
    fn fill(
        &self,
        at: usize,
        cell: &UpperCell,
        starts: &mut [u32],
        ids: &mut [u32],
        before: u32,
    ) -> usize {
        let list = self.lists.list(at);
        if !cell.is_divided() {
            starts.fill(before);
            ids[..list.len()].copy_from_slice(list);
            return list.len();
        }
        let leaf = self.leaf(at, cell.n);
        list.iter().for_each(|&id| self.leaf_cells_of(&leaf, id, |i| starts[i] += 1));
        let mut sum = 0;
        for start in &mut *starts {
            sum += *start;
            *start = sum;
        }
        // from the back: the last id placed comes first
        for &id in list.iter().rev() {
            self.leaf_cells_of(&leaf, id, |i| {
                starts[i] -= 1;
                ids[starts[i] as usize] = id;
            });
        }
        starts.iter_mut().for_each(|start| *start += before);
        sum as usize
    }
}
