//! Axes whose variants must answer as a reference does: mailboxes, which may only make tests fewer;
//! the light buffer's resolution; single against double precision.

use accel_core::Scalar;
use accel_core::occluders::NearestLight;
use measurement::plan::rows::Row;
use measurement::rays::batches::Answers;
use measurement::rounds::scene_run::light_positions;
use renderer::{Geometry, RayKind};

use crate::accuracy::axis::*;

pub static MAILBOX: Axis = Axis {
    name: "mailbox",
    summary: "tests saved of a primitive in several cells: none, slots of a hash, stamps",
    paper: "Arnaldi, Priol, Bouatouch 1987; Benthin 2006",
    metric: "answers in 10^6 that differ from those without a mailbox",
    reference: "the same grid without a mailbox, triangles one by one",
    scenes: &["teapot", "gears", "pavilion"],
    setting: "uniform-grid.mailbox, uniform-grid.mailbox-slots",
    measure: Measure::Whole(mailboxes),
};

const MAILBOXES: [(&str, &str); 6] = [
    ("none", "uniform-grid:density=8:kernel=scalar"),
    ("hash, 1 slot", "uniform-grid:density=8:mailbox=hash:mailbox-slots=1"),
    ("hash, 8 slots", "uniform-grid:density=8:mailbox=hash:mailbox-slots=8"),
    ("hash, 64 slots", "uniform-grid:density=8:mailbox=hash:mailbox-slots=64"),
    ("array per thread", "uniform-grid:density=8:mailbox=array"),
    ("stamp in the primitive", "uniform-grid:density=8:mailbox=primitive"),
];

fn mailboxes(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let settings = MAILBOXES.map(|(name, label)| (name, label.to_owned()));
    let batches = stage.all_batches();
    let through = "of the scene through a uniform grid of 8 cells per primitive";
    let said = SceneOutcome::new(through, "the same rays");
    timed_settings(stage, &settings, "none", &batches, said, |i, built, replays| {
        let (rays, wrong) = (count(&batches), replays[i].differing(&replays[0]));
        let work = counted(&*built.tracer, &batches);
        let per_ray = |n: u64| n as f64 / rays.max(1) as f64;
        let figures = vec![
            ("tests per ray", per_ray(work.intersection_tests)),
            ("tests saved per ray", per_ray(work.tests_saved)),
        ];
        Ok((ErrorOf::Counted { wrong, trials: rays as u64 }, figures))
    })
}

pub static LIGHT_BUFFER: Axis = Axis {
    name: "light-buffer",
    summary: "cells per side of a light buffer's faces, from 16 to 1024",
    paper: "Haines, Greenberg 1986",
    metric: "shadow rays in 10^6 that are answered otherwise than by the structure",
    reference: "the structure itself",
    scenes: &["lattice", "teapot", "pavilion"],
    setting: "light-buffer.resolution",
    measure: Measure::Whole(light_buffers),
};

const RESOLUTIONS: [u32; 4] = [16, 64, 256, 1024];

fn light_buffers(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
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
        let variant = Variant::new(format!("{resolution}^2"), setting, error(wrong), work);
        let variant = variant.with_defect(row.known_defect());
        variants.push(variant.also(build_columns(bytes, build_s)));
    }
    let variant = Variant::new(TRACER, structure.setting(), error(0), reference);
    variants.push(variant.as_reference(true).also(structure.columns()));
    let work = format!("{rays} shadow rays of the scene to {} lights", positions.len());
    Ok(timed(stage, SceneOutcome::new(work, "the same rays"), variants))
}

pub static PRECISION: Axis = Axis {
    name: "precision",
    summary: "f32, tests in f64 over primitives in f32, f64 throughout",
    paper: "none",
    metric: "answers in 10^6 that differ from f64's: another primitive, or t off by 2^-20 of itself",
    reference: "the scene and the same rays in f64",
    scenes: &["teapot", "rings", "pavilion"],
    setting: "run --precision, STRUCTURE.triangle-test, STRUCTURE.sphere-test",
    measure: Measure::Whole(precisions),
};

/// Tolerated relative error of t: a few epsilons of f32.
const TOLERATED: f64 = 1.0 / (1 << 20) as f64;

fn precisions(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let single = stage.built(TRACER)?;
    let mixed = stage.built(&format!("{TRACER}:triangle-test=f64:sphere-test=f64"))?;
    let batches = stage.all_batches();
    let rays = count(&batches);
    let wide_batches = widened(&batches);
    let geometry = Geometry::<f64>::of(stage.scene())?;
    let double = stage.over(TRACER, &geometry)?;
    let reference = Replay::by_kind(&*double.tracer, &wide_batches);
    let memory = |bytes: usize| [("MiB of primitives", mebibytes(bytes as u64))];
    let mut variants = Vec::new();
    for (name, built) in [("f32", &single), ("f32, tests in f64", &mixed)] {
        let replay = Replay::by_kind(&*built.tracer, &batches);
        let error = compared(&replay.answers, &reference.answers).error();
        let variant = Variant::built(name, built, error, replay);
        variants.push(variant.also(memory(stage.prepared.geometry.bytes())));
    }
    let none = compared(&reference.answers, &reference.answers).error();
    let variant = Variant::new("f64", double.setting() + " --precision f64", none, reference);
    variants.push(variant.as_reference(true).also(memory(geometry.bytes())));
    let work = format!("{rays} rays of the scene through {TRACER}");
    Ok(timed(stage, SceneOutcome::new(work, "the same rays"), variants))
}

fn compared<S: Scalar>(answers: &[Answers<S>], exact: &[Answers<f64>]) -> TrialCounts {
    compare(answers, exact, |hit, exact| {
        let off = (hit.t.to_f64() - exact.t).abs();
        hit.id != exact.id || exact.is_hit() && off > TOLERATED * exact.t.abs()
    })
}
