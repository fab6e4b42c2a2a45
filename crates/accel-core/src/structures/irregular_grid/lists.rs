//! The lists of the parts: ids, or triangles eight at a time.

use std::ops::ControlFlow;

use super::subdivide::{Cell, Cells};
use crate::primitives::{PrimSet, TriangleBlock};
use crate::scalar::{Scalar, Vector};
use crate::sink::Sink;

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
        if prims.is_watertight() && prims.len() <= TriangleBlock::<S>::MOST_IDS {
            let renumbered = Self::blocks(cells, prims);
            if let Some((blocks, renumbered)) = renumbered {
                cells.cells = renumbered;
                return Self::Blocks(blocks);
            }
        }
        Self::Ids(std::mem::take(&mut cells.lists))
    }

    fn blocks<P: PrimSet<S>>(
        cells: &Cells,
        prims: &P,
    ) -> Option<(Vec<TriangleBlock<S>>, Vec<Cell>)> {
        let corners = |id| prims.corners(id).map(|corners| corners.map(|p| p.to_array()));
        if (0..prims.len() as u32).any(|id| corners(id).is_none()) {
            return None;
        }
        let mut blocks = vec![TriangleBlock::new(std::iter::empty(), false)];
        // the first block of the list that begins at that place
        let mut first = vec![0u32; cells.lists.len()];
        let mut renumbered = cells.cells.clone();
        for cell in renumbered.iter_mut().filter(|cell| cell.list != 0) {
            let begin = &mut first[cell.list as usize];
            if *begin == 0 {
                *begin = u32::try_from(blocks.len()).ok()?;
                let mut parts = cells.list(cell.list).chunks(8).peekable();
                while let Some(part) = parts.next() {
                    let triangles = part.iter().filter_map(|&id| Some((id, corners(id)?)));
                    blocks.push(TriangleBlock::new(triangles, parts.peek().is_some()));
                }
            }
            cell.list = *begin;
        }
        Some((blocks, renumbered))
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
                    let (ids, n) = block.ids();
                    sink.test(ids.get(..n).unwrap_or(&[]))?;
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
