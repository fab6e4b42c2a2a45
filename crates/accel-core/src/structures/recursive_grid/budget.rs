//! Common limits of cells and references for the grids of a recursive grid, shared by threads.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::capacity::CapacityLimits;

/// So many cells and references would have been there, more than a limit allows.
pub(super) type ExcessCounts = [u64; 2];

/// A room and what is taken of it.
///
/// Whether a grid is refused, and how many voxels the last ones get, depends on the grids before.
/// To stay independent of their order, a build by several threads continues only as long as nothing
/// is refused in any order ([`Budget::in_any_order`]).
#[derive(Debug)]
pub(super) struct Budget {
    room: CapacityLimits,
    /// Half the room, where grids come in any order: what is given back stays taken.
    half: Option<CapacityLimits>,
    taken: Mutex<[u64; 2]>,
    /// Amounts given back whose reservation stays in place.
    given_back: [AtomicU64; 2],
}

impl Budget {
    /// For grids that come one after the other.
    pub(super) fn new(room: CapacityLimits) -> Self {
        Self { room, half: None, taken: Mutex::default(), given_back: Default::default() }
    }

    /// For grids that come in any order. All together have half the room and each, alone, the other
    /// half: what is not over the limit here would get what it asks for in whatever order, so it
    /// gets that here.
    pub(super) fn in_any_order(room: CapacityLimits) -> Self {
        Self { half: Some(room.halved()), ..Self::new(room) }
    }

    /// Returns whether grids may come in any order.
    pub(super) fn is_in_any_order(&self) -> bool {
        self.half.is_some()
    }

    /// From here on grids come one after the other.
    pub(super) fn in_order(&mut self) {
        self.half = None;
        let back = std::mem::take(&mut self.given_back).map(AtomicU64::into_inner);
        self.give_back(back);
    }

    fn taken(&self) -> MutexGuard<'_, [u64; 2]> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of cells that remain.
    pub(super) fn cells_left(&self) -> u64 {
        if self.half.is_some() {
            return self.room.most_cells();
        }
        let [cells, references] = *self.taken();
        self.room.cells_beside(references).saturating_sub(cells)
    }

    /// Number of references that remain.
    pub(super) fn references_left(&self) -> u64 {
        if let Some(half) = self.half {
            return half.references_beside(0);
        }
        let [cells, references] = *self.taken();
        self.room.references_beside(cells).saturating_sub(references)
    }

    /// The error for this many more cells and references.
    pub(super) fn exceeded_by(&self, more: [u64; 2]) -> ExcessCounts {
        sum(*self.taken(), more)
    }

    /// Takes so many cells and references.
    pub(super) fn take(&self, more: [u64; 2]) -> Result<(), ExcessCounts> {
        let mut taken = self.taken();
        let needed = sum(*taken, more);
        if self.half.unwrap_or(self.room).check(needed).is_err() {
            return Err(needed);
        }
        *taken = needed;
        Ok(())
    }

    /// Gives so many back.
    pub(super) fn give_back(&self, fewer: [u64; 2]) {
        if self.half.is_some() {
            for (sum, fewer) in self.given_back.iter().zip(fewer) {
                sum.fetch_add(fewer, Ordering::Relaxed);
            }
            return;
        }
        let mut taken = self.taken();
        *taken = [0, 1].map(|k| taken[k].saturating_sub(fewer[k]));
    }
}

fn sum(a: [u64; 2], b: [u64; 2]) -> [u64; 2] {
    [0, 1].map(|k| a[k].saturating_add(b[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::nested_grids::build::room_of;
    use crate::memory::{Limits, MemoryLimit};

    fn room(cells: u64, references: u64) -> CapacityLimits {
        let limits = Limits { structure: "recursive-grid", memory: MemoryLimit::NONE };
        room_of(limits, cells, references)
    }

    #[test]
    fn returned_cells_are_available_in_order() {
        let budget = Budget::new(room(100, 100));
        budget.take([60, 90]).unwrap();
        assert_eq!(budget.take([41, 0]).unwrap_err(), [101, 90]);
        budget.give_back([50, 0]);
        budget.take([90, 0]).unwrap();
        assert_eq!((budget.cells_left(), budget.references_left()), (0, 10));
    }

    /// A grid of 45 references and one of 60, of which 40 are given back, fit in one order of two.
    /// In any order, neither may be told whether the other came before.
    #[test]
    fn fitting_does_not_depend_on_the_order_of_grids() {
        let grids = [[10, 45, 0], [10, 60, 40]];
        let fits = |order: [usize; 2]| {
            let budget = Budget::new(room(100, 100));
            order.into_iter().all(|i| {
                let [cells, references, back] = grids[i];
                let taken = budget.take([cells, references]);
                budget.give_back([0, back]);
                taken.is_ok()
            })
        };
        assert_eq!([fits([0, 1]), fits([1, 0])], [false, true]);
        let mut budget = Budget::in_any_order(room(100, 100));
        assert_eq!((budget.cells_left(), budget.references_left()), (100, 50));
        budget.take([10, 30]).unwrap();
        budget.give_back([5, 30]);
        // nor is anybody told of more or less room than before
        assert_eq!((budget.cells_left(), budget.references_left()), (100, 50));
        assert!(budget.take([0, 21]).is_err() && budget.take([41, 0]).is_err());
        budget.take([40, 20]).unwrap();
        budget.in_order();
        assert_eq!((budget.cells_left(), budget.references_left()), (55, 80));
    }
}
