//! The cells of a k-d tree.

use crate::geometry::scalar::Scalar;

/// Deepest cell; the root has depth 0.
pub(super) const DEEPEST: usize = 48;

/// The cells; cell 0 is the root.
#[derive(Debug, Clone, Default)]
pub(super) struct Cells<S> {
    pub(super) nodes: Vec<Node<S>>,
    /// `ids[starts[leaf]..starts[leaf + 1]]` are the references of a leaf.
    pub(super) starts: Vec<u32>,
    pub(super) ids: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Node<S> {
    /// The plane, if it is an inner cell.
    pub(super) plane: S,
    /// Inner cell: the axis, and above two bits the lower child, which the upper one follows.
    /// Leaf: 3, and above two bits the number of the leaf.
    pub(super) link: u32,
}

impl<S: Scalar> Node<S> {
    pub(super) const LEAF: u32 = 3;

    pub(super) fn leaf(number: usize) -> Self {
        Self { plane: S::ZERO, link: (number as u32) << 2 | Self::LEAF }
    }

    pub(super) fn inner(axis: usize, plane: S, lower: usize) -> Self {
        Self { plane, link: (lower as u32) << 2 | axis as u32 }
    }

    /// The same after cells have moved by `cells`, and leaves have got numbers higher by `leaves`.
    pub(super) fn moved(self, cells: usize, leaves: usize) -> Self {
        let by = if self.link & 3 == Self::LEAF { leaves } else { cells };
        Self { link: self.link + ((by as u32) << 2), ..self }
    }
}

impl<S> Cells<S> {
    /// The references of a leaf.
    #[inline(always)]
    pub(super) fn list(&self, leaf: usize) -> &[u32] {
        &self.ids[self.starts[leaf] as usize..self.starts[leaf + 1] as usize]
    }

    /// The references of all leaves.
    pub(super) fn lists(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|at| &self.ids[at[0] as usize..at[1] as usize])
    }
}
