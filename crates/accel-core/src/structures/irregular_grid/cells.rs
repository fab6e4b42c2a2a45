//! The cells of the grid while it is built, the tree of entries that finds them, and the lists of
//! their parts: one is shared by the cells that have it.

use crate::geometry::scalar::Scalar;
use crate::primitives::{Primitives, blocks};
use crate::query::lists::Lists;
use crate::structure::BuildError;

/// An entry of the tree that is divided: this bit, three times two bits with the logarithms of the
/// parts on each axis, and the number of the first part's entry. Any other is a cell's number.
pub(super) const DIVIDED: u32 = 1 << 31;
/// The bits of the number of the first part's entry.
pub(super) const FIRST_PART: u32 = (1 << 25) - 1;

/// A cell: its first and last lattice coordinates, and where its list begins.
#[repr(C, align(16))]
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub(super) first: [u16; 3],
    pub(super) last: [u16; 3],
    pub(super) list: u32,
}

/// The cells and how to find them.
#[derive(Debug)]
pub(super) struct Cells {
    /// For errors.
    structure: &'static str,
    /// The top grid's entries, then those of parts.
    pub(super) entries: Vec<u32>,
    pub(super) cells: Vec<Cell>,
    /// At a cell's `list`: the number of ids, then the ids, ascending. 0 is the empty list.
    pub(super) lists: Vec<u32>,
    /// References in the cells together; cells share equal lists.
    pub(super) references: u64,
    /// Divided entries, the top grid among them.
    pub(super) divided: u64,
}

impl Cells {
    /// Without cells yet, but with entries for so many.
    pub(super) fn new(structure: &'static str, entries: usize) -> Self {
        let (entries, cells, lists) = (vec![0; entries], Vec::new(), vec![0]);
        Self { structure, entries, cells, lists, references: 0, divided: 0 }
    }

    /// Checks that its numbers still fit.
    pub(super) fn check(&self) -> Result<(), BuildError> {
        let (needed, limit) = (self.entries.len() as u128, u128::from(FIRST_PART));
        if needed > limit {
            let (structure, what) = (self.structure, "number of cells");
            return Err(BuildError::TooLarge { structure, what, needed, limit });
        }
        Ok(())
    }

    /// Takes in the cells of others; their first `roots` entries come to those from `at` on.
    pub(super) fn absorb(
        &mut self,
        other: Self,
        at: usize,
        roots: usize,
    ) -> Result<(), BuildError> {
        let (entries, cells) = (self.entries.len() as u32, self.cells.len() as u32);
        // both begin with the empty list
        let lists = self.lists.len() as u32 - 1;
        let renumbered = |entry: &u32| {
            if entry & DIVIDED == 0 {
                entry + cells
            } else {
                (entry & !FIRST_PART) | ((entry & FIRST_PART) + entries - roots as u32)
            }
        };
        self.entries.extend(other.entries[roots..].iter().map(renumbered));
        self.check()?;
        self.cells.extend(other.cells.iter().map(|cell| Cell {
            list: if cell.list == 0 { 0 } else { cell.list + lists },
            ..*cell
        }));
        self.lists.extend_from_slice(&other.lists[1..]);
        self.references += other.references;
        self.divided += other.divided;
        let renumbered = other.entries[..roots].iter().map(renumbered);
        self.entries[at..].iter_mut().zip(renumbered).for_each(|(entry, root)| *entry = root);
        Ok(())
    }

    /// The ids of a list.
    #[inline(always)]
    pub(super) fn list(&self, at: u32) -> &[u32] {
        let at = at as usize;
        match self.lists.get(at) {
            Some(&n) => self.lists.get(at + 1..at + 1 + n as usize).unwrap_or(&[]),
            None => &[],
        }
    }
}

/// The lists of all cells, which get their numbers. Blocks where all primitives are triangles
/// at rest, and not too many.
pub(super) fn lists_of<S: Scalar>(cells: &mut Cells, prims: &dyn Primitives<S>) -> Lists<S> {
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
