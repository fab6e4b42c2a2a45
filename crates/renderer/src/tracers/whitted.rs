//! Classical ray tracing: eye rays, shadow rays to lights, mirror and refracted rays.
//!
//! Paper: T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980; the
//! surface model is that of NFF (E. Haines, Standard Procedural Databases): Kd, Ks, Phong
//! exponent, T, index of refraction.
//!
//! A row of the image is one unit of work: its rays advance breadth first, so that a structure
//! gets whole batches, and its result does not depend on threads. What happens at each step is up
//! to the `Stages`, which are picked before the first ray; a structure and a stage get whole
//! waves at one dynamic call.

use std::ops::Range;

use accel_core::query::tracer::Tracer;
use accel_core::registry::{Buildable, PerScalar, ScalarPair};
use accel_core::{Hit, Ray, Vector};
use glam::DVec3;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use scene_loading::{Rgb, Scene};

use super::info::TracerInfo;
use crate::camera::{EyeRays, Sampling};
use crate::effects::{
    EffectPlan, Origin, RayCounts, ScatteredRay, ShadowRay, Stages, SurfaceHit, Wave, first_light,
    plain_stages,
};
use crate::film::Image;
use crate::ray_offset::{OffsetRule, RayOffset, magnitude};
use crate::rays::{RayBatches, RayKind, RaySettings, ShadowRays};
use crate::surface::Surfaces;

pub static INFO: TracerInfo = TracerInfo {
    name: "whitted",
    summary: "single rays: from the eye, to lights, mirrored and refracted; effects by samples",
    paper: "Whitted 1980; Cook, Porter, Carpenter 1984 (samples)",
    assumptions: "the colour of a pixel is the mean of its samples",
    deviations: "as in NFF, transmissive surfaces also mirror; no falloff of light",
    refuses: "nothing",
};

/// Shadow rays that are made before they are traced, and eye rays of a group of pixels, about:
/// bounds the memory of an image with many samples, and changes no sum.
const BATCH: usize = 1 << 16;

/// A scene made ready for tracing.
pub struct Whitted<'a> {
    surfaces: Surfaces<'a>,
    stages: Stages<'a>,
    grid: [u32; 2],
    background: Rgb,
    max_depth: u32,
    offset: RayOffset,
    /// For rays that are kept: the seed of diffuse bounces, if there are any.
    diffuse: Option<u64>,
}

/// Result of a part of an image row.
pub struct TracedRow<S: Buildable> {
    /// Its rays, if they are kept.
    pub rays: Option<RayBatches<S>>,
    pub counts: RayCounts,
    /// Its colours, left to right.
    pub colors: Vec<Rgb>,
}

/// A closest-hit ray on its way, and what it will contribute to.
#[derive(Clone, Copy)]
struct Path<S: Buildable> {
    ray: Ray<S>,
    origin: Origin,
    weight: Rgb,
}

impl<'a> Whitted<'a> {
    /// Prepares the rays of measurement: one per pixel, hard shadows, perfect mirrors.
    pub fn new(scene: &'a Scene, settings: &RaySettings) -> Self {
        let historical = settings.historical;
        let sampling = if historical { Sampling::PixelCorners } else { Sampling::PixelCentres };
        let eye = EyeRays::new(&scene.camera, settings.resolution, sampling);
        let grid = eye.grid();
        let mut stages = plain_stages(scene, eye, !historical);
        if settings.shadows == ShadowRays::FirstLight {
            stages.lights = first_light(scene, !historical);
        }
        let mut this = Self::with_stages(scene, grid, settings.max_depth, settings.offset, stages);
        this.surfaces = Surfaces::new(scene, historical);
        this.diffuse = settings.diffuse.then_some(settings.seed);
        this
    }

    /// Prepares an image with the effects of a plan.
    pub fn planned(scene: &'a Scene, plan: &EffectPlan) -> Self {
        let settings = plan.settings();
        let eye = EyeRays::new(&scene.camera, settings.resolution, Sampling::PixelCentres);
        let (grid, stages) = (eye.grid(), plan.stages(scene, eye));
        Self::with_stages(scene, grid, settings.max_depth, OffsetRule::default(), stages)
    }

    fn with_stages(
        scene: &'a Scene,
        grid: [u32; 2],
        max_depth: u32,
        offset: OffsetRule,
        stages: Stages<'a>,
    ) -> Self {
        Self {
            surfaces: Surfaces::new(scene, false),
            stages,
            grid,
            background: scene.background,
            max_depth,
            offset: RayOffset::new(offset, magnitude(scene)),
            diffuse: None,
        }
    }

    pub fn rows(&self) -> u32 {
        self.grid[1]
    }

    /// Pixels of a row.
    pub fn columns(&self) -> u32 {
        self.grid[0]
    }

