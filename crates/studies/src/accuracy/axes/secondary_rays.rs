//! Parts shared by the axes of secondary rays: hit points of eye rays on flat primitives and on
//! spheres seen from outside, and the rays that a rule makes there, as the renderer does.

use accel_core::query::tracer::Tracer;
use accel_core::{Hit, Ray, Scalar, Vector};
use glam::DVec3;
use measurement::plan::ray_overrides::RULES;
use measurement::rays::batches::{Answers, trace};
use renderer::ray_offset::{OffsetRule, RayOffset};
use renderer::surface::{SurfacePoint, Surfaces};
use renderer::{Geometry, RayKind};
use scene_loading::{Scene, Shape};
use statistics::random::Random;

use crate::accuracy::axis::*;
use crate::verify::draw::direction;

/// How near something may stand, in diagonals of the scene, and still be met.
pub const GAP: f64 = 1e-5;

/// A hit of an eye ray, and where a ray goes from there.
#[derive(Debug, Clone, Copy)]
pub struct Departure {
    pub id: u32,
    /// Hit point, as the renderer has it: with the rounding of the eye ray's parameter.
    pub position: DVec3,
    /// Unit direction of the eye ray.
    pub incoming: DVec3,
    /// Unit direction into the half-space that the eye ray came from.
    pub out: DVec3,
}

/// Target of a ray from a surface.
#[derive(Debug, Clone, Copy)]
pub enum RayPurpose {
    /// Along a unit direction.
    Along(DVec3),
    /// To a point, which is asked for like any other ray.
    To(DVec3),
}

/// Rays to make: the points they leave, and where they go.
pub type Ways<'a> = Vec<(SurfacePoint<'a>, RayPurpose)>;

/// Columns of a variant, by name.
pub type Columns = Vec<(&'static str, f64)>;

/// Points of surfaces that rays leave, and who answers those.
pub struct SecondaryRays<'a> {
    pub surfaces: Surfaces<'a>,
    /// Origins; the first ones are all different hits.
    pub departures: Vec<Departure>,
    pub tracer: Box<dyn Tracer<f32> + 'a>,
    /// Largest coordinate of the scene and the eye.
    pub magnitude: f64,
    /// Diagonal of the scene, world units.
    pub diagonal: f64,
}

impl<'a> SecondaryRays<'a> {
    /// Hits of the eye rays of the stage in `scene`, which is the stage's, perhaps moved.
    ///
    /// # Errors
    /// `Error` when no surface is seen that is not left twice by right: flat, or a sphere from
    /// outside.
    pub fn new(
        stage: &Stage<'_>,
        scene: &'a Scene,
        geometry: &'a Geometry<f32>,
    ) -> Result<Self, StudyError> {
        let tracer = stage.over(TRACER, geometry)?.tracer;
        let eye = scene.camera.from;
        let by = eye - stage.scene().camera.from;
        let batches = stage.batches(stage.limits.timed_rays, |kind| kind == RayKind::Primary);
        let moved = |ray: &Ray<f32>| Ray { origin: (ray.origin.to_dvec3() + by).as_vec3(), ..*ray };
        let eye_rays: Vec<_> = batches.iter().flat_map(|(_, rays)| rays).map(moved).collect();
        let mut hits = vec![Hit::NONE; eye_rays.len()];
        tracer.closest_hits(&eye_rays, &mut hits);
        let surfaces = Surfaces::new(scene, false);
        let mut random: Random = stage.random("directions");
        let mut departures = Vec::new();
        let seen = eye_rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit());
        // several rays leave each hit
        for (ray, hit) in seen.cycle().take(stage.limits.aims) {
            let incoming = ray.direction.to_dvec3();
            let position = ray.origin.to_dvec3() + incoming * f64::from(hit.t);
            let normal = surfaces.at(hit.id, position).refined.normal;
            let shape = scene.primitives.get(hit.id as usize).map(|p| p.shape);
            let is_inside = matches!(shape, Some(Shape::Sphere(_))) && incoming.dot(normal) > 0.0;
            if normal == DVec3::ZERO || matches!(shape, Some(Shape::Cone(_))) || is_inside {
                continue;
            }
            let facing = if incoming.dot(normal) > 0.0 { -normal } else { normal };
            let any = direction(&mut random);
            let out = if any.dot(facing) < 0.0 { -any } else { any };
            departures.push(Departure { id: hit.id, position, incoming, out });
        }
        if departures.is_empty() {
            return Err(stage.unfit("the eye sees no flat primitive and no sphere"));
        }
        let magnitude = scene.bounds().min.abs().max(scene.bounds().max.abs()).max(eye.abs());
        let (magnitude, diagonal) = (magnitude.max_element(), diagonal(scene));
        Ok(Self { surfaces, departures, tracer, magnitude, diagonal })
    }

    pub fn point(&self, departure: &Departure) -> SurfacePoint<'a> {
        self.surfaces.at(departure.id, departure.position)
    }

    pub fn outward(&self) -> Ways<'a> {
        self.departures.iter().map(|d| (self.point(d), RayPurpose::Along(d.out))).collect()
    }

    /// The rays of a rule, made and traced.
    pub fn work(&self, rule: OffsetRule, ways: Ways<'a>) -> SecondaryWork<'_> {
        let offset = RayOffset::new(rule, self.magnitude);
        let rays: Vec<Ray<f32>> = ways.iter().map(|way| made(offset, way)).collect();
        let mut hits = vec![Hit::NONE; rays.len()];
        self.tracer.closest_hits(&rays, &mut hits);
        SecondaryWork { ways, offset, tracer: &*self.tracer, rays, hits }
    }
}

