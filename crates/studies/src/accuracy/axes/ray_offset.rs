//! What keeps a ray off the surface it leaves: self-hits against leaks.
//!
//! From each hit of an eye ray a ray leaves into the outer half-space, made as the renderer makes
//! it. Two demands are exact: flat primitives and spheres, seen from outside, are never met again by
//! a ray that leaves them; and a thin sheet that lies close above the surface is not passed, so
//! that the first point of the ray that counts lies below it.

use accel_core::tracer::Tracer;
use accel_core::{Hit, Ray, Vector};
use glam::DVec3;
use renderer::leaving::{Leaving, OffsetRule};
use renderer::surface::{SurfacePoint, Surfaces};
use renderer::{Geometry, RayKind};
use scene_loading::{Scene, Shape};

use crate::accuracy::axis::Axis;
use crate::accuracy::error_of::Tally;
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::stage::{Stage, TRACER, fingerprint};
use crate::accuracy::timing::{Said, Variant, timed};
use crate::accuracy::work::Work;
use crate::error::StudyError;
use crate::verify::draw::direction;
use measurement::plan::ray_overrides::RULES;
use measurement::plan::rows::Row;
use measurement::rays::batches::Answers;
use statistics::random::Random;

/// Registry line.
pub static AXIS: Axis = Axis {
    name: "ray-offset",
    summary: "how a ray is kept off the surface it leaves: not at all, fixed, ulps, error bound",
    paper: "Waechter, Binder 2019; Pharr, Jakob, Humphreys 2016",
    metric: "rays in 10^6 that hit what they leave, or begin beyond a sheet close above it",
    reference: "a plane or a sphere is not met again from outside; height over the surface",
    scenes: &["balls", "teapot", "pavilion"],
    setting: "rays.offset",
    measure,
};

/// Height of the sheet, in diagonals of the scene.
const GAP: f64 = 1e-5;

/// How far a scene is moved, in its diagonals, to see what is left of the rule there.
const MOVED: f64 = 100.0;

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let scene = stage.scene();
    let here = Leavings::new(stage, scene, &stage.prepared.geometry)?;
    let moved = moved(scene);
    let moved_geometry = Geometry::<f32>::of(&moved)?;
    let there = Leavings::new(stage, &moved, &moved_geometry)?;
    let mut variants = Vec::new();
    for (name, rule) in RULES {
        let found = here.judged(rule);
        let far = there.judged(rule);
        let mut tally = Tally::default();
        tally.add_all(found.self_hits + found.leaks, found.trials);
        let share = |n: u64, all: u64| n as f64 / all.max(1) as f64 * 1e6;
        variants.push(Variant {
            name: name.into(),
            setting: format!("run --set rays.offset={name}"),
            known_defect: None,
            is_reference: rule == OffsetRule::default(),
            error: tally.error(),
            also: vec![
                ("self-hits in 10^6", share(found.self_hits, found.trials)),
                ("leaks in 10^6", share(found.leaks, found.trials)),
                ("self-hits in 10^6 100 diagonals away", share(far.self_hits, far.trials)),
            ],
            work: Box::new(here.work(rule, stage.timed_rays)),
        });
    }
    let said = Said {
        timed: format!(
            "{} rays made and traced through {TRACER}",
            here.points.len().min(stage.timed_rays)
        ),
        judged: format!(
            "{} rays from flat primitives and spheres; a sheet {GAP:e} diagonals above",
            here.points.len()
        ),
        ..Said::default()
    };
    Ok(timed(stage, said, variants))
}

/// The scene somewhere else.
fn moved(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let by = DVec3::new(0.62, -0.54, 0.57) * diagonal(&scene) * MOVED;
    scene.vertices.iter_mut().for_each(|v| *v += by);
    scene.spheres.iter_mut().for_each(|s| s.center += by);
    for cone in &mut scene.cones {
        cone.base += by;
        cone.apex += by;
    }
    scene.camera.from += by;
    scene.camera.at += by;
    scene
}

fn diagonal(scene: &Scene) -> f64 {
    scene.bounds().size().length()
}

/// Points of surfaces, and the directions in which rays leave them.
struct Leavings<'a> {
    surfaces: Surfaces<'a>,
    /// Primitive, hit point, direction.
    points: Vec<(u32, DVec3, DVec3)>,
    tracer: Box<dyn Tracer<f32> + 'a>,
    magnitude: f64,
    gap: f64,
}

/// What came of a rule.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    trials: u64,
    self_hits: u64,
    leaks: u64,
}

