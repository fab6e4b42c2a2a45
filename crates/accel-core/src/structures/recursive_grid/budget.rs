//! What the grids of a recursive grid may take of cells and references together; shared by the threads that
//! build.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::room::Room;

/// A limit was exceeded: so many cells and references would have been there.
#[derive(Debug, Clone, Copy)]
pub(super) struct OverLimit {
    pub(super) needed: [u64; 2],
}

/// A room and what is taken of it.
#[derive(Debug)]
pub(super) struct Budget {
    room: Room,
    /// Cells and references.
    taken: Mutex<[u64; 2]>,
}

impl Budget {
    pub(super) fn new(room: Room) -> Self {
        Self { room, taken: Mutex::default() }
    }

    fn taken(&self) -> MutexGuard<'_, [u64; 2]> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How many more cells there may be.
    pub(super) fn cells_left(&self) -> u64 {
        let [cells, references] = *self.taken();
        self.room.cells_beside(references).saturating_sub(cells)
    }

    /// How many more references.
    pub(super) fn references_left(&self) -> u64 {
        let [cells, references] = *self.taken();
        self.room.references_beside(cells).saturating_sub(references)
    }

    /// What would be there with so many more cells and references.
    pub(super) fn exceeded_by(&self, more: [u64; 2]) -> OverLimit {
        OverLimit { needed: sum(*self.taken(), more) }
    }

    /// Takes so many cells and references.
    pub(super) fn take(&self, more: [u64; 2]) -> Result<(), OverLimit> {
        let mut taken = self.taken();
        let needed = sum(*taken, more);
        if self.room.check(needed).is_err() {
            return Err(OverLimit { needed });
        }
        *taken = needed;
        Ok(())
    }

    /// Gives so many back.
    pub(super) fn give_back(&self, fewer: [u64; 2]) {
        let mut taken = self.taken();
        *taken = [0, 1].map(|k| taken[k].saturating_sub(fewer[k]));
    }
}

fn sum(a: [u64; 2], b: [u64; 2]) -> [u64; 2] {
    [0, 1].map(|k| a[k].saturating_add(b[k]))
}
