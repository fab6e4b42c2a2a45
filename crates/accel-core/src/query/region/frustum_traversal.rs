//! Structures that answer frustum queries.

use std::ops::ControlFlow;

use super::frustum::Frustum;
use crate::structure::Structure;

/// A structure that can be traversed by a frustum.
pub trait FrustumTraversal: Structure<f64> {
    /// Calls `cell` with the ids of every cell that the frustum meets, some of them more than once,
    /// and with a depth ([`Frustum::depth`]) that neither this cell nor any later one begins
    /// before. Ends when `cell` breaks.
    fn traverse_frustum(
        &self,
        frustum: &Frustum,
        cell: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    );
}
