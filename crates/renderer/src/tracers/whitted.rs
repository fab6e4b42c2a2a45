//! Classical ray tracing: eye rays, shadow rays to point lights, mirror and refracted rays.
//!
//! Paper: T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980; the
//! surface model is that of NFF (E. Haines, Standard Procedural Databases): Kd, Ks, Phong
//! exponent, T, index of refraction.
//!
//! A row of the image is one unit of work: its rays advance breadth first, so that a structure
//! gets whole batches, and its result does not depend on threads.

use accel_core::structures::Buildable;
use accel_core::tracer::Tracer;
use accel_core::{Hit, Ray, Vec3, Vector};
use glam::DVec3;
use rayon::prelude::*;
use scene_loading::{Rgb, Scene};

use crate::camera::{EyeRays, Sampling};
use crate::film::Image;
use crate::rays::{RayBatches, RayKind, RaySettings};
use crate::surface::{SurfacePoint, Surfaces, reflect, refract};

/// Epsilon of Havran and Sixta (1999), in world units.
const HISTORICAL_EPSILON: f64 = 0.01;

/// Our own epsilon for rays that start on a surface, in ulps of the scene's largest coordinate.
const EPSILON_ULPS: f64 = 512.0;

/// A scene made ready for tracing.
pub struct Whitted<'a> {
    surfaces: Surfaces<'a>,
    eye: EyeRays,
    lights: Vec<(DVec3, Rgb)>,
    background: Rgb,
    settings: RaySettings,
    epsilon: f64,
}

/// What a row of the image gave.
pub struct Row<S: Buildable> {
    /// Its rays.
    pub rays: RayBatches<S>,
    /// Its colours, left to right.
    pub colors: Vec<Rgb>,
}

/// A closest-hit ray on its way, and what it will contribute to.
#[derive(Clone, Copy)]
struct Path<S: Buildable> {
    ray: Ray<S>,
    column: u32,
    weight: Rgb,
}

/// A shadow ray and the light that arrives if nothing blocks it.
struct Shadow {
    column: u32,
    light: Rgb,
}

impl<'a> Whitted<'a> {
    /// Prepares tracing in the precision `S`.
    pub fn new<S: Buildable>(scene: &'a Scene, settings: &RaySettings) -> Self {
        let sampling =
            if settings.historical { Sampling::PixelCorners } else { Sampling::PixelCentres };
        let bounds = scene.bounds();
        let magnitude = if bounds.is_empty() {
            1.0
        } else {
            let eye = scene.camera.from.abs().max_element();
            bounds.min.abs().max(bounds.max.abs()).max_element().max(eye)
        };
        let default_color = [1.0 / (scene.lights.len().max(1) as f64).sqrt(); 3];
        Self {
            surfaces: Surfaces::new(scene, settings.historical),
            eye: EyeRays::new(&scene.camera, settings.resolution, sampling),
            lights: scene
                .lights
                .iter()
                .map(|light| (light.position(), light.color().unwrap_or(default_color)))
                .collect(),
            background: scene.background,
            settings: *settings,
            epsilon: if settings.historical {
                HISTORICAL_EPSILON
            } else {
                magnitude * S::EPSILON.to_f64() * EPSILON_ULPS
            },
        }
    }

    /// Rows of the image.
    pub fn rows(&self) -> u32 {
        self.eye.grid()[1]
    }

    /// Traces row `y`.
    pub fn trace_row<S: Buildable>(&self, tracer: &dyn Tracer<S>, y: u32) -> Row<S> {
        let width = self.eye.grid()[0];
        let mut row = Row { rays: RayBatches::default(), colors: vec![[0.0; 3]; width as usize] };
        let origin = Vec3::<S>::from_dvec3(self.eye.origin());
        let mut wave: Vec<Path<S>> = (0..width)
            .map(|x| {
                let direction = Vec3::<S>::from_dvec3(self.eye.direction(x, y));
                Path { ray: Ray::new(origin, direction), column: x, weight: [1.0; 3] }
            })
            .collect();
        row.rays.batch_mut(RayKind::Primary).extend(wave.iter().map(|p| p.ray));
        for depth in 1..=self.settings.max_depth {
            wave = self.advance(tracer, wave, depth, y, &mut row);
            if wave.is_empty() {
                break;
            }
        }
        row
    }

    /// Traces a wave, shades its hits and returns the rays they spawn.
    fn advance<S: Buildable>(
        &self,
        tracer: &dyn Tracer<S>,
        wave: Vec<Path<S>>,
        depth: u32,
        y: u32,
        row: &mut Row<S>,
    ) -> Vec<Path<S>> {
        let rays: Vec<Ray<S>> = wave.iter().map(|p| p.ray).collect();
        let mut hits = vec![Hit::NONE; rays.len()];
        tracer.closest_hits(&rays, &mut hits);
        let mut next = Vec::new();
        let (mut shadow_rays, mut shadows) = (Vec::new(), Vec::new());
        for (path, hit) in wave.iter().zip(&hits) {
            let color = &mut row.colors[path.column as usize];
            if !hit.is_hit() {
                add(color, path.weight, self.background);
                continue;
            }
            let incoming = path.ray.direction.to_dvec3();
            let position = path.ray.origin.to_dvec3() + incoming * hit.t.to_f64();
            let point = self.surfaces.at(hit.id, position);
            self.light_it(&point, incoming, path, &mut shadow_rays, &mut shadows);
            if depth == 1 && self.settings.diffuse {
                let ray = self.diffuse_bounce(&point, incoming, path.column, y);
                row.rays.batch_mut(RayKind::Diffuse).push(ray);
            }
            if depth < self.settings.max_depth {
                self.spawn(&point, incoming, path, row, &mut next);
            }
        }
        let mut blocked = vec![false; shadow_rays.len()];
        tracer.occlusions(&shadow_rays, &mut blocked);
        for (shadow, _) in shadows.iter().zip(&blocked).filter(|(_, b)| !**b) {
            add(&mut row.colors[shadow.column as usize], [1.0; 3], shadow.light);
        }
        row.rays.batch_mut(RayKind::Shadow).append(&mut shadow_rays);
        next
    }

