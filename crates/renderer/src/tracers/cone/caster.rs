//! A scene made ready for cones, and how a cone leaves its surfaces.

use glam::DVec3;
use scene_loading::{Rgb, Scene};

use super::circular_cone::Cone;
use super::coverage::DepartedSurface;
use super::forms::Forms;
use super::settings::Settings;
use super::widening::LEAST_COSINE;
use crate::effects::{ImageColors, SurfaceHit, lights};
use crate::shading::ray_offset::{OffsetRule, RayOffset};
use crate::shading::surface::Surfaces;
use crate::tracers::info::Structures;

/// A surface that is seen in less than this share of a cone is not shaded.
pub(super) const UNSEEN: f64 = 1e-6;

/// Distance by which rounding may move neighbours in the plane of a flat surface off it, in
/// epsilons of its largest coordinate.
const PLANE_SLACK: f64 = 64.0 * f64::EPSILON;

/// A scene made ready for cones.
pub struct Caster<'a> {
    pub(super) scene: &'a Scene,
    pub(super) surfaces: Surfaces<'a>,
    pub(super) forms: Forms,
    pub(super) offset: RayOffset,
    /// Centre, colour and radius.
    pub(super) lights: Vec<(DVec3, Rgb, f64)>,
    pub(super) textures: ImageColors<'a>,
    pub(super) bounds: [DVec3; 2],
    pub(super) max_depth: u32,
    pub(super) settings: Settings,
    pub(super) over: Structures<'a>,
}

/// Contribution of a bundle, and its place in the ray tree.
#[derive(Clone, Copy)]
pub(super) struct Path {
    /// Contribution by colour channel.
    pub weight: Rgb,
    /// 1 for those from the eye.
    pub depth: u32,
    /// How often it was cut.
    pub level: u32,
}

impl<'a> Caster<'a> {
    pub fn new(scene: &'a Scene, settings: Settings, max_depth: u32, over: Structures<'a>) -> Self {
        let bounds = scene.bounds();
        Self {
            scene,
            surfaces: Surfaces::new(scene, false),
            forms: Forms::new(scene),
            // this rule asks for no magnitude
            offset: RayOffset::new(OffsetRule::default(), 0.0),
            lights: lights(scene),
            textures: ImageColors(scene),
            bounds: [bounds.min, bounds.max],
            max_depth,
            settings,
            over,
        }
    }

    /// The surface that a bundle leaves along a direction.
    pub(super) fn departed_surface(
        &self,
        hit: &SurfaceHit<'_>,
        direction: DVec3,
    ) -> DepartedSurface {
        let refined = hit.point.refined;
        let inwards = direction.dot(refined.normal) < 0.0;
        // within a convex body, all of it is on the inner side of the surface
        let is_one_sided = self.forms.is_flat(hit.id) || self.forms.is_ball(hit.id) && inwards;
        let plane = is_one_sided.then(|| {
            let normal = if inwards { -refined.normal } else { refined.normal };
            (normal, normal.dot(refined.position) + PLANE_SLACK * refined.magnitude)
        });
        DepartedSurface { id: hit.id, inwards, plane }
    }

    /// The cone that leaves a flat surface begins where its edge does, before its middle.
    pub(super) fn start_at_edge(&self, mut cone: Cone, left: &DepartedSurface) -> Cone {
        if let Some((normal, _)) = left.plane.filter(|_| self.forms.is_flat(left.id)) {
            let cosine = cone.axis.dot(normal).clamp(LEAST_COSINE, 1.0);
            let slope = (1.0 - cosine * cosine).sqrt() / cosine;
            // the edge recedes from the axis as the cone spreads
            cone.begin = -cone.radius * slope / (1.0 + cone.spread * slope).max(0.1);
        }
        cone
    }
}
