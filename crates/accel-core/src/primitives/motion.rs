//! How the primitives of a set move (see `moving.rs`).

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};

/// How the primitives of a set move.
#[derive(Debug, Clone)]
pub(crate) struct Motion<S: Scalar> {
    /// World units a unit of time, by id; those beyond the end are at rest.
    velocities: Vec<[S; 3]>,
    /// They move from time 0 to this one.
    exposure: S,
}

impl<S: Scalar> Default for Motion<S> {
    fn default() -> Self {
        Self { velocities: Vec::new(), exposure: S::ZERO }
    }
}

impl<S: Scalar> Motion<S> {
    /// Lets a primitive move.
    pub fn set(&mut self, id: u32, velocity: DVec3, exposure: f64) {
        let index = id as usize;
        if self.velocities.len() <= index {
            self.velocities.resize(index + 1, [S::ZERO; 3]);
        }
        self.velocities[index] = Vec3::<S>::from_dvec3(velocity).to_array();
        self.exposure = S::from_f64(exposure);
    }

    /// Whether anything moves.
    pub fn any(&self) -> bool {
        !self.velocities.is_empty()
    }

    /// Its velocity, if it moves.
    #[inline(always)]
    pub(crate) fn velocity(&self, id: u32) -> Option<Vec3<S>> {
        let v = *self.velocities.get(id as usize)?;
        (v != [S::ZERO; 3]).then(|| Vec3::<S>::from_array(v))
    }

    /// From where a primitive starts to where it ends.
    pub fn way(&self, id: u32) -> DVec3 {
        self.velocity(id).map_or(DVec3::ZERO, |v| (v * self.exposure).to_dvec3())
    }

    /// Bounds of the whole way, from those at time 0. Rounding is left to the padding of boxes.
    pub fn swept(&self, id: u32, still: Aabb<S>) -> Aabb<S> {
        let Some(velocity) = self.velocity(id) else { return still };
        let way = velocity * self.exposure;
        if !way.is_finite() {
            return Aabb { min: way, max: way };
        }
        still.union(Aabb { min: still.min + way, max: still.max + way })
    }

    /// Extent of the whole way along `direction`, from that at time 0.
    pub fn swept_extent(&self, id: u32, still: (f64, f64), direction: DVec3) -> (f64, f64) {
        let along = self.way(id).dot(direction);
        (still.0.min(still.0 + along), still.1.max(still.1 + along))
    }

    /// Bytes of the velocities.
    pub fn bytes(&self) -> usize {
        size_of_val(self.velocities.as_slice())
    }
}
