//! Boxes of cells, grown over neighbours whose primitives they have.
//!
//! As in Perard-Gayot et al. 2017 (cell expansion): a face moves outward over the
//! cells beyond it if each of their lists is part of the cell's own, as far as the nearest of them
//! reaches. Boxes may then overlap; a ray that leaves one has met all that lies in it.
//!
//! Deviations: a face that has more than a set number of neighbours stays where it is, since
//! looking at all of them takes most of the build; faces move in turn until none does.

use rayon::prelude::*;

use super::subdivide::{Cell, Cells};
use super::{Finder};
type Point=[u32;3];

/// Grows all cells, looking at no more than `most_neighbours` for a step of a face.
pub(super) fn expand(cells: &mut Cells, finder: &Finder, most_neighbours: usize) {
    let whole: &Cells = cells;
    let grown = whole
        .cells
        .par_iter()
        .with_min_len(256)
        .map(|&cell| Growth { cells: whole, finder, most_neighbours, cell }.run());
    let grown: Vec<Cell> = grown.collect();
    cells.cells = grown;
}

struct Growth<'a> {
    cells: &'a Cells,
    finder: &'a Finder,
    most_neighbours: usize,
    cell: Cell,
}

impl Growth<'_> {
    fn run(mut self) -> Cell {
        let mut left = [self.most_neighbours; 6];
        // bit k: the lower face of axis k may still move; bit k + 3: the upper one
        let mut faces = 0b11_1111u32;
        while faces != 0 {
            for face in 0..6 {
                if faces >> face & 1 == 0 {
                    continue;
                }
                if !self.move_face(face % 3, face >= 3, &mut left[face]) {
                    faces &= !(1 << face);
                }
            }
        }
        self.cell
    }

    /// Moves a face to the end of its nearest neighbour; false when it stays.
    fn move_face(&mut self, k: usize, upper: bool, left: &mut usize) -> bool {
        let resolution = self.finder.resolution();
        let beyond = if upper {
            u32::from(self.cell.last[k]) + 1
        } else {
            match u32::from(self.cell.first[k]).checked_sub(1) {
                Some(beyond) => beyond,
                None => return false,
            }
        };
        if beyond >= resolution[k] {
            return false;
        }
        let (u, v) = ((k + 1) % 3, (k + 2) % 3);
        let mut at: Point = [0; 3];
        at[k] = beyond;
        let mut nearest = if upper { u32::MAX } else { 0 };
        at[v] = self.cell.first[v].into();
        while at[v] <= u32::from(self.cell.last[v]) {
            let mut next_row = u32::MAX;
            at[u] = self.cell.first[u].into();
            while at[u] <= u32::from(self.cell.last[u]) {
                let Some(less) = left.checked_sub(1) else { return false };
                *left = less;
                let number = self.finder.cell_at(&self.cells.entries, at) as usize;
                let neighbour = &self.cells.cells[number];
                if !self.has_all_of(neighbour.list) {
                    return false;
                }
                nearest = if upper {
                    nearest.min(neighbour.last[k].into())
                } else {
                    nearest.max(neighbour.first[k].into())
                };
                next_row = next_row.min(u32::from(neighbour.last[v]) + 1);
                at[u] = u32::from(neighbour.last[u]) + 1;
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

    /// Whether the cell has all primitives of another list; both ascend.
    fn has_all_of(&self, list: u32) -> bool {
        if list == 0 || list == self.cell.list {
            return true;
        }
        let mut own = self.cells.list(self.cell.list).iter();
        self.cells.list(list).iter().all(|id| own.any(|mine| mine == id))
    }
}
