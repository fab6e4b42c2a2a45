//! The light buffer's resolution: its answers must be those of the structure, whatever it is.

use accel_core::occluders::{BoxedOccluder, NearestLight};
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
    let mut variants = Vec::new();
    for resolution in RESOLUTIONS {
        let row = Row::parse(stage.occluders, &format!("light-buffer:resolution={resolution}"))?;
        let (prims, build) = (stage.prepared.geometry.prims(), row.entry.prepare(&row.params));
        let start = stage.clock.now();
        let occluder = build(prims, &positions).map_err(|e| stage.refused(e))?;
        let build_s = stage.clock.seconds_since(start);
        let bytes = occluder.stats().bytes;
        let mut work = OccluderQuery::new(occluder, &batches, &positions);
        work.prepare();
        work.run();
        let pairs = work.answers.iter().zip(&reference.answers);
        let wrong = pairs.map(|(a, b)| a.differing(b).count() as u64).sum();
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

struct OccluderQuery<'a> {
    occluder: BoxedOccluder<'a, f32>,
    batches: &'a Batches<f32>,
    lights: Vec<Vec<u32>>,
    answers: Vec<Answers<f32>>,
}

impl<'a> OccluderQuery<'a> {
    fn new(
        occluder: BoxedOccluder<'a, f32>,
        batches: &'a Batches<f32>,
        positions: &[glam::DVec3],
    ) -> Self {
        let nearest = NearestLight::new(positions);
        let lights = batches.iter().map(|(_, rays)| nearest.of_each(rays)).collect();
        let answers = batches.iter().map(|(kind, rays)| Answers::new(*kind, rays.len())).collect();
        Self { occluder, batches, lights, answers }
    }
}

impl Work for OccluderQuery<'_> {
    fn prepare(&mut self) {
        self.answers.iter_mut().for_each(Answers::clear);
    }

    fn run(&mut self) {
        for (((_, rays), lights), answers) in
            self.batches.iter().zip(&self.lights).zip(&mut self.answers)
        {
            if let Answers::Blocked(blocked) = answers {
                self.occluder.occlusions(rays, lights, blocked);
            }
        }
    }

    fn fingerprint(&self) -> u64 {
        crate::accuracy::stage::fingerprint(&self.answers)
    }
}
