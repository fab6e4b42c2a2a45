//! What motion costs that is not there: rays per second over a scene whose every primitive moves, by next to
//! nothing, against the same scene at rest, the same rays at one time, rounds interleaved in one process:
//! `cargo run --release -p renderer --example motion_price -- SCENE STRUCTURE [STRUCTURE ...]`.
//!
//! The way is so short that bounds are those of the scene at rest, and rays have the time at which it begins, so that
//! their hits are: what is left is the price of the timed pass over sets that move. *shared*: all have one velocity; *own*: each primitive has another one than its neighbours.

use std::time::Instant;

use accel_core::query::tracer::Tracer;
use accel_core::structures::find;
use accel_core::{Hit, Ray};
use glam::DVec3;
use renderer::{Geometry, RayKind, RaySettings, generate_rays};
use scene_loading::Scene;

const ROUNDS: usize = 9;

/// Seconds of the rays of a kind, and how many hit.
fn seconds(tracer: &dyn Tracer<f32>, rays: &[Ray<f32>], kind: RayKind) -> (f64, usize) {
    let (mut hits, mut blocked) = (vec![Hit::NONE; rays.len()], vec![false; rays.len()]);
    let begun = Instant::now();
    match kind.is_occlusion() {
        true => tracer.occlusions(rays, &mut blocked),
        false => tracer.closest_hits(rays, &mut hits),
    }
    let took = begun.elapsed().as_secs_f64();
    let found = hits.iter().filter(|h| h.is_hit()).count();
    (took, found + blocked.iter().filter(|b| **b).count())
}

/// The scene with velocities that are nearly nothing; the first is that of all where they share one.
fn moving(scene: &Scene, is_shared: bool) -> Scene {
    let mut scene = scene.clone();
    let way = scene.bounds().size().length() * 1e-6;
    let velocity =
        |i: usize| DVec3::new(1.0, 0.5, if is_shared { 0.25 } else { (i % 7) as f64 / 7.0 }) * way;
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
    let [shared, own] = [true, false].map(|is_shared| moving(&scene, is_shared));
    let (shared, own) = (Geometry::<f32>::of(&shared)?, Geometry::<f32>::of(&own)?);
    for name in args {
        let mut parts = name.split(':');
        let entry = find(parts.next().unwrap_or_default()).ok_or("no such structure")?;
        let asked = parts.map(|part| part.split_once('=').ok_or("expected name=value"));
        let params = entry.params(asked.collect::<Result<Vec<_>, _>>()?)?;
        let mut tracers = Vec::new();
        for geometry in [&rest, &shared, &own] {
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
            let [rest, shared, own] = [0, 1, 2].map(|k| median(times[k].clone()));
            println!(
                "{name} {kind:?}: {} rays, {found:?} hits, {:.3} Mrays/s at rest; time over it: shared {:.2}, own {:.2}",
                rays.len(),
                rays.len() as f64 / rest * 1e-6,
                shared / rest,
                own / rest
            );
        }
    }
    Ok(())
}