/// A ray from a surface.
fn made(offset: RayOffset, (point, purpose): &(SurfacePoint<'_>, RayPurpose)) -> Ray<f32> {
    match *purpose {
        RayPurpose::Along(direction) => offset.along(point, direction),
        RayPurpose::To(target) => offset.to(point, target),
    }
}

pub struct SecondaryWork<'a> {
    ways: Ways<'a>,
    offset: RayOffset,
    tracer: &'a dyn Tracer<f32>,
    rays: Vec<Ray<f32>>,
    hits: Vec<Hit<f32>>,
}

impl<'a> SecondaryWork<'a> {
    /// The left surface point, the ray and its answer.
    pub fn outcomes(&self) -> impl Iterator<Item = (&SurfacePoint<'a>, &Ray<f32>, &Hit<f32>)> {
        let outcomes = self.ways.iter().zip(&self.rays).zip(&self.hits);
        outcomes.map(|(((point, _), ray), hit)| (point, ray, hit))
    }

    /// A row for the rule of that name: the work is timed with at most `most` rays.
    pub fn variant(self, name: &str, error: ErrorOf, most: usize) -> Variant<'a> {
        let Self { mut ways, offset, tracer, mut rays, .. } = self;
        ways.truncate(most);
        let answers = vec![Answers::new(RayKind::Diffuse, ways.len())];
        let work = Replay::answered_by(answers, move |_, answers| {
            rays.clear();
            rays.extend(ways.iter().map(|way| made(offset, way)));
            trace(tracer, &rays, answers);
        });
        let is_reference = RULES.contains(&(name, OffsetRule::default()));
        let setting = format!("run --set rays.offset={name}");
        Variant::new(name, setting, error, work).as_reference(is_reference)
    }
}

/// The height over the surface of the first point of a ray that counts.
pub fn height<S: Scalar>(point: &SurfacePoint<'_>, ray: &Ray<S>) -> f64 {
    let along = ray.direction.to_dvec3();
    let first = ray.origin.to_dvec3() + along * ray.t_min.to_f64();
    let outward = point.refined.normal * point.refined.normal.dot(along).signum();
    (first - point.refined.position).dot(outward)
}

/// The part `share` of values in rising order; NaN when there are none.
pub fn quantile(rising: &[f64], share: f64) -> f64 {
    let last = rising.len().saturating_sub(1);
    rising.get((last as f64 * share).round() as usize).copied().unwrap_or(f64::NAN)
}
