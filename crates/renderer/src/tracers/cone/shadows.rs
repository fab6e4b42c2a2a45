//! Light that reaches what a cone sees: a cone from there to the light, and the share of it that
//! opaque surfaces cover.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984: a cone to an extended light,
//! whose covered share is the shadow. Deviation: the cone begins as wide as the footprint of what
//! is seen, so that shadows of point lights have antialiased edges, too, and ends as wide as the
//! light. Between them it is as wide as straight lines from edge to edge: the blurs of footprint
//! and light, which are independent, would together be at most by a factor of sqrt(2) narrower. A
//! neighbour in a crease of a mesh, which a round footprint sticks out through, casts no shadow on
//! it ([`super::fragments`]).

use glam::DVec3;
use scene_loading::Rgb;

use super::circular_cone::Cone;
use super::compose::union;
use super::widening::Incidence;
use super::{ConeTracer, Path};
use crate::effects::SurfaceHit;

/// Lights end a shadow cone by this part of the way before them: they may stand on a surface.
const BEFORE_LIGHT: f64 = 1e-9;

/// The cone from a footprint of a radius at `from` to a light.
pub fn shadow_cone(from: DVec3, footprint: f64, light: DVec3, light_radius: f64) -> Cone {
    let way = light - from;
    let length = way.length();
    let axis = way.try_normalize().unwrap_or(DVec3::Z);
    let mut cone = Cone::new(from, axis, footprint, (light_radius - footprint) / length);
    cone.end = length * (1.0 - BEFORE_LIGHT);
    cone
}

impl ConeTracer<'_, '_> {
    /// The share of a shadow cone that opaque surfaces cover, in [0, 1].
    fn blocked(&mut self, cone: &Cone, level: u32) -> f64 {
        self.counts.shadow_cones += 1;
        let mut fragments = self.fragments(cone, true);
        if fragments.iter().any(|f| f.coverage.overlap.share >= 1.0) {
            return 1.0;
        }
        fragments.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.id.cmp(&b.id)));
        let (share, is_certain) = union(&fragments);
        if is_certain || level >= self.on.settings.subdivisions {
            return share;
        }
        self.counts.subdivided += 1;
        let quarters = cone.quarters();
        quarters.iter().map(|part| self.blocked(part, level + 1)).sum::<f64>() / 4.0
    }

    /// The share of a light that is hidden from a surface.
    pub(super) fn shadow(
        &mut self,
        hit: &SurfaceHit<'_>,
        incidence: &Incidence,
        (light, light_radius): (DVec3, f64),
        path: Path,
        arriving: Rgb,
    ) -> f64 {
        let on = self.on;
        let is_little = arriving.into_iter().fold(0.0, f64::max) < on.settings.ray_below;
        if light_radius <= 0.0 && (incidence.radius <= 0.0 || is_little) {
            self.counts.shadow_rays += 1;
            let mut blocked = [false];
            on.over.rays.occlusions(&[on.offset.to(&hit.point, light)], &mut blocked);
            return if blocked[0] { 1.0 } else { 0.0 };
        }
        let refined = hit.point.refined;
        let towards = (light - refined.position).normalize_or(refined.normal);
        // the footprint seen from the light: as on the surface, and foreshortened
        let ratio = refined.normal.dot(towards).abs() / incidence.cosine;
        let cone =
            shadow_cone(refined.position, incidence.radius * ratio.sqrt(), light, light_radius);
        self.blocked(&on.leaving(hit, towards, cone), path.level)
    }
}
