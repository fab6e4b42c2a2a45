//! Structures kept from one frame to the next, whose primitives are others then.

use std::any::Any;

use crate::geometry::scalar::Scalar;
use crate::query::kernel::ListBlocks;
use crate::structure::Structure;

/// A structure apart from the primitives of its frame.
pub struct KeptStructure(Box<dyn Any + Send>);

pub struct PreviousFrame<'m> {
    pub kept: KeptStructure,
    /// Ids of the primitives that stand elsewhere now or have another shape, ascending. All others
    /// are the same.
    pub moved: &'m [u32],
}

/// A structure and the blocks of its lists.
pub(crate) struct Parts<S, T> {
    pub(crate) structure: T,
    pub(crate) blocks: Option<ListBlocks<S>>,
    /// Number of items.
    pub(crate) primitives: usize,
}

impl KeptStructure {
    pub(crate) fn new<S: Scalar, T: Structure<S>>(parts: Parts<S, T>) -> Self {
        Self(Box::new(parts))
    }
}

impl<'m> PreviousFrame<'m> {
    /// The structure, if it is a `T`.
    pub(crate) fn parts<S: Scalar, T: Structure<S>>(self) -> Option<(Parts<S, T>, &'m [u32])> {
        let parts = self.kept.0.downcast::<Parts<S, T>>().ok()?;
        Some((*parts, self.moved))
    }
}