    /// Traces a part of row `y`; its rays are added to `rays` where they are kept.
    pub fn trace_columns<S: Buildable>(
        &self,
        tracer: &dyn Tracer<S>,
        y: u32,
        columns: Range<u32>,
        rays: Option<RayBatches<S>>,
    ) -> TracedRow<S> {
        let mut row = TracedRow { rays, counts: RayCounts::default(), colors: Vec::new() };
        let samples = self.stages.eye.rays_per_pixel().saturating_mul(self.stages.fan_out);
        let group = (BATCH as u32 / samples.max(1)).max(1);
        for start in columns.clone().step_by(group as usize) {
            let end = start.saturating_add(group).min(columns.end);
            S::of_both(&TRACE_GROUP)(self, tracer, y, start..end, &mut row);
        }
        row
    }

    /// Renders the image with `tracer`, in the current rayon pool: the same for any number of
    /// threads and any right structure. `row_done` is called after each row of pixels, from any
    /// thread.
    pub fn image<S: Buildable>(
        &self,
        tracer: &dyn Tracer<S>,
        row_done: &(dyn Fn() + Sync),
    ) -> RenderedImage {
        let [width, height] = self.grid;
        let row = |y| {
            let row = self.trace_columns(tracer, y, 0..width, None);
            row_done();
            (row.colors, row.counts)
        };
        let rows: Vec<(Vec<Rgb>, RayCounts)> = (0..height).into_par_iter().map(row).collect();
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        let mut counts = RayCounts::default();
        for (mut colors, more) in rows {
            pixels.append(&mut colors);
            counts += more;
        }
        RenderedImage { image: Image { width, height, pixels }, counts }
    }

    /// Traces some pixels of row `y` together and appends them.
    fn trace_group<S: Buildable>(
        &self,
        tracer: &dyn Tracer<S>,
        y: u32,
        columns: Range<u32>,
        row: &mut TracedRow<S>,
    ) {
        let mut eye_rays = Vec::new();
        self.stages.eye.rays(y, columns.clone(), &mut eye_rays, &mut row.counts);
        let mut wave: Vec<Path<S>> = eye_rays
            .iter()
            .map(|eye| {
                let mut ray = Ray::from_dvec3(eye.from, eye.direction);
                ray.time = S::from_f64(eye.origin.time);
                Path { ray, origin: eye.origin, weight: [eye.share; 3] }
            })
            .collect();
        if let Some(rays) = &mut row.rays {
            rays.batch_mut(RayKind::Primary).extend(wave.iter().map(|p| p.ray));
        }
        let (first, colors) = (columns.start, vec![[0.0; 3]; columns.len()]);
        let mut group = PixelGroup { on: self, tracer, first, colors, row };
        for depth in 1..=self.max_depth {
            wave = group.advance(&wave, y, depth);
            if wave.is_empty() {
                break;
            }
        }
        group.row.colors.append(&mut group.colors);
    }

    /// A ray that leaves a surface.
    fn secondary_ray<S: Buildable>(&self, hit: &SurfaceHit<'_>, direction: DVec3) -> Ray<S> {
        let mut ray: Ray<S> = self.offset.along(&hit.point, direction);
        ray.time = S::from_f64(hit.origin.time);
        ray
    }
}

/// Pixels of a row that are traced together.
struct PixelGroup<'t, 'a, S: Buildable> {
    on: &'t Whitted<'a>,
    tracer: &'t dyn Tracer<S>,
    /// The column of the first pixel.
    first: u32,
    colors: Vec<Rgb>,
    /// What is kept of the rays, and their numbers.
    row: &'t mut TracedRow<S>,
}

impl<S: Buildable> PixelGroup<'_, '_, S> {
    fn add(&mut self, origin: Origin, weight: Rgb, light: Rgb) {
        let color = &mut self.colors[(origin.column - self.first) as usize];
        for k in 0..3 {
            color[k] += weight[k] * light[k];
        }
    }

    /// Traces a wave, shades its hits and returns the rays they send on.
    fn advance(&mut self, wave: &[Path<S>], y: u32, depth: u32) -> Vec<Path<S>> {
        let on = self.on;
        let rays: Vec<Ray<S>> = wave.iter().map(|p| p.ray).collect();
        let mut hits = vec![Hit::NONE; rays.len()];
        self.tracer.closest_hits(&rays, &mut hits);
        let mut seen = Vec::with_capacity(wave.len());
        for (path, hit) in wave.iter().zip(&hits) {
            if !hit.is_hit() {
                self.add(path.origin, path.weight, on.background);
                continue;
            }
            let incoming = path.ray.direction.to_dvec3();
            let position = path.ray.origin.to_dvec3() + incoming * hit.t.to_f64();
            let point = on.surfaces.at(hit.id, position);
            let (weight, origin) = (path.weight, path.origin);
            seen.push(SurfaceHit { point, id: hit.id, incoming, weight, origin });
        }
        for stage in &on.stages.hits {
            stage.apply(&mut seen);
        }
        let wave = Wave { y, depth, hits: &seen };
        self.light(wave);
        if let (Some(seed), 1, Some(rays)) = (on.diffuse, depth, &mut self.row.rays) {
            let bounces = seen.iter().map(|hit| {
                let pixel = [hit.origin.column, y];
                on.secondary_ray(hit, diffuse_direction(hit, pixel, seed))
            });
            rays.batch_mut(RayKind::Diffuse).extend(bounces);
        }
        if depth < on.max_depth { self.scatter(wave) } else { Vec::new() }
    }

