//! Motion: what moves while rays are traced, by 1 to 8 segments of time, against the same held
//! still at 1 to 8 moments.
//!
//! Papers: A. Glassner, "Spacetime Ray Tracing for Animation", IEEE CG&A 8(2), 1988 (segments); J.
//! Korein, N. Badler, "Temporal Anti-Aliasing in Computer Generated Animation", SIGGRAPH 1983
//! (moments).
//!
//! Every other primitive moves by a tenth of the scene's size, each in a direction of its own, and
//! every ray has a random time. Held still, it sees the middle of the part that its time is in, and
//! the rays of a part are traced together, as by one who draws an image a moment.

use accel_core::Ray;
use glam::DVec3;
use renderer::Geometry;
use scene_loading::{Scene, Shape};
use statistics::random::Random;

use crate::accuracy::axis::*;
use crate::verify::draw::unit;

pub static AXIS: Axis = Axis {
    name: "time-segments",
    summary: "moving primitives in 1 to 8 time segments, or static at 1 to 8 moments",
    paper: "Glassner 1988; Korein, Badler 1983",
    metric: "answers in 10^6 with another primitive or occlusion than at the ray's own time",
    reference: "the same structure over the moving primitives, one segment",
    scenes: &["balls:3", "gears:2", "pavilion"],
    setting: "STRUCTURE.time-segments",
    measure: Measure::Whole(measure),
};

const PARTS: [usize; 4] = [1, 2, 4, 8];

/// How far primitives move, in parts of the scene's size.
const WAY: f64 = 0.1;

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let scene = in_motion(stage.scene(), &mut stage.random("directions"));
    let shutter = scene.camera.shutter;
    let (mut random, mut batches) = (stage.random("times"), stage.all_batches());
    for ray in batches.iter_mut().flat_map(|(_, rays)| rays) {
        ray.time = (shutter * unit(&mut random)) as f32;
    }
    let moving = [Geometry::<f32>::of(&scene)?];
    let of_moments = |n| moments(n, shutter).map(|time| Geometry::of(&held_still(&scene, time)));
    let still = PARTS.map(|n| of_moments(n).collect::<Result<Vec<Geometry<f32>>, _>>());
    let still = still.into_iter().collect::<Result<Vec<_>, _>>()?;
    // structures with the rays that each answers
    let mut rows = Vec::new();
    for n in PARTS {
        let label = format!("{TRACER}:time-segments={n}");
        let setting = format!("run -s {label}");
        rows.push((
            named(n, "segment"),
            setting,
            stage.over_each(&label, &moving)?,
            vec![batches.clone()],
        ));
    }
    for (geometries, n) in still.iter().zip(PARTS) {
        let parts = (0..n).map(|k| part(&batches, k, n, shutter)).collect();
        let setting = format!("run -s {TRACER}, of {n} scenes at rest");
        let name = format!("held still, {}", named(n, "moment"));
        rows.push((name, setting, stage.over_each(TRACER, geometries)?, parts));
    }
    let reference = &*rows[0].2[0].tracer;
    let variants = rows.iter().enumerate().map(|(i, (name, setting, structures, batches))| {
        let own = structures.iter().map(|built| &*built.tracer).zip(batches);
        let replay = Replay::of_several(own);
        let exact = Replay::of_several(batches.iter().map(|batches| (reference, batches)));
        let error =
            compare(&replay.answers, &exact.answers, |hit, exact| hit.id != exact.id).error();
        let bytes = structures.iter().map(|built| built.tracer.stats().bytes).sum();
        let build_s = structures.iter().map(|built| built.build_s).sum();
        let defect = (i >= PARTS.len()).then_some("moving primitives are static within each part");
        Variant::new(name, setting, error, replay)
            .with_defect(defect)
            .as_reference(i == 0)
            .also(build_columns(bytes, build_s))
    });
    let rays = count(&batches);
    let work = format!("{rays} rays of the scene, each at a time of its own, through {TRACER}");
    Ok(timed(stage, SceneOutcome::new(work, "the same rays"), variants))
}

fn named(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

/// The middles of `n` parts of the exposure.
fn moments(n: usize, shutter: f64) -> impl Iterator<Item = f64> {
    (0..n).map(move |k| shutter * (k as f64 + 0.5) / n as f64)
}

/// The rays of a part of the exposure.
fn part(batches: &Batches<f32>, k: usize, n: usize, shutter: f64) -> Batches<f32> {
    let is_in =
        |ray: &Ray<f32>| ((f64::from(ray.time) / shutter * n as f64) as usize).min(n - 1) == k;
    let part = |rays: &Vec<Ray<f32>>| rays.iter().copied().filter(is_in).collect();
    batches.iter().map(|(kind, rays)| (*kind, part(rays))).collect()
}

/// The scene, every other primitive of which moves.
fn in_motion(scene: &Scene, random: &mut Random) -> Scene {
    let mut scene = scene.clone();
    let way = WAY * diagonal(&scene);
    let mut velocity = |id: usize| {
        let direction = DVec3::from([0; 3].map(|_| unit(random) - 0.5)).normalize_or_zero();
        if id.is_multiple_of(2) { direction * way } else { DVec3::ZERO }
    };
    scene.velocities = (0..scene.primitives.len()).map(&mut velocity).collect();
    scene.camera.shutter = 1.0;
    scene
}

/// The scene as it is at a moment, primitives in their order.
fn held_still(scene: &Scene, time: f64) -> Scene {
    let mut still = Scene::new(scene.name.clone());
    still.materials = scene.materials.clone();
    for (id, primitive) in (0..).zip(&scene.primitives) {
        let (material, way) = (primitive.material, scene.velocity(id) * time);
        match primitive.shape {
            Shape::Sphere(i) => {
                let sphere = scene.spheres[i as usize];
                still.push_sphere(material, sphere.center + way, sphere.radius);
            }
            Shape::Cone(i) => {
                let cone = scene.cones[i as usize];
                let (base, apex) = (cone.base + way, cone.apex + way);
                still.push_cone(material, scene_loading::Cone { base, apex, ..cone });
            }
            shape => {
                let outline: Vec<_> = scene.outline(shape).into_iter().map(|p| p + way).collect();
                match outline[..] {
                    [a, b, c] => still.push_triangle(material, [a, b, c]),
                    _ => still.push_polygon(material, &outline),
                }
            }
        }
    }
    still
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_has_moving_primitives_at_their_places() {
        let mut scene = scene_loading::procedural::generate("balls:1").unwrap();
        scene.velocities = vec![DVec3::ZERO, DVec3::X];
        let still = held_still(&scene, 0.5);
        assert_eq!(still.primitives.len(), scene.primitives.len());
        for (id, (was, is)) in scene.primitives.iter().zip(&still.primitives).enumerate() {
            let (was, is) = (scene.shape_bounds(was.shape), still.shape_bounds(is.shape));
            let way = if id == 1 { DVec3::X * 0.5 } else { DVec3::ZERO };
            assert_eq!((was.min + way, was.max + way), (is.min, is.max), "{id}");
        }
    }
}
