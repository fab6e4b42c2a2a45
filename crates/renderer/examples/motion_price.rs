//! What motion costs that is not there: rays per second over a scene whose every primitive moves,
//! by next to nothing, against the same scene at rest, the same rays at one time, the median of the
//! ratios of interleaved rounds: `cargo run --release -p renderer --example motion_price -- SCENE
//! STRUCTURE [STRUCTURE ...]`.
//!
//! The way is so short that bounds are those of the scene at rest, and rays have the time at which
//! it begins, so that their hits are: what is left is the price of the timed pass over sets that
//! move. *shared*: all have one velocity; *bodies*: each of eight stretches of primitives has one;
//! *own*: each primitive has another one than its neighbours.

use std::time::Instant;

use accel_core::query::tracer::Tracer;
use accel_core::structures::find;
use accel_core::{Hit, Ray};
use glam::DVec3;
use renderer::{Geometry, RayKind, RaySettings, generate_rays};
use scene_loading::Scene;

const ROUNDS: usize = 31;

/// Seconds of the rays of a kind, and how many hit.
fn seconds(tracer: &dyn Tracer<f32>, rays: &[Ray<f32>], kind: RayKind) -> (f64, usize) {
    let (mut hits, mut blocked) = (vec![Hit::NONE; rays.len()], vec![false; rays.len()]);
    let begun = Instant::now();
    if kind.is_occlusion() {
        tracer.occlusions(rays, &mut blocked)
    } else {
        tracer.closest_hits(rays, &mut hits)
    }
    let took = begun.elapsed().as_secs_f64();
    let found = hits.iter().filter(|h| h.is_hit()).count();
    (took, found + blocked.iter().filter(|b| **b).count())
}

/// The scene with velocities that are nearly nothing: of seven or eight, by the number of a
/// primitive.
fn moving(scene: &Scene, of: impl Fn(usize) -> usize) -> Scene {
    let mut scene = scene.clone();
    let way = scene.bounds().size().length() * 1e-6;
    let velocity = |i: usize| DVec3::new(1.0, 0.5, of(i) as f64 / 8.0) * way;
    scene.velocities = (0..scene.primitives.len()).map(velocity).collect();
    scene.camera.shutter = 1.0;
    scene
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scene = scene_loading::procedural::generate(&args.next().ok_or("which scene?")?)?;
    let rest = Geometry::<f32>::of(&scene)?;
    let n = scene.primitives.len();
    let moving = [moving(&scene, |_| 2), moving(&scene, |i| i * 8 / n), moving(&scene, |i| i % 7)];
    let [shared, bodies, own] = moving.each_ref().map(Geometry::<f32>::of);
    let (shared, bodies, own) = (shared?, bodies?, own?);
    for name in args {
        let mut parts = name.split(':');
        let entry = find(parts.next().unwrap_or_default()).ok_or("no such structure")?;
        let asked = parts.map(|part| part.split_once('=').ok_or("expected name=value"));
        let params = entry.params(asked.collect::<Result<Vec<_>, _>>()?)?;
        let mut tracers = Vec::new();
        for geometry in [&rest, &shared, &bodies, &own] {
            tracers.push(entry.build(geometry.prims(), &params)?);
        }
        let settings = RaySettings { resolution: [256, 256], ..RaySettings::default() };
        let batch = generate_rays(&scene, tracers[0].as_ref(), &settings);
        for kind in RayKind::ALL.into_iter().filter(|&kind| !batch.rays(kind).is_empty()) {
            let at = |ray: &Ray<f32>| Ray { time: 0.0, ..*ray };
            let rays: Vec<_> = batch.rays(kind).iter().map(at).collect();
            let mut times = vec![Vec::new(); tracers.len()];
            let mut found = vec![0; tracers.len()];
            for round in 0..ROUNDS {
                for k in 0..tracers.len() {
                    let k = (k + round) % tracers.len();
                    let (seconds, hits) = seconds(tracers[k].as_ref(), &rays, kind);
                    times[k].push(seconds);
                    found[k] = hits;
                }
            }
            // within each round, so that what else the machine does is alike for both
            let over = |k: usize| times[k].iter().zip(&times[0]).map(|(t, rest)| t / rest);
            let [shared, bodies, own] = [1, 2, 3].map(|k| median(over(k).collect()));
            let rest = median(times[0].clone());
            println!(
                "{name} {kind:?}: {} rays, {found:?} hits, {:.3} Mrays/s at rest; time over it: shared {:.2}, bodies {:.2}, own {:.2}",
                rays.len(),
                rays.len() as f64 / rest * 1e-6,
                shared,
                bodies,
                own
            );
        }
    }
    Ok(())
}
