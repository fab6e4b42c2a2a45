//! The lists of one grid's voxels, in an array of its own or in one that several grids share.

use std::sync::Arc;

use crate::grid::cell_lists::CellLists;

/// For every voxel, the slice of ids it holds.
pub(super) struct VoxelLists {
    /// One more than there are voxels.
    starts: Vec<u32>,
    ids: Arc<[u32]>,
}

impl From<CellLists> for VoxelLists {
    fn from(lists: CellLists) -> Self {
        let (starts, ids) = lists.into_parts();
        Self { starts, ids: ids.into() }
    }
}

impl VoxelLists {
    /// The ids of a voxel; empty for one that does not exist.
    #[inline(always)]
    pub(super) fn list(&self, voxel: usize) -> &[u32] {
        match self.starts.get(voxel..voxel + 2) {
            Some(&[a, b]) => self.ids.get(a as usize..b as usize).unwrap_or(&[]),
            _ => &[],
        }
    }

    /// The number of voxels.
    pub(super) fn voxels(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Those without ids.
    pub(super) fn empty_voxels(&self) -> usize {
        self.starts.windows(2).filter(|at| at[0] == at[1]).count()
    }

    /// The ids of all voxels together.
    pub(super) fn references(&self) -> usize {
        match (self.starts.first(), self.starts.last()) {
            (Some(&first), Some(&last)) => (last - first) as usize,
            _ => 0,
        }
    }

    /// Bytes occupied.
    pub(super) fn bytes(&self) -> usize {
        (self.starts.len() + self.references()) * 4
    }

    /// Moves ids that are the grid's alone to the end of an array that is to be shared; the lists are empty
    /// until it [is](Self::share). False, with nothing changed, where the array has no room for them.
    pub(super) fn move_to(&mut self, all: &mut Vec<u32>) -> bool {
        let base = u32::try_from(all.len()).ok();
        let fits = base.is_some_and(|base| base.checked_add(self.references() as u32).is_some());
        if let (Some(base), true) = (base, fits) {
            all.extend_from_slice(&self.ids);
            self.starts.iter_mut().for_each(|start| *start += base);
            self.ids = Arc::default();
        }
        fits
    }

    /// Takes the array that ids were moved to.
    pub(super) fn share(&mut self, all: &Arc<[u32]>) {
        if self.ids.is_empty() {
            self.ids = Arc::clone(all);
        }
    }
}
