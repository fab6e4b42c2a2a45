//! Cone tracing: one cone per pixel in place of rays; what it covers is estimated as an area.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984. Deviations: areas are exact where
//! the paper estimates (`disc_overlap`); estimates that may be wrong are noticed, and the cone is
//! then cut into four; truncated cones and cylinders, which the paper lacks, are covered by their
//! visible outline; oblique reflection (`widening`).
//!
//! The lecture asks three things of a bundle of rays:
//!
//! * *How are rays cut into bundles?* A pixel's cone has the area of the pixel, a disc in place of
//!   a square: neighbours overlap by 9% of their area, and an edge is blurred as by a disc, which
//!   differs from a box by at most 2.5% of coverage. From each surface that is seen, one cone is
//!   mirrored, one refracted, and one goes to each light, as wide as the footprint of what is seen.
//!   A cone is cut into the quarters of its square ([`circular_cone::Cone::quarters`]) where its
//!   estimate fails: outlines overlap or cross ([`compose`]), the normal turns by more than
//!   [`Settings::turn`] across the footprint, or the cone is wide. It happens at most
//!   [`Settings::subdivisions`] times in a path.
//! * *How good is the approximation?* A cone sees one point of each surface, the middle of what is
//!   visible of it: light, colour and texture are those of that point. A reflected cone is round
//!   where the true bundle is elliptic, and not wider than 45 degrees. Where outlines still
//!   overlap, shares are guessed. A shadow's edge is blurred by the footprint and by the disc of
//!   the light as one disc. Cones that contribute less than [`Settings::ray_below`] go on as rays.
//! * *How does a bundle meet surfaces?* Candidates come from the structure, by a pyramid around the
//!   cone, near ones first, until the cone is covered. Each is an outline on the cone's section: a
//!   sphere a disc (`cover_sphere`), a polygon itself (`cover_flat`), the side of a truncated
//!   cone its visible part (`cover_side`). Its share is an area, and shares are added up front to
//!   back ([`compose`]).

pub mod circular_cone;
pub mod compose;
mod cover_flat;
mod cover_side;
mod cover_sphere;
pub mod coverage;
mod disc_overlap;
pub mod forms;
mod fragments;
mod shadows;
mod tracing;
mod widening;

use accel_core::query::region::{Candidates, FrustumWork};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use scene_loading::{Rgb, Scene};

use super::info::{DrawnImage, Frame, Refusal, Structures, TracerInfo, counts};
use crate::camera::{EyeRays, Sampling};
use crate::effects::{ImageColors, SurfaceHit, lights};
use crate::film::Image;
use crate::ray_offset::{OffsetRule, RayOffset};
use crate::surface::Surfaces;
use circular_cone::{Cone, DepartedSurface};
use forms::Forms;
use widening::LEAST_COSINE;

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

/// Draws the scene, in the current rayon pool. The same image for any number of threads and any
/// right structure.
///
/// # Errors
/// As [`refusal`].
pub fn draw(
    scene: &Scene,
    frame: Frame,
    settings: &Settings,
    over: Structures<'_>,
) -> Result<DrawnImage, Refusal> {
    refusal(scene)?;
    let [width, height] = frame.resolution;
    let eye = EyeRays::new(&scene.camera, frame.resolution, Sampling::PixelCentres);
    let caster = Caster::new(scene, *settings, frame.max_depth, over);
    let row = |y: u32| {
        let mut tracer = ConeTracer::new(&caster);
        let cone = |x: u32| pixel_cone(&eye, [x, y], settings.width);
        let colors: Vec<Rgb> = (0..width).map(|x| tracer.look(cone(x))).collect();
        (colors, tracer.candidates.work, tracer.counts)
    };
    let rows: Vec<(Vec<Rgb>, FrustumWork, Counts)> = (0..height).into_par_iter().map(row).collect();
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    let (mut work, mut counts) = (FrustumWork::default(), Counts::default());
    for (mut colors, more_work, more_counts) in rows {
        pixels.append(&mut colors);
        work += more_work;
        counts += more_counts;
    }
    let counts = counts.rows();
    Ok(DrawnImage { image: Image { width, height, pixels }, work, counts })
}

/// The cone of a pixel: as large as it, seen from the eye.
fn pixel_cone(eye: &EyeRays, [x, y]: [u32; 2], width: f64) -> Cone {
    let at = |u: f64, v: f64| eye.direction_within(x, y, DVec2::new(u, v));
    let right = at(1.0, 0.5) - at(0.0, 0.5);
    let up = at(0.5, 0.0) - at(0.5, 1.0);
    let radius = (right.cross(up).length() / std::f64::consts::PI).sqrt();
    Cone::new(eye.origin(), eye.direction(x, y), 0.0, radius * width).across(right, up)
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

    /// The same cone as one that leaves a surface along a direction. Off a flat one it begins where
    /// its edge does, before its middle.
    pub(super) fn leaving(&self, hit: &SurfaceHit<'_>, direction: DVec3, cone: Cone) -> Cone {
        let refined = hit.point.refined;
        let inwards = direction.dot(refined.normal) < 0.0;
        let is_flat = self.forms.is_flat(hit.id);
        let normal = if inwards { -refined.normal } else { refined.normal };
        // within a convex body, all of it is on the inner side of the surface
        let is_one_sided = is_flat || self.forms.is_ball(hit.id) && inwards;
        let at = normal.dot(refined.position) + PLANE_SLACK * refined.magnitude;
        let plane = is_one_sided.then_some((normal, at));
        let mut begin = cone.begin;
        if is_flat {
            let cosine = cone.axis.dot(normal).clamp(LEAST_COSINE, 1.0);
            let slope = (1.0 - cosine * cosine).sqrt() / cosine;
            // the edge recedes from the axis as the cone spreads
            begin = -cone.radius * slope / (1.0 + cone.spread * slope).max(0.1);
        }
        Cone { begin, left: Some(DepartedSurface { id: hit.id, inwards, plane }), ..cone }
    }
}

/// Traces pixel after pixel.
struct ConeTracer<'c, 'a> {
    on: &'c Caster<'a>,
    /// What the pixel has of the bundles that are traced.
    color: Rgb,
    /// Memory of the candidate queries, and their cost.
    candidates: Candidates,
    counts: Counts,
}

impl<'c, 'a> ConeTracer<'c, 'a> {
    fn new(on: &'c Caster<'a>) -> Self {
        let (candidates, counts) = (Candidates::default(), Counts::default());
        Self { on, color: [0.0; 3], candidates, counts }
    }
}

counts! {
    cones: "cones",
    shadow_cones: "shadow cones",
    subdivided: "cones cut into four",
    rays: "rays",
    shadow_rays: "shadow rays",
}
