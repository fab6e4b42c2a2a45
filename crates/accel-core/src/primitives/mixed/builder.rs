//! Collects the primitives of a [`MixedSet`], and refuses those whose numbers do not fit.

use glam::DVec3;

use crate::geometry::ray::MISS;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::primitives::collinear::without_sliver;
use crate::primitives::mixed::MixedSet;
use crate::primitives::polygon::Polygon;
use crate::primitives::prim_set::TaggedIndex;
use crate::primitives::{Cone, PrimitiveError, PrimitiveKind, Primitives, Sphere};

/// Collects primitives in id order.
#[derive(Debug, Default)]
pub struct MixedSetBuilder<S: Scalar> {
    set: MixedSet<S>,
}

impl<S: Scalar> MixedSetBuilder<S> {
    /// Gives the primitive its id, unless its coordinates do not fit.
    fn push(
        &mut self,
        kind: PrimitiveKind,
        count: usize,
        is_finite: bool,
    ) -> Result<(), PrimitiveError> {
        let id = self.set.order.len() as u32;
        let limit = 1 << TaggedIndex::BITS;
        if count > limit as usize || id == MISS {
            return Err(PrimitiveError::TooMany { limit });
        }
        if !is_finite {
            return Err(PrimitiveError::NotFinite { id });
        }
        self.set.order.push(TaggedIndex::new(kind, count - 1));
        Ok(())
    }

    /// Adds a triangle.
    ///
    /// # Errors
    /// [`PrimitiveError`], as every method here; the builder is of no further use then.
    pub fn triangle(&mut self, v: [DVec3; 3]) -> Result<(), PrimitiveError> {
        let v = without_sliver(v.map(|p| Vec3::<S>::from_dvec3(p).to_array()));
        self.set.triangles.push(v);
        let finite = v.as_flattened().iter().all(|x| x.is_finite());
        self.push(PrimitiveKind::Triangle, self.set.triangles.len(), finite)
    }

    /// Adds a polygon; one with three vertices is stored and tested as a triangle (the box rules
    /// of both are the same).
    ///
    /// # Errors
    /// [`PrimitiveError`].
    pub fn polygon(&mut self, vertices: &[DVec3]) -> Result<(), PrimitiveError> {
        if let &[a, b, c] = vertices {
            return self.triangle([a, b, c]);
        }
        let id = self.set.order.len() as u32;
        let first = self.set.polygon_vertices.len();
        let polygon = Polygon::new(vertices, &mut self.set.polygon_vertices)
            .ok_or(PrimitiveError::TooFewVertices { id, vertices: vertices.len() })?;
        self.set.polygons.push(polygon);
        let added = &self.set.polygon_vertices[first..];
        let finite = added.as_flattened().iter().all(|x| x.is_finite());
        self.push(PrimitiveKind::Polygon, self.set.polygons.len(), finite)
    }

    /// Adds a sphere.
    ///
    /// # Errors
    /// [`PrimitiveError`].
    pub fn sphere(&mut self, center: DVec3, radius: f64) -> Result<(), PrimitiveError> {
        if radius < 0.0 {
            return Err(PrimitiveError::NegativeRadius { id: self.set.order.len() as u32 });
        }
        let center = Vec3::<S>::from_dvec3(center);
        let sphere = Sphere { center, radius: S::from_f64(radius) };
        self.set.spheres.push(sphere);
        let finite = sphere.bounds().is_finite();
        self.push(PrimitiveKind::Sphere, self.set.spheres.len(), finite)
    }

    /// Adds a truncated cone; see [`Cone::new`].
    ///
    /// # Errors
    /// [`PrimitiveError`].
    pub fn cone(&mut self, cone: Cone<S>) -> Result<(), PrimitiveError> {
        self.set.cones.push(cone);
        let finite = cone.bounds().is_finite();
        self.push(PrimitiveKind::Cone, self.set.cones.len(), finite)
    }

    /// Lets the last primitive move by `velocity` a unit of time, from time 0 to `exposure`, which
    /// must be the same for all primitives. The last call for a primitive counts.
    ///
    /// # Errors
    /// [`PrimitiveError`] when its way is not finite, or the exposure is negative or not finite.
    pub fn last_moves(&mut self, velocity: DVec3, exposure: f64) -> Result<(), PrimitiveError> {
        let Some(id) = (self.set.order.len() as u32).checked_sub(1) else { return Ok(()) };
        if !(exposure >= 0.0 && exposure.is_finite()) {
            return Err(PrimitiveError::Exposure { id });
        }
        self.set.motion.set(id, velocity, exposure);
        if self.set.bounds(id).is_finite() { Ok(()) } else { Err(PrimitiveError::NotFinite { id }) }
    }

    /// Marks the last primitive as one that lets shadow rays pass.
    pub fn last_is_transmissive(&mut self) {
        if let Some(last) = self.set.order.len().checked_sub(1) {
            self.set.transmissive.insert(last as u32);
        }
    }

    pub fn finish(mut self) -> MixedSet<S> {
        if self.set.has_motion() {
            self.set.motion.settle(self.set.len());
            self.set.moving_spheres = self.set.spheres_with_velocities();
        }
        if !self.set.is_empty() {
            self.set.magnitude = self.set.scene_bounds().magnitude();
        }
        self.set
    }
}
