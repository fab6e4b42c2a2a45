//! A set of whichever primitives, as scenes have them.

#![warn(missing_docs)]

use super::{MixedSet, TriangleSet};
use crate::geometry::scalar::Scalar;

/// A set of primitives, whichever.
pub enum PrimsRef<'a, S: Scalar> {
    /// Triangles with the watertight test.
    Watertight(&'a TriangleSet<S>),
    /// Primitives of any kind.
    Mixed(&'a MixedSet<S>),
}

impl<S: Scalar> Clone for PrimsRef<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Scalar> Copy for PrimsRef<'_, S> {}
