//! The cells of an octree.

use crate::geometry::scalar::Scalar;

/// Deepest cell; the root has depth 0.
pub(super) const DEEPEST: usize = 20;

/// The cells. Cell 0 is the root; the children of inner cell number `i` are the cells
/// `1 + 8 i ..= 8 + 8 i`, with bit k of the offset set on the upper side of axis k.
#[derive(Debug, Clone, Default)]
pub(super) struct Cells<S> {
    /// For each cell the number of its leaf with [`LEAF`] set, or its number among inner cells.
    pub(super) links: Vec<u32>,
    /// For each inner cell, the planes that cut it.
    pub(super) planes: Vec<[S; 3]>,
    /// `ids[starts[leaf]..starts[leaf + 1]]` are the references of a leaf.
    pub(super) starts: Vec<u32>,
    pub(super) ids: Vec<u32>,
}

/// Set in the link of a leaf.
pub(super) const LEAF: u32 = 1 << 31;

/// The kind of a cell.
pub(super) enum Content<'a, S> {
    /// Cut by these planes; the first of its eight children.
    Inner(&'a [S; 3], u32),
    Leaf(&'a [u32]),
}

impl<S: Scalar> Cells<S> {
    /// The references of all leaves.
    pub(super) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|at| &self.ids[at[0] as usize..at[1] as usize])
    }

    #[inline(always)]
    pub(super) fn content(&self, cell: u32) -> Content<'_, S> {
        let link = self.links[cell as usize];
        let number = (link & !LEAF) as usize;
        if link & LEAF == 0 {
            Content::Inner(&self.planes[number], 1 + 8 * link)
        } else {
            let range = self.starts[number] as usize..self.starts[number + 1] as usize;
            Content::Leaf(&self.ids[range])
        }
    }
}
