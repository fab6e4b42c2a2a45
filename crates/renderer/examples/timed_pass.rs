//! One pass of the timed path over a small scene, for instruction counts: `valgrind
//! --tool=callgrind --toggle-collect='timed_pass::timed_pass*' timed_pass [STRUCTURE [SCENE]]`,
//! where STRUCTURE may have settings (kd-tree:kernel=block) and SCENE is a generated one (balls:3).
//! The rays are made with the structure's defaults, so that they are the same for all settings.

use accel_core::Hit;
use accel_core::query::tracer::Tracer;
use accel_core::structures::find;
use renderer::{Geometry, RayKind, RaySettings, generate_rays};

/// What is measured: no counters, as in every timed pass.
#[inline(never)]
fn timed_pass(tracer: &dyn Tracer<f32>, batch: &renderer::RayBatches<f32>) -> usize {
    let mut answers = 0;
    for kind in RayKind::ALL {
        let rays = batch.rays(kind);
        if kind.is_occlusion() {
            let mut blocked = vec![false; rays.len()];
            tracer.occlusions(rays, &mut blocked);
            answers += blocked.iter().filter(|b| **b).count();
        } else {
            let mut hits = vec![Hit::NONE; rays.len()];
            tracer.closest_hits(rays, &mut hits);
            answers += hits.iter().filter(|h| h.is_hit()).count();
        }
    }
    answers
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "uniform-grid".to_owned());
    let scene = std::env::args().nth(2).unwrap_or_else(|| "balls:3".to_owned());
    let scene = scene_loading::procedural::generate(&scene)?;
    let geometry = Geometry::<f32>::of(&scene)?;
    let mut parts = name.split(':');
    let entry = find(parts.next().unwrap_or_default()).ok_or("no such structure")?;
    let asked = parts.map(|part| part.split_once('=').ok_or("expected name=value"));
    let asked = asked.collect::<Result<Vec<_>, _>>()?;
    let default = entry.build(geometry.prims(), &entry.params([])?)?;
    let settings = RaySettings { resolution: [96, 96], ..RaySettings::default() };
    let batch = generate_rays(&scene, default.as_ref(), &settings);
    let tracer = entry.build(geometry.prims(), &entry.params(asked)?)?;
    println!("{name}: {} rays, {} answers", batch.total(), timed_pass(tracer.as_ref(), &batch));
    Ok(())
}
