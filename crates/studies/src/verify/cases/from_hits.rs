//! Rounds of rays that leave what other rays hit.

use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Vector};
use glam::DVec3;
use renderer::Geometry;
use renderer::surface::{SurfacePoint, Surfaces};
use scene_loading::Scene;

use crate::verify::model::Model;
use crate::verify::round::Round;
use crate::verify::subject::with_brute_force;

/// A round of what `leave` makes of the points that brute force finds with `aimed`, as the renderer
/// sees them, and of the directions that hit them.
pub(super) fn from_hits<S: Buildable>(
    scene: &Scene,
    aimed: &[Ray<S>],
    mut leave: impl FnMut(&SurfacePoint<'_>, DVec3, &mut Round<S>),
) -> Result<Round<S>, PrimitiveError> {
    let mut round = Round::new(model_of(scene)?);
    let surfaces = Surfaces::new(scene, false);
    let mut hits = vec![Hit::NONE; aimed.len()];
    // without brute force there is no hit and so no ray: the case would have no trials
    let _ = with_brute_force(round.model.prims(), |tracer| tracer.closest_hits(aimed, &mut hits));
    for (ray, hit) in aimed.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        let along = ray.direction.to_dvec3();
        let position = ray.origin.to_dvec3() + along * hit.t.to_f64();
        leave(&surfaces.at(hit.id, position), along, &mut round);
    }
    Ok(round)
}

fn model_of<S: Buildable>(scene: &Scene) -> Result<Model<S>, PrimitiveError> {
    Ok(match Geometry::<S>::of(scene).map_err(|e| e.source)? {
        Geometry::Triangles(set) => Model::Triangles(set),
        Geometry::Mixed(set) => Model::Mixed(set),
    })
}
