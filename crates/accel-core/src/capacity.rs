//! Room for structures that grow in cells and references, part by part.

use crate::memory::Limits;
use crate::memory::{CountedItem, OutOfMemory};
use crate::structure::BuildError;

/// Limits of cells and references: each by its setting, both together by memory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CapacityLimits {
    limits: Limits,
    /// Each with the most that there may be; they are numbered in 32 bits.
    parts: [(&'static CountedItem, u64); 2],
}

impl CapacityLimits {
    /// Limits of these parts, with their settings.
    pub(crate) fn new(limits: Limits, parts: [(&'static CountedItem, u64); 2]) -> Self {
        let parts = parts.map(|(part, most)| (part, most.min(u64::from(u32::MAX) - 1)));
        Self { limits, parts }
    }

    pub(crate) fn halved(&self) -> Self {
        let limits = Limits { memory: self.limits.memory.halved(), ..self.limits };
        Self { limits, parts: self.parts.map(|(part, most)| (part, most / 2)) }
    }

    /// Refuses so many cells and references.
    #[inline(always)]
    pub(crate) fn check(&self, needed: [u64; 2]) -> Result<(), BuildError> {
        let [(cells, most_cells), (references, most_references)] = self.parts;
        // of numbers of 32 bits and a few bytes each
        let fits = needed[0] <= most_cells
            && needed[1] <= most_references
            && cells.bytes * needed[0] + references.bytes * needed[1]
                <= self.limits.memory.count(1);
        if fits { Ok(()) } else { Err(self.refused(needed)) }
    }

    /// The error where so many are too many.
    #[cold]
    pub(crate) fn refused(&self, needed: [u64; 2]) -> BuildError {
        let structure = self.limits.structure;
        let all = || self.parts.into_iter().zip(needed);
        let bytes = all().map(|((part, _), n)| u128::from(part.bytes) * u128::from(n)).sum();
        for ((part, limit), needed) in all() {
            if needed > limit {
                let (needed, limit) = (needed.into(), limit.into());
                return BuildError::TooLarge { structure, what: part.what, needed, limit };
            }
        }
        OutOfMemory { structure, needed: bytes, limit: self.limits.memory.bytes() }.into()
    }

    /// The most cells, were there no references.
    pub(crate) fn most_cells(&self) -> u64 {
        self.cells_beside(0)
    }

    /// The most cells beside so many references.
    pub(crate) fn cells_beside(&self, references: u64) -> u64 {
        let [(cells, most), (counted, _)] = self.parts;
        let left = self.limits.memory.beside(counted.bytes.saturating_mul(references));
        most.min(left.count(cells.bytes))
    }

    /// The most references beside so many cells.
    pub(crate) fn references_beside(&self, cells: u64) -> u64 {
        let [(counted, _), (references, most)] = self.parts;
        let left = self.limits.memory.beside(counted.bytes.saturating_mul(cells));
        most.min(left.count(references.bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::MemoryLimit;

    #[test]
    fn cells_and_references_share_memory() {
        static CELLS: CountedItem = CountedItem::cells("number of cells", 16);
        static REFERENCES: CountedItem = CountedItem::references("references in cells");
        let within = |memory| Limits { structure: "kd-tree", memory };
        let limits = within(MemoryLimit::new(200));
        let room = CapacityLimits::new(limits, [(&CELLS, 10), (&REFERENCES, 20)]);
        assert_eq!((room.most_cells(), room.references_beside(10)), (10, 10));
        assert_eq!((room.references_beside(0), room.references_beside(100)), (20, 0));
        assert_eq!(
            (room.cells_beside(0), room.cells_beside(20), room.cells_beside(50)),
            (10, 7, 0)
        );
        assert!(room.check([10, 10]).is_ok() && room.check([7, 20]).is_ok());
        // each within its limit, not both
        let said = |needed| room.check(needed).unwrap_err().to_string();
        assert!(said([10, 11]).ends_with("more than the limit of 200 bytes"), "{}", said([10, 11]));
        for (needed, what) in [([11, 0], "number of cells"), ([0, 21], "references in cells")] {
            assert!(said(needed).contains(what), "{}", said(needed));
        }
        // no limit of memory: those of settings alone
        let limits = within(MemoryLimit::NONE);
        let room = CapacityLimits::new(limits, [(&CELLS, 1000), (&REFERENCES, 2000)]);
        assert_eq!((room.most_cells(), room.references_beside(u64::MAX)), (1000, 2000));
    }
}
