//! Kind of a primitive and index within its kind, packed in one word.

use crate::primitives::PrimitiveKind;

/// The kind in the upper two bits, the index within the kind below.
#[derive(Debug, Clone, Copy)]
pub(super) struct TaggedIndex(u32);

/// Bits of an index.
pub(super) const INDEX_BITS: u32 = 30;

impl TaggedIndex {
    pub fn new(kind: PrimitiveKind, index: usize) -> Self {
        Self((kind as u32) << INDEX_BITS | index as u32)
    }
    #[inline(always)]
    pub fn kind(self) -> PrimitiveKind {
        match self.0 >> INDEX_BITS {
            0 => PrimitiveKind::Triangle,
            1 => PrimitiveKind::Polygon,
            2 => PrimitiveKind::Sphere,
            _ => PrimitiveKind::Cone,
        }
    }
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & ((1 << INDEX_BITS) - 1)) as usize
    }
}