impl<'a> Leavings<'a> {
    fn new(
        stage: &Stage<'_>,
        scene: &'a Scene,
        geometry: &'a Geometry<f32>,
    ) -> Result<Self, StudyError> {
        let row = Row::parse(stage.registry, TRACER)?;
        let tracer =
            row.entry.build(geometry.prims(), &row.params).map_err(|e| stage.refused(e))?;
        let eye = scene.camera.from;
        let by = eye - stage.scene().camera.from;
        let sheets = stage.sheets(stage.timed_rays, |kind| kind == RayKind::Primary);
        let eye_rays = sheets.iter().flat_map(|(_, rays)| rays).map(|ray| {
            let origin = ray.origin.to_dvec3() + by;
            Ray { origin: origin.as_vec3(), ..*ray }
        });
        let eye_rays: Vec<Ray<f32>> = eye_rays.collect();
        let mut hits = vec![Hit::NONE; eye_rays.len()];
        tracer.closest_hits(&eye_rays, &mut hits);
        let surfaces = Surfaces::new(scene, false);
        let mut random: Random = stage.random("directions");
        let mut points = Vec::new();
        let seen = eye_rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit());
        // several rays leave each hit, the first ones all different hits
        for (ray, hit) in seen.cycle().take(stage.aims) {
            let along = ray.direction.to_dvec3();
            let position = ray.origin.to_dvec3() + along * f64::from(hit.t);
            let normal = surfaces.at(hit.id, position).foot.normal;
            let shape = scene.primitives.get(hit.id as usize).map(|p| p.shape);
            let is_inside = matches!(shape, Some(Shape::Sphere(_))) && along.dot(normal) > 0.0;
            if normal == DVec3::ZERO || matches!(shape, Some(Shape::Cone(_))) || is_inside {
                continue;
            }
            let facing = if along.dot(normal) > 0.0 { -normal } else { normal };
            let any = direction(&mut random);
            let out = if any.dot(facing) < 0.0 { -any } else { any };
            points.push((hit.id, position, out));
        }
        if points.is_empty() {
            return Err(stage.unfit("the eye sees no flat primitive and no sphere"));
        }
        let magnitude = scene.bounds().min.abs().max(scene.bounds().max.abs()).max(eye.abs());
        let gap = GAP * diagonal(scene);
        Ok(Self { surfaces, points, tracer, magnitude: magnitude.max_element(), gap })
    }

    fn surface_points(&self, most: usize) -> Vec<(SurfacePoint<'_>, DVec3)> {
        let at =
            |(id, position, out): &(u32, DVec3, DVec3)| (self.surfaces.at(*id, *position), *out);
        self.points.iter().take(most).map(at).collect()
    }

    /// At most so many rays.
    fn work(&self, rule: OffsetRule, most: usize) -> LeavingWork<'_> {
        let points = self.surface_points(most);
        LeavingWork {
            leaving: Leaving::new(rule, self.magnitude),
            tracer: &*self.tracer,
            rays: Vec::with_capacity(points.len()),
            answers: vec![Answers::new(RayKind::Diffuse, points.len())],
            points,
        }
    }

    fn judged(&self, rule: OffsetRule) -> Found {
        let mut work = self.work(rule, self.points.len());
        work.prepare();
        work.run();
        let mut found = Found::default();
        let Some(Answers::Hits(hits)) = work.answers.first() else { return found };
        for (((id, _, out), (point, _)), (ray, hit)) in
            self.points.iter().zip(&work.points).zip(work.rays.iter().zip(hits))
        {
            let outward = point.foot.normal * point.foot.normal.dot(*out).signum();
            let first = ray.origin.to_dvec3() + ray.direction.to_dvec3() * f64::from(ray.t_min);
            found.trials += 1;
            found.self_hits += u64::from(hit.id == *id);
            found.leaks += u64::from((first - point.foot.position).dot(outward) > self.gap);
        }
        found
    }
}

/// Rays made under a rule and traced.
struct LeavingWork<'a> {
    points: Vec<(SurfacePoint<'a>, DVec3)>,
    leaving: Leaving,
    tracer: &'a dyn Tracer<f32>,
    rays: Vec<Ray<f32>>,
    answers: Vec<Answers<f32>>,
}

impl Work for LeavingWork<'_> {
    fn prepare(&mut self) {
        self.answers.iter_mut().for_each(Answers::clear);
    }

    fn run(&mut self) {
        self.rays.clear();
        let made = self.points.iter().map(|(point, out)| self.leaving.along(point, *out));
        self.rays.extend(made);
        if let Some(Answers::Hits(hits)) = self.answers.first_mut() {
            self.tracer.closest_hits(&self.rays, hits);
        }
    }

    fn fingerprint(&self) -> u64 {
        fingerprint(&self.answers)
    }
}
