//! What a structure must do to be asked by shafts.

use std::ops::ControlFlow;

use super::shaft::Shaft;
use crate::structure::Structure;

/// A structure that can be walked by a shaft.
pub trait ShaftWalk: Structure<f64> {
    /// Calls `cell` with the ids of every cell that the shaft meets, some of them more than once,
    /// and with a depth ([`Shaft::depth`]) that neither this cell nor any later one begins before.
    /// Ends when `cell` breaks.
    fn walk_shaft(&self, shaft: &Shaft, cell: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>);
}
