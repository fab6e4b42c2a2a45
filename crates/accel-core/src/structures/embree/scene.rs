//! What a query needs: the committed scene and whose ids its primitives have.

use super::ffi;
use super::library::Library;
use crate::geometry::scalar::Scalar;
use crate::structures::obvhs::box_ray::RaySetup;

/// A scene of Embree over our primitives.
pub(super) struct Scene<S: Scalar> {
    pub(super) library: Library,
    pub(super) setup: RaySetup<S>,
    /// Ids of the triangles that the library tests.
    pub(super) triangle_ids: Vec<u32>,
    /// Ids of the primitives that it knows the boxes of.
    pub(super) boxed_ids: Vec<u32>,
    pub(super) is_native: bool,
    /// All are triangles at rest in f32, and native: they are as they came, and batches are the library's.
    pub(super) is_direct: bool,
    /// Ids of the triangles that occlude nothing, where it is direct; `triangle_ids` has the others then.
    pub(super) glass_ids: Vec<u32>,
}

impl<S: Scalar> Scene<S> {
    /// The id of a triangle that the library found; `None` where it found nothing.
    #[inline(always)]
    pub(super) fn id(&self, hit: &ffi::Hit) -> Option<u32> {
        match hit.geometry {
            ffi::TRIANGLES => Some(self.triangle_ids[hit.primitive as usize]),
            ffi::GLASS => Some(self.glass_ids[hit.primitive as usize]),
            _ => None,
        }
    }
}