    /// Adds the light that arrives at the hits of a wave.
    fn light(&mut self, wave: Wave<'_>) {
        let on = self.on;
        let Some(lights) = &on.stages.lights else { return };
        let part = (BATCH / lights.rays_per_hit().max(1)).max(1);
        let (mut shadows, mut rays, mut blocked) = (Vec::new(), Vec::new(), Vec::new());
        for hits in wave.hits.chunks(part) {
            shadows.clear();
            lights.shadow_rays(Wave { hits, ..wave }, &mut shadows, &mut self.row.counts);
            rays.clear();
            rays.extend(shadows.iter().map(|shadow: &ShadowRay| {
                let hit = &hits[shadow.hit as usize];
                let mut ray: Ray<S> = on.offset.to(&hit.point, shadow.target);
                ray.time = S::from_f64(hit.origin.time);
                ray
            }));
            blocked.clear();
            blocked.resize(rays.len(), false);
            self.tracer.occlusions(&rays, &mut blocked);
            for (shadow, _) in shadows.iter().zip(&blocked).filter(|(_, b)| !**b) {
                self.add(hits[shadow.hit as usize].origin, [1.0; 3], shadow.light);
            }
            self.row.counts.add_kind(RayKind::Shadow, rays.len());
            if let Some(kept) = &mut self.row.rays {
                kept.batch_mut(RayKind::Shadow).extend_from_slice(&rays);
            }
        }
    }

    /// The rays that the hits of a wave send on.
    fn scatter(&mut self, wave: Wave<'_>) -> Vec<Path<S>> {
        let Some(stage) = &self.on.stages.scatter else { return Vec::new() };
        let row = &mut *self.row;
        let mut scattered = Vec::<ScatteredRay>::new();
        stage.scatter(wave, &mut scattered, &mut row.counts);
        let mut next = Vec::with_capacity(scattered.len());
        for s in &scattered {
            let ray = self.on.secondary_ray(&wave.hits[s.hit as usize], s.direction);
            next.push(Path { ray, origin: s.origin, weight: s.weight });
        }
        let refracted = scattered.iter().filter(|s| s.kind == RayKind::Refracted).count();
        row.counts.add_kind(RayKind::Reflected, scattered.len() - refracted);
        row.counts.add_kind(RayKind::Refracted, refracted);
        if let Some(kept) = &mut row.rays {
            for (s, path) in scattered.iter().zip(&next) {
                kept.batch_mut(s.kind).push(path.ray);
            }
        }
        next
    }
}

/// [`Whitted::trace_group`], which takes the time of an image: compiled here, with this crate's
/// optimisation.
struct TraceGroup;

impl PerScalar for TraceGroup {
    type In<S: Buildable> = fn(&Whitted<'_>, &dyn Tracer<S>, u32, Range<u32>, &mut TracedRow<S>);
}

static TRACE_GROUP: ScalarPair<TraceGroup> = ScalarPair {
    f32: |whitted, tracer, y, columns, row| whitted.trace_group(tracer, y, columns, row),
    f64: |whitted, tracer, y, columns, row| whitted.trace_group(tracer, y, columns, row),
};

/// A cosine-distributed direction about the side that was hit (B. Malley's method: a uniform
/// point of the disc, projected up), seeded by pixel.
fn diffuse_direction(hit: &SurfaceHit<'_>, [x, y]: [u32; 2], seed: u64) -> DVec3 {
    let (normal, incoming) = (hit.point.normal, hit.incoming);
    let normal = if normal.dot(incoming) > 0.0 { -normal } else { normal };
    let normal = normal.try_normalize().unwrap_or(-incoming.normalize_or(DVec3::Z));
    let state = seed ^ (u64::from(y) << 32 | u64::from(x)).wrapping_mul(0x9e37_79b9);
    let mut random = SplitMix64::seed_from_u64(state);
    // 53 bits, to [0, 1)
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let (u, v) = (uniform(), uniform());
    let (radius, angle) = (u.sqrt(), v * std::f64::consts::TAU);
    let (s, t) = normal.any_orthonormal_pair();
    s * (radius * angle.cos()) + t * (radius * angle.sin()) + normal * (1.0 - u).max(0.0).sqrt()
}

#[derive(Debug, Clone, PartialEq)]
pub struct RenderedImage {
    pub image: Image,
    pub counts: RayCounts,
}

/// Renders the scene with the effects of the plan, in the current rayon pool. The same image for
/// any number of threads and any right structure.
pub fn render_plan<S: Buildable>(
    scene: &Scene,
    tracer: &dyn Tracer<S>,
    plan: &EffectPlan,
) -> RenderedImage {
    Whitted::planned(scene, plan).image(tracer, &|| ())
}
