//! Settings of cone tracing, the scenes that it does not support (motion, lenses and rough mirrors),
//! a scene made ready for it, how a cone leaves its surfaces, and the numbers of cones of an image.

use accel_core::query::region::Candidates;
use glam::DVec3;
use scene_loading::{Rgb, Scene};

use super::circular_cone::Cone;
use super::coverage::DepartedSurface;
use super::forms::Forms;
use super::widening::LEAST_COSINE;
use crate::effects::{ImageColors, SurfaceHit, lights};
use crate::ray_offset::{OffsetRule, RayOffset};
use crate::surface::Surfaces;
use crate::tracers::info::{Refusal, Structures, TracerInfo};

pub static INFO: TracerInfo = TracerInfo {
    name: "cone",
    summary: "one cone per pixel: covered areas instead of samples, also for soft shadows",
    paper: "Amanatides 1984",
    assumptions: "a pixel is a disc; a surface is shaded at the middle of its visible part; \
                  cones stay round; shares of outlines that still overlap are estimated",
    deviations: "exact areas; cut into four where the estimate fails; oblique reflection; sides of \
                 truncated cones",
    refuses: "motion, a lens, rough mirrors",
};

/// How cones are traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How often a cone is cut into four where its estimate fails; 0 is the paper's plain estimate.
    pub subdivisions: u32,
    /// A cone is cut where the normal turns by more than this across its footprint, radians.
    pub turn: f64,
    /// Radius of a pixel's cone over that of a disc with the pixel's area; 0 traces rays.
    pub width: f64,
    /// True if curved surfaces change the spread of a cone. Without, reflections are wrong: it
    /// shows what that is worth.
    pub widening: bool,
    /// Cones that contribute less than this part of a pixel go on as rays; those from surfaces
    /// within one cone as one ray.
    pub ray_below: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { subdivisions: 2, turn: 0.5, width: 1.0, widening: true, ray_below: 1.0 / 64.0 }
    }
}

/// Checks that cones can draw the scene.
///
/// # Errors
/// [`Refusal`] for what moves while the shutter is open, a lens with an extent and rough mirrors.
pub fn refusal(scene: &Scene) -> Result<(), Refusal> {
    let moving = scene.velocities.iter().take(scene.primitives.len());
    let moving = moving.filter(|v| **v != DVec3::ZERO && scene.camera.shutter > 0.0).count();
    Refusal::of(&INFO, scene, moving, "primitives that move while the shutter is open")?;
    let lenses = usize::from(scene.camera.aperture > 0.0);
    Refusal::of(&INFO, scene, lenses, "lens with an extent")?;
    let is_rough = |p: &&scene_loading::Primitive| {
        let material = scene.materials.get(p.material as usize);
        material.is_some_and(|m| m.specular > 0.0 && m.roughness > 0.0)
    };
    let rough = scene.primitives.iter().filter(is_rough).count();
    Refusal::of(&INFO, scene, rough, "primitives with a rough mirror")
}

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

/// Numbers of cones and rays of an image.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    pub(super) cones: u64,
    pub(super) subdivided: u64,
    pub(super) shadow_cones: u64,
    pub(super) rays: u64,
    pub(super) shadow_rays: u64,
}

impl Counts {
    pub fn rows(self) -> Vec<(&'static str, u64)> {
        vec![
            ("cones", self.cones),
            ("shadow cones", self.shadow_cones),
            ("cones cut into four", self.subdivided),
            ("rays", self.rays),
            ("shadow rays", self.shadow_rays),
        ]
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.cones += other.cones;
        self.subdivided += other.subdivided;
        self.shadow_cones += other.shadow_cones;
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
    }
}

/// Scratch memory of a tracing thread.
#[derive(Default)]
pub struct Scratch {
    /// Memory of the candidate queries, and their cost.
    pub candidates: Candidates,
    pub counts: Counts,
}
