//! The lists of the parts: ids, or triangles eight at a time.

use std::ops::ControlFlow;

use crate::geometry::scalar::Scalar;
use crate::primitives::{PrimSet, TriangleBlock, blocks};
use crate::query::sink::Sink;
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

/// Lists by the numbers that voxels have; 0 is the empty one.
#[derive(Debug)]
pub(super) enum Lists<S> {
    /// At its number the list's length, then the ids.
    Ids(Vec<u32>),
    /// Its number is that of its first block.
    Blocks(Vec<TriangleBlock<S>>),
}

impl<S: Scalar> Lists<S> {
    /// The lists of all cells, which get their numbers. Blocks where all primitives are triangles
    /// at rest, and not too many.
    pub(super) fn of<P: PrimSet<S>>(cells: &mut Cells, prims: &P) -> Self {
        if blocks::serve(prims)
            && let Some((runs, n)) = Self::number(cells)
        {
            return Self::Blocks(Self::blocks(cells, prims, &runs, n));
        }
        Self::Ids(std::mem::take(&mut cells.lists))
    }

    /// Numbers the blocks of all lists, the first being that of the empty one: where each list's
    /// begin, and how many there are. `None` when there are too many for their numbers.
    fn number(cells: &mut Cells) -> Option<(Vec<Run>, usize)> {
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

    fn blocks<P: PrimSet<S>>(
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

    /// Hands a list to a sink.
    #[inline(always)]
    pub(super) fn test<K: Sink<S>>(&self, number: u32, sink: &mut K) -> ControlFlow<()> {
        let number = number as usize;
        match self {
            Self::Ids(ids) => {
                let n = ids.get(number).map_or(0, |&n| n as usize);
                sink.test(ids.get(number + 1..number + 1 + n).unwrap_or(&[]))
            }
            Self::Blocks(blocks) => {
                for block in blocks.get(number..).unwrap_or(&[]) {
                    sink.test_block(block)?;
                    if !block.has_next() {
                        break;
                    }
                }
                ControlFlow::Continue(())
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Ids(ids) => size_of_val(ids.as_slice()),
            Self::Blocks(blocks) => size_of_val(blocks.as_slice()),
        }
    }
}
