//! How a tree of cells is built: depth first, each cell cut where a [`Division`] says; on several threads the
//! children of the first cells at once. The cells are the same, in the same places, for any number of threads.

use rayon::prelude::*;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::parallel::{forks, is_worth_a_fork};
use crate::room::Room;
use crate::structure::BuildError;

/// Where cells are cut, and when they are not.
pub(crate) trait Division<S: Scalar>: Sync {
    /// How cells are kept.
    type Cells: CellStore<Cut = Self::Cut>;
    /// How a cell is cut.
    type Cut: Copy + Sync;
    /// What the cuts on the way to a cell brought.
    type Descent: Copy + Sync;
    /// Memory that is used again for each cell.
    type Scratch;
    /// Of a cell that is cut.
    const CHILDREN: usize;

    /// Of one thread.
    fn scratch(&self) -> Self::Scratch;

    /// Where to cut a cell that lists `ids`, and the way to what is below it; `None` makes it a leaf.
    fn cut(
        &self,
        scratch: &mut Self::Scratch,
        ids: &[u32],
        cell: &Cell<S, Self::Descent>,
    ) -> Option<(Self::Cut, Self::Descent)>;

    /// Whether a primitive reaches into a child.
    fn reaches(&self, id: u32, cut: &Self::Cut, child: usize) -> bool;

    /// The box of a child.
    fn child(bounds: &Aabb<S>, cut: &Self::Cut, child: usize) -> Aabb<S>;

    /// Whether the lists of children are in the reverse order of their parent's.
    fn alternates(&self) -> bool {
        false
    }

    /// For cells and references.
    fn room(&self) -> &Room;
}

/// The cells of a tree.
pub(crate) trait CellStore: Send {
    /// How a cell is cut.
    type Cut;

    /// A first cell without anything yet.
    fn begun() -> Self;

    /// Numbers of cells and references.
    fn counts(&self) -> [usize; 2];

    /// Cuts a cell; the number of its first child, behind which the others stand.
    fn divide(&mut self, cell: usize, cut: Self::Cut) -> usize;

    /// Makes a cell a leaf that lists these.
    fn leaf(&mut self, cell: usize, ids: &[u32]);

    /// Puts the cells below a child of the first cell, which is cut, behind all others.
    fn append(&mut self, child: usize, below: Self);
}

/// A cell that is to be divided.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell<S: Scalar, D> {
    pub(crate) bounds: Aabb<S>,
    /// 0 for the root.
    pub(crate) depth: usize,
    pub(crate) descent: D,
}

/// Builds the cells below a root that lists `ids`, on all threads of the current rayon pool.
pub(crate) fn cells<S: Scalar, D: Division<S>>(
    division: &D,
    root: Cell<S, D::Descent>,
    ids: impl Fn() -> Vec<u32>,
) -> Result<D::Cells, BuildError> {
    match forks().div_ceil(D::CHILDREN.ilog2()) {
        0 => alone(division, root, ids()),
        // which limit is broken, and by how much, is what one thread finds
        forks => forked(division, root, ids(), forks).or_else(|_| alone(division, root, ids())),
    }
}

/// The cells below a cell, on this thread.
fn alone<S: Scalar, D: Division<S>>(
    division: &D,
    root: Cell<S, D::Descent>,
    ids: Vec<u32>,
) -> Result<D::Cells, BuildError> {
    let (scratch, cells) = (division.scratch(), D::Cells::begun());
    let mut builder = Builder { division, scratch, cells, waiting: ids };
    builder.cell(0, root, 0)?;
    Ok(builder.cells)
}

/// The same with all children at once, `forks` times one below the other.
fn forked<S: Scalar, D: Division<S>>(
    division: &D,
    cell: Cell<S, D::Descent>,
    ids: Vec<u32>,
    forks: u32,
) -> Result<D::Cells, BuildError> {
    if forks == 0 || !is_worth_a_fork(ids.len()) {
        return alone(division, cell, ids);
    }
    let decided = division.cut(&mut division.scratch(), &ids, &cell);
    let Some((cut, descent)) = decided else { return alone(division, cell, ids) };
    let below = |child: usize| {
        let reaches = |id: &u32| division.reaches(*id, &cut, child);
        let mut own: Vec<u32> = ids.iter().copied().filter(reaches).collect();
        if division.alternates() {
            own.reverse();
        }
        let bounds = D::child(&cell.bounds, &cut, child);
        forked(division, Cell { bounds, depth: cell.depth + 1, descent }, own, forks - 1)
    };
    let all: Vec<Result<D::Cells, BuildError>> =
        (0..D::CHILDREN).into_par_iter().map(below).collect();
    let mut cells = D::Cells::begun();
    cells.divide(0, cut);
    for (child, below) in all.into_iter().enumerate() {
        cells.append(child, below?);
    }
    division.room().check(cells.counts().map(|n| n as u64))?;
    Ok(cells)
}

struct Builder<'a, S: Scalar, D: Division<S>> {
    division: &'a D,
    scratch: D::Scratch,
    cells: D::Cells,
    /// References of the cells on the way from the first, one list after the other.
    waiting: Vec<u32>,
}

impl<S: Scalar, D: Division<S>> Builder<'_, S, D> {
    /// Makes cell `number` of the references `waiting[from..]`, which it takes away.
    fn cell(
        &mut self,
        number: usize,
        cell: Cell<S, D::Descent>,
        from: usize,
    ) -> Result<(), BuildError> {
        let end = self.waiting.len();
        let [cells, references] = self.cells.counts();
        let ids = &self.waiting[from..];
        let Some((cut, descent)) = self.division.cut(&mut self.scratch, ids, &cell) else {
            self.division.room().check([cells as u64, (references + ids.len()) as u64])?;
            self.cells.leaf(number, ids);
            self.waiting.truncate(from);
            return Ok(());
        };
        self.division.room().check([(cells + D::CHILDREN) as u64, references as u64])?;
        let first = self.cells.divide(number, cut);
        for child in 0..D::CHILDREN {
            for i in from..end {
                let i = if self.division.alternates() { from + end - 1 - i } else { i };
                let id = self.waiting[i];
                if self.division.reaches(id, &cut, child) {
                    self.waiting.push(id);
                }
            }
            let bounds = D::child(&cell.bounds, &cut, child);
            self.cell(first + child, Cell { bounds, depth: cell.depth + 1, descent }, end)?;
        }
        self.waiting.truncate(from);
        Ok(())
    }
}
