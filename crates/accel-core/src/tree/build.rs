//! How a tree of cells is built: depth first, each cell cut where a [`Division`] says; on several
//! threads the children of the first cells at once. The cells are the same, in the same places, for
//! any number of threads.

use crate::capacity::CapacityLimits;
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::CellLists;
use crate::parallel::{concat, forks, map, should_parallelize};
use crate::structure::BuildError;

/// Chooses how cells are cut, and which become leaves.
pub(crate) trait Division<S: Scalar>: Sync {
    /// How cells are kept.
    type Cells: CellStore<Cut = Self::Cut>;
    /// How a cell is cut.
    type Cut: Copy + Send + Sync;
    /// Statistics of the cuts on the path to a cell.
    type Descent: Copy + Sync;
    /// Memory that is used again for each cell.
    type Scratch;
    /// Number of children of an inner cell.
    const CHILDREN: usize;

    fn scratch(&self) -> Self::Scratch;

    /// Chooses the cut of a cell that lists `ids`, and the state for its children; `None` makes it
    /// a leaf.
    fn cut(
        &self,
        scratch: &mut Self::Scratch,
        ids: &[u32],
        cell: &Cell<S, Self::Descent>,
    ) -> Option<(Self::Cut, Self::Descent)>;

    /// Returns whether a primitive reaches into a child.
    fn reaches(&self, id: u32, cut: &Self::Cut, child: usize) -> bool;

    /// The box of a child.
    fn child(bounds: &Aabb<S>, cut: &Self::Cut, child: usize) -> Aabb<S>;

    /// Returns whether the lists of children are in the reverse order of their parent's.
    fn alternates(&self) -> bool {
        false
    }

    /// For cells and references.
    fn room(&self) -> &CapacityLimits;
}

/// The cells of a tree.
pub(crate) trait CellStore: Send {
    /// How a cell is cut.
    type Cut: Send;

    /// A first cell without anything yet.
    fn begun() -> Self;

    /// Numbers of cells and references.
    fn counts(&self) -> [usize; 2];

    /// Cuts a cell; the number of its first child, behind which the others stand.
    fn divide(&mut self, cell: usize, cut: Self::Cut) -> usize;

    /// Makes a cell a leaf that lists these.
    fn leaf(&mut self, cell: usize, ids: &[u32]);

    /// Puts stores together, on all threads.
    fn joined(steps: &[Step<Self>]) -> Self
    where
        Self: Sized;
}

/// Next step of a build that starts with one cell.
pub(crate) enum Step<C: CellStore> {
    /// This cell is cut.
    Divide(usize, C::Cut),
    /// This cell becomes the first one of another store, whose others stand behind all before.
    Below(usize, C),
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
    ids: Vec<u32>,
) -> Result<D::Cells, BuildError> {
    if !should_parallelize(ids.len()) {
        return alone(division, root, ids);
    }
    let large = ids.len() >> forks();
    // which limit is broken, and by how much, is what one thread finds
    let begun = ids.clone();
    forked(division, root, begun, large)
        .and_then(|tree| {
            let (mut steps, mut counts) = (Vec::new(), [1, 0]);
            tree.steps(0, D::CHILDREN, &mut steps, &mut counts);
            division.room().check(counts)?;
            Ok(D::Cells::joined(&steps))
        })
        .or_else(|_| alone(division, root, ids))
}

/// Cells that several threads built.
enum ForkedCells<C: CellStore> {
    Cut(C::Cut, Vec<Self>),
    Built(C),
}

impl<C: CellStore> Step<C> {
    /// The store that is put behind all before.
    fn below(&self) -> Option<&C> {
        match self {
            Self::Below(_, cells) => Some(cells),
            Self::Divide(..) => None,
        }
    }
}

/// Joins the lists of the leaves of all stores.
pub(crate) fn joined_lists<C: CellStore>(
    steps: &[Step<C>],
    lists: impl Fn(&C) -> &CellLists,
) -> CellLists {
    let (mut starts, mut ids, mut references) = (vec![(&[0][..], 0)], Vec::new(), 0);
    for lists in steps.iter().filter_map(Step::below).map(lists) {
        starts.push((&lists.starts()[1..], references));
        ids.push((lists.ids(), ()));
        references += lists.references() as u32;
    }
    CellLists::of_parts(concat(&starts, &|start, by| start + by), concat(&ids, &|id, ()| id))
}

impl<C: CellStore> ForkedCells<C> {
    /// Selects from `steps` those that make these cells, from `cell` on; `counts` cells and
    /// references.
    fn steps(self, cell: usize, children: usize, steps: &mut Vec<Step<C>>, counts: &mut [u64; 2]) {
        match self {
            Self::Cut(cut, below) => {
                steps.push(Step::Divide(cell, cut));
                let first = counts[0] as usize;
                counts[0] += children as u64;
                for (child, below) in below.into_iter().enumerate() {
                    below.steps(first + child, children, steps, counts);
                }
            }
            Self::Built(cells) => {
                let [more, references] = cells.counts().map(|n| n as u64);
                *counts = [counts[0] + more - 1, counts[1] + references];
                steps.push(Step::Below(cell, cells));
            }
        }
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

/// The same with the children at once of cells with more than `large` references, if that pays.
fn forked<S: Scalar, D: Division<S>>(
    division: &D,
    cell: Cell<S, D::Descent>,
    ids: Vec<u32>,
    large: usize,
) -> Result<ForkedCells<D::Cells>, BuildError> {
    let cut = if ids.len() > large && should_parallelize(ids.len()) {
        division.cut(&mut division.scratch(), &ids, &cell)
    } else {
        None
    };
    let Some((cut, descent)) = cut else {
        return alone(division, cell, ids).map(ForkedCells::Built);
    };
    let below = |child: usize| {
        let reaches = |id: &u32| division.reaches(*id, &cut, child);
        let mut own: Vec<u32> = ids.iter().copied().filter(reaches).collect();
        if division.alternates() {
            own.reverse();
        }
        let bounds = D::child(&cell.bounds, &cut, child);
        forked(division, Cell { bounds, depth: cell.depth + 1, descent }, own, large)
    };
    let below = map(0..D::CHILDREN, &below).into_iter().collect::<Result<_, _>>()?;
    Ok(ForkedCells::Cut(cut, below))
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
