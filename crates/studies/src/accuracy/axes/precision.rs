//! Single against double precision, of the same rays to the last digit.

use accel_core::Scalar;
use measurement::rays::batches::Answers;
use renderer::Geometry;

use super::prelude::*;
use crate::accuracy::stage::compare;

pub static AXIS: Axis = Axis {
    name: "precision",
    summary: "f32, tests in f64 over primitives in f32, f64 throughout",
    paper: "none",
    metric: "answers in 10^6 that differ from f64's: another primitive, or t off by 2^-20 of itself",
    reference: "the scene and the same rays in f64",
    scenes: &["teapot", "rings", "pavilion"],
    setting: "run --precision, STRUCTURE.triangle-test, STRUCTURE.sphere-test",
    measure: Measure::Whole(measure),
};

/// Tolerated relative error of t: a few epsilons of f32.
const TOLERATED: f64 = 1.0 / (1 << 20) as f64;

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let single = stage.built(TRACER)?;
    let mixed = stage.built(&format!("{TRACER}:triangle-test=f64:sphere-test=f64"))?;
    let batches = stage.all_batches();
    let rays = count(&batches);
    let wide_batches = widened(&batches);
    let geometry = Geometry::<f64>::of(stage.scene())?;
    let double = stage.over(TRACER, &geometry)?;
    let reference = Replay::by_kind(&*double, &wide_batches);
    let mut variants = Vec::new();
    for (name, built) in [("f32", &single), ("f32, tests in f64", &mixed)] {
        let replay = Replay::by_kind(&*built.tracer, &batches);
        let error = compared(&replay.answers, &reference.answers).error();
        variants.push(Variant {
            also: vec![("MiB of primitives", mebibytes(stage.prepared.geometry.bytes() as u64))],
            ..Variant::built(name, built, error, replay)
        });
    }
    variants.push(Variant {
        is_reference: true,
        also: vec![("MiB of primitives", mebibytes(geometry.bytes() as u64))],
        ..Variant::new(
            "f64",
            format!("run -s {TRACER} --precision f64"),
            compared(&reference.answers, &reference.answers).error(),
            reference,
        )
    });
    let work = format!("{rays} rays of the scene through {TRACER}");
    Ok(timed(stage, SceneOutcome::new(work, "the same rays"), variants))
}

fn compared<S: Scalar>(answers: &[Answers<S>], exact: &[Answers<f64>]) -> TrialCounts {
    compare(answers, exact, |hit, exact| {
        let off = (hit.t.to_f64() - exact.t).abs();
        hit.id != exact.id || exact.is_hit() && off > TOLERATED * exact.t.abs()
    })
}