    /// The side of the surface that lights are seen from.
    fn lit_normal(&self, point: &SurfacePoint, incoming: DVec3) -> DVec3 {
        if !self.settings.historical && point.normal.dot(incoming) > 0.0 {
            -point.normal
        } else {
            point.normal
        }
    }

    /// A shadow ray to every light on the lit side.
    fn light_it<S: Buildable>(
        &self,
        point: &SurfacePoint,
        incoming: DVec3,
        path: &Path<S>,
        rays: &mut Vec<Ray<S>>,
        shadows: &mut Vec<Shadow>,
    ) {
        let normal = self.lit_normal(point, incoming);
        for &(light, color) in &self.lights {
            let to_light = light - point.position;
            let distance = to_light.length();
            let direction = to_light / distance;
            let cos = normal.dot(direction);
            // NaN: a light in the very point
            if cos.is_nan() || cos <= 0.0 {
                continue;
            }
            let mut ray = self.leaving(point.position, direction);
            ray.t_max = S::from_f64(distance);
            rays.push(ray);
            let m = point.material;
            let mirror = reflect(incoming, normal).dot(direction).max(0.0);
            let highlight = if m.specular > 0.0 { m.specular * mirror.powf(m.shine) } else { 0.0 };
            let light = std::array::from_fn(|k| {
                path.weight[k] * color[k] * (m.diffuse * m.color[k] * cos + highlight)
            });
            shadows.push(Shadow { column: path.column, light });
        }
    }

    /// Mirror and refracted rays.
    fn spawn<S: Buildable>(
        &self,
        point: &SurfacePoint,
        incoming: DVec3,
        path: &Path<S>,
        row: &mut Row<S>,
        next: &mut Vec<Path<S>>,
    ) {
        let m = point.material;
        let mut send = |kind: RayKind, direction: DVec3, share: f64, row: &mut Row<S>| {
            let ray = self.leaving(point.position, direction);
            row.rays.batch_mut(kind).push(ray);
            let weight = path.weight.map(|w| w * share);
            next.push(Path { ray, column: path.column, weight });
        };
        if m.specular > 0.0 || m.transmittance > 0.0 {
            send(RayKind::Reflected, reflect(incoming, point.normal), m.specular, row);
        }
        if m.transmittance > 0.0 {
            match refract(incoming, point.normal, m.refraction_index) {
                Some(direction) => send(RayKind::Refracted, direction, m.transmittance, row),
                None => row.rays.total_internal_reflections += 1,
            }
        }
    }

    /// A cosine-distributed direction about the side that was hit (B. Malley's method: a uniform
    /// point of the disc, projected up), seeded by pixel.
    fn diffuse_bounce<S: Buildable>(
        &self,
        point: &SurfacePoint,
        incoming: DVec3,
        x: u32,
        y: u32,
    ) -> Ray<S> {
        let normal = if point.normal.dot(incoming) > 0.0 { -point.normal } else { point.normal };
        let normal = normal.try_normalize().unwrap_or(-incoming.normalize_or(DVec3::Z));
        let mut state =
            self.settings.seed ^ (u64::from(y) << 32 | u64::from(x)).wrapping_mul(0x9e37_79b9);
        let (u, v) = (uniform(&mut state), uniform(&mut state));
        let (radius, angle) = (u.sqrt(), v * std::f64::consts::TAU);
        let (s, t) = normal.any_orthonormal_pair();
        let direction = s * (radius * angle.cos())
            + t * (radius * angle.sin())
            + normal * (1.0 - u).max(0.0).sqrt();
        self.leaving(point.position, direction)
    }

    fn leaving<S: Buildable>(&self, from: DVec3, direction: DVec3) -> Ray<S> {
        let mut ray = Ray::new(Vec3::<S>::from_dvec3(from), Vec3::<S>::from_dvec3(direction));
        ray.t_min = S::from_f64(self.epsilon);
        ray
    }
}

fn add(color: &mut Rgb, weight: Rgb, light: Rgb) {
    for k in 0..3 {
        color[k] += weight[k] * light[k];
    }
}

/// splitmix64 (G. Steele, D. Lea, C. Flood, OOPSLA 2014), to [0, 1).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Renders the scene with `tracer`, in the current rayon pool. The same image for any number of
/// threads and any right structure.
pub fn render<S: Buildable>(
    scene: &Scene,
    tracer: &dyn Tracer<S>,
    settings: &RaySettings,
) -> Image {
    let settings = RaySettings { diffuse: false, ..*settings };
    let whitted = Whitted::new::<S>(scene, &settings);
    let rows: Vec<Vec<Rgb>> =
        (0..whitted.rows()).into_par_iter().map(|y| whitted.trace_row(tracer, y).colors).collect();
    let [width, height] = whitted.eye.grid();
    Image { width, height, pixels: rows.concat() }
}
