//! The light buffer's resolution: its answers must be those of the structure, whatever it is.

use accel_core::occluders::NearestLight;
use measurement::plan::rows::Row;
use measurement::rays::batches::Answers;
use measurement::rounds::scene_run::light_positions;
use renderer::RayKind;

use super::prelude::*;

pub static AXIS: Axis = Axis {
    name: "light-buffer",
    summary: "cells per side of a light buffer's faces, from 16 to 1024",
    paper: "Haines, Greenberg 1986",
    metric: "shadow rays in 10^6 that are answered otherwise than by the structure",
    reference: "the structure itself",
    scenes: &["lattice", "teapot", "pavilion"],
    setting: "light-buffer.resolution",
    measure: Measure::Whole(measure),
};

const RESOLUTIONS: [u32; 4] = [16, 64, 256, 1024];

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let batches = stage.batches(stage.limits.timed_rays, RayKind::is_occlusion);
    let (rays, positions) = (count(&batches), light_positions(stage.scene()));
    if rays == 0 {
        return Err(stage.unfit("the scene has no shadow rays"));
    }
    let structure = stage.built(TRACER)?;
    let reference = Replay::new(&*structure.tracer, &batches);
    let error = |wrong| ErrorOf::Counted { wrong, trials: rays as u64 };
    let nearest = NearestLight::new(&positions);
    let lights: Vec<_> = batches.iter().map(|(_, rays)| nearest.of_each(rays)).collect();
    let (batches, lights) = (&batches, &lights);
    let mut variants = Vec::new();
    for resolution in RESOLUTIONS {
        let row = Row::parse(stage.occluders, &format!("light-buffer:resolution={resolution}"))?;
        let (prims, build) = (stage.prepared.geometry.prims(), row.entry.prepare(&row.params));
        let start = stage.clock.now();
        let occluder = build(prims, &positions).map_err(|e| stage.refused(e))?;
        let build_s = stage.clock.seconds_since(start);
        let bytes = occluder.stats().bytes;
        let answers = batches.iter().map(|(kind, rays)| Answers::new(*kind, rays.len())).collect();
        let work = Replay::answered_by(answers, move |batch, answers| {
            if let Answers::Blocked(blocked) = answers {
                occluder.occlusions(&batches[batch].1, &lights[batch], blocked);
            }
        });
        let wrong = work.differing(&reference);
        let setting = format!("run -s {}", row.label().replace(' ', ":"));
        variants.push(Variant {
            known_defect: row.known_defect(),
            also: build_columns(bytes, build_s).into(),
            ..Variant::new(format!("{resolution}^2"), setting, error(wrong), work)
        });
    }
    variants.push(Variant {
        is_reference: true,
        also: build_columns(structure.stats().bytes, structure.build_s).into(),
        ..Variant::new(TRACER, structure.setting(), error(0), reference)
    });
    let work = format!("{rays} shadow rays of the scene to {} lights", positions.len());
    Ok(timed(stage, SceneOutcome::new(work, "the same rays"), variants))
}
