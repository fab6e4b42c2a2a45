//! Boxes of cells, grown over neighbours whose primitives they have.
//!
//! As in Perard-Gayot et al. 2017 (cell expansion): a face moves outward over the
//! cells beyond it if each of their lists is part of the cell's own, as far as the nearest of them
//! reaches. Boxes may then overlap; a ray that leaves one has met all that lies in it.
//!
//! Deviations: a face stays where it is once it has looked at a set number of neighbours, over all
//! its moves, since looking at all of them takes most of the build; faces move in turn until none
//! does, where the paper makes a set number of passes.

use std::cmp::Ordering;

use wide::i32x4;

use crate::parallel;
use crate::structures::irregular_grid::cells::{Cell, Cells};
use crate::structures::irregular_grid::voxels::Voxels;

/// Grows all cells; no face looks at more than `most_neighbours`.
pub(super) fn expand(cells: &mut Cells, voxels: &Voxels, most_neighbours: usize) {
    let mut grown = cells.cells.clone();
    parallel::map(grown.chunks_mut(256), &|part| {
        for cell in part {
            *cell = Growth { cells, voxels, most_neighbours, cell: *cell }.run();
        }
    });
    cells.cells = grown;
}

struct Growth<'a> {
    cells: &'a Cells,
    voxels: &'a Voxels,
    most_neighbours: usize,
    cell: Cell,
}

impl Growth<'_> {
    fn run(mut self) -> Cell {
        // neighbours that each face may still look at
        let mut left = [self.most_neighbours; 6];
        // bit k: the lower face of axis k may still move; bit k + 3: the upper one
        let mut faces = 0b11_1111u32;
        while faces != 0 {
            for (face, left) in left.iter_mut().enumerate() {
                if faces >> face & 1 == 0 {
                    continue;
                }
                if !self.move_face(face % 3, face >= 3, left) {
                    faces &= !(1 << face);
                }
            }
        }
        self.cell
    }

    /// Moves a face to the end of its nearest neighbour; false when it stays.
    fn move_face(&mut self, k: usize, upper: bool, left: &mut usize) -> bool {
        let beyond = if upper {
            u32::from(self.cell.last[k]) + 1
        } else {
            match u32::from(self.cell.first[k]).checked_sub(1) {
                Some(beyond) => beyond,
                None => return false,
            }
        };
        if beyond >= self.voxels.resolution()[k] {
            return false;
        }
        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
        let mut at = [0u32; 3];
        at[k] = beyond;
        let mut nearest = if upper { u32::MAX } else { 0 };
        at[v] = self.cell.first[v].into();
        while at[v] <= u32::from(self.cell.last[v]) {
            let mut next_row = u32::MAX;
            at[u] = self.cell.first[u].into();
            while at[u] <= u32::from(self.cell.last[u]) {
                let Some(less) = left.checked_sub(1) else { return false };
                *left = less;
                let neighbour =
                    self.voxels.at(i32x4::new([at[0], at[1], at[2], 0].map(|x| x as i32)));
                if !self.has_all_of(neighbour.list()) {
                    return false;
                }
                let (first, end) = neighbour.bounds();
                nearest = if upper { nearest.min(end[k] - 1) } else { nearest.max(first[k]) };
                next_row = next_row.min(end[v]);
                at[u] = end[u];
            }
            at[v] = next_row;
        }
        if upper {
            self.cell.last[k] = nearest as u16;
        } else {
            self.cell.first[k] = nearest as u16;
        }
        true
    }

    /// Returns whether the cell has all primitives of another list; both ascend.
    fn has_all_of(&self, list: u32) -> bool {
        if list == 0 || list == self.cell.list {
            return true;
        }
        if self.cell.list == 0 {
            return false;
        }
        let (mut own, others) = (self.cells.list(self.cell.list), self.cells.list(list));
        if others.len() > own.len() {
            return false;
        }
        for id in others {
            // what is left of both lists is ascending
            loop {
                let Some((mine, rest)) = own.split_first() else { return false };
                own = rest;
                match mine.cmp(id) {
                    Ordering::Less => {}
                    Ordering::Equal => break,
                    Ordering::Greater => return false,
                }
            }
        }
        true
    }
}
