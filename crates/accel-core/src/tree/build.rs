//! How a tree of cells is built: depth first, each cell cut where a [`Division`] says; on several
//! threads the children of the first cells at once. The cells are the same, in the same places, for
//! any number of threads.

use crate::capacity::CapacityLimits;
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::Scalar;
use crate::grid::cell_lists::CellLists;
use crate::parallel::{ForkedTree, concat, forks, map, should_parallelize};
use crate::structure::BuildError;

/// Chooses how cells are cut, and which become leaves.
pub(crate) trait Division<S: Scalar>: Sync {
    /// How cells are kept.
    type Link: Link<S, Cut = Self::Cut>;
    /// How a cell is cut.
    type Cut: Copy + Send + Sync;
    /// Statistics of the cuts on the path to a cell.
    type Descent: Copy + Sync;
    /// Memory that is used again for each cell.
    type Scratch;

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

/// What is kept of a cell: which leaf it is, or which inner cell, and how that is cut.
pub(crate) trait Link<S>: Copy + Send + Sync {
    /// How a cell is cut.
    type Cut;
    /// What of a cut stands in a list of its own, by the number of the inner cell.
    type Record: Copy + Send + Sync;
    /// Number of children of an inner cell.
    const CHILDREN: usize;

    fn leaf(number: u32) -> Self;

    fn inner(cut: &Self::Cut, number: u32) -> Self;

    fn record(cut: Self::Cut) -> Self::Record;

    /// The same behind so many other inner cells and leaves.
    fn moved(self, by: [u32; 2]) -> Self;
}

/// The cells of a tree. Cell 0 is the root; the children of inner cell number `i` stand from
/// `1 + CHILDREN * i` on.
pub(crate) struct Cells<S, L: Link<S>> {
    pub(crate) links: Vec<L>,
    /// For each inner cell.
    pub(crate) cuts: Vec<L::Record>,
    /// The references of leaves.
    pub(crate) lists: CellLists,
}

impl<S, L: Link<S>> Cells<S, L> {
    /// A first cell without anything yet.
    fn begun() -> Self {
        Self { links: vec![L::leaf(0)], cuts: Vec::new(), lists: CellLists::none() }
    }

    /// Cuts a cell; the number of its first child, behind which the others stand.
    fn divide(&mut self, cell: usize, cut: L::Cut) -> usize {
        let first = self.links.len();
        self.links[cell] = L::inner(&cut, self.cuts.len() as u32);
        self.cuts.push(L::record(cut));
        self.links.extend(std::iter::repeat_n(L::leaf(0), L::CHILDREN));
        first
    }

    /// Makes a cell a leaf that lists these.
    fn leaf(&mut self, cell: usize, ids: &[u32]) {
        self.links[cell] = L::leaf(self.lists.cells() as u32);
        self.lists.push(ids);
    }

    /// The cells of these pieces ([`ForkedTree::pieces`]), on all threads.
    fn joined(pieces: &[(usize, Self)]) -> Self {
        let root = [L::leaf(0)];
        // the numbers of the next inner cell and leaf, and the first cells of the pieces
        let (mut by, mut firsts) = ([0; 2], Vec::new());
        let (mut links, mut cuts) = (vec![(&root[..], by)], Vec::new());
        let (mut starts, mut ids, mut references) = (vec![(&[0][..], 0)], Vec::new(), 0);
        for (cell, Self { links: below, cuts: own, lists }) in pieces {
            firsts.push((*cell, below[0].moved(by)));
            links.push((&below[1..], by));
            cuts.push((&own[..], ()));
            by = [by[0] + own.len() as u32, by[1] + lists.cells() as u32];
            starts.push((&lists.starts()[1..], references));
            ids.push((lists.ids(), ()));
            references += lists.references() as u32;
        }
        let mut links = concat(&links, &L::moved);
        firsts.into_iter().for_each(|(cell, link)| links[cell] = link);
        let (starts, ids) = (concat(&starts, &|start, by| start + by), concat(&ids, &|id, ()| id));
        Self { links, cuts: concat(&cuts, &|cut, ()| cut), lists: CellLists::of_parts(starts, ids) }
    }
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
) -> Result<CellsOf<S, D>, BuildError> {
    if !should_parallelize(ids.len()) {
        return alone(division, root, ids);
    }
    let large = ids.len() >> forks();
    // which limit is broken, and by how much, is what one thread finds
    let begun = ids.clone();
    forked(division, root, begun, large)
        .and_then(|tree| {
            let pieces = tree.pieces(|cells| cells.links.len());
            let counts = pieces.iter().fold([1, 0], |[cells, references], (_, piece)| {
                let own = [piece.links.len() - 1, piece.lists.references()];
                [cells + own[0] as u64, references + own[1] as u64]
            });
            division.room().check(counts)?;
            Ok(Cells::joined(&pieces))
        })
        .or_else(|_| alone(division, root, ids))
}

/// The cells that a division makes.
type CellsOf<S, D> = Cells<S, <D as Division<S>>::Link>;

/// The cells below a cell, on this thread.
fn alone<S: Scalar, D: Division<S>>(
    division: &D,
    root: Cell<S, D::Descent>,
    ids: Vec<u32>,
) -> Result<CellsOf<S, D>, BuildError> {
    let (scratch, cells) = (division.scratch(), Cells::begun());
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
) -> Result<ForkedTree<CellsOf<S, D>>, BuildError> {
    let cut = if ids.len() > large && should_parallelize(ids.len()) {
        division.cut(&mut division.scratch(), &ids, &cell)
    } else {
        None
    };
    let Some((cut, descent)) = cut else {
        let below = Vec::new();
        return alone(division, cell, ids).map(|piece| ForkedTree { piece, below });
    };
    let mut piece = Cells::begun();
    let first = piece.divide(0, cut);
    let below = |child: usize| {
        let reaches = |id: &u32| division.reaches(*id, &cut, child);
        let mut own: Vec<u32> = ids.iter().copied().filter(reaches).collect();
        if division.alternates() {
            own.reverse();
        }
        let bounds = D::child(&cell.bounds, &cut, child);
        let cell = Cell { bounds, depth: cell.depth + 1, descent };
        forked(division, cell, own, large).map(|tree| (first + child, tree))
    };
    let below = map(0..D::Link::CHILDREN, &below).into_iter().collect::<Result<_, _>>()?;
    Ok(ForkedTree { piece, below })
}

struct Builder<'a, S: Scalar, D: Division<S>> {
    division: &'a D,
    scratch: D::Scratch,
    cells: CellsOf<S, D>,
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
        let (cells, references) = (self.cells.links.len(), self.cells.lists.references());
        let ids = &self.waiting[from..];
        let Some((cut, descent)) = self.division.cut(&mut self.scratch, ids, &cell) else {
            self.division.room().check([cells as u64, (references + ids.len()) as u64])?;
            self.cells.leaf(number, ids);
            self.waiting.truncate(from);
            return Ok(());
        };
        self.division.room().check([(cells + D::Link::CHILDREN) as u64, references as u64])?;
        let first = self.cells.divide(number, cut);
        for child in 0..D::Link::CHILDREN {
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
