//! What a query needs: the committed scene and whose ids its primitives have.

use super::library::Library;
use crate::geometry::scalar::Scalar;
use crate::structures::obvhs::adapter::RaySetup;

/// A scene of Embree over our primitives.
pub(super) struct Scene<S: Scalar> {
    pub(super) library: Library,
    pub(super) setup: RaySetup<S>,
    /// Ids of the triangles that the library tests.
    pub(super) triangle_ids: Vec<u32>,
    /// Ids of the primitives that it knows the boxes of.
    pub(super) boxed_ids: Vec<u32>,
    pub(super) is_native: bool,
}
