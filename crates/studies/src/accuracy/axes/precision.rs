//! Single against double precision, of the same rays to the last digit.

use accel_core::query::tracer::Tracer;
use accel_core::{Ray, Scalar};
use renderer::Geometry;

use crate::accuracy::axis::{Axis, Measure};
use crate::accuracy::error_of::TrialCounts;
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::stage::{Batches, Replay, Stage, TRACER, count};
use crate::accuracy::timing::{AxisReport, Variant, timed};
use crate::error::StudyError;
use measurement::plan::rows::Row;
use measurement::rays::batches::Answers;

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
    let wide_batches: Batches<f64> = batches
        .iter()
        .map(|(kind, rays)| (*kind, rays.iter().map(Ray::widened).collect()))
        .collect();
    let geometry = Geometry::<f64>::of(stage.scene())?;
    let row = Row::parse(stage.registry, TRACER)?;
    let double: Box<dyn Tracer<f64>> =
        row.entry.build(geometry.prims(), &row.params).map_err(|e| stage.refused(e))?;
    let reference = Replay::new(&*double, &wide_batches).by_kind();
    let mut variants = Vec::new();
    for (name, built) in [("f32", &single), ("f32, tests in f64", &mixed)] {
        let replay = Replay::new(&*built.tracer, &batches).by_kind();
        variants.push(Variant {
            name: name.into(),
            setting: built.setting(),
            known_defect: built.known_defect,
            is_without: false,
            is_reference: false,
            error: compared(&replay.answers, &reference.answers).error(),
            also: vec![("MiB of primitives", mebibytes(stage.prepared.geometry.bytes()))],
            work: Box::new(replay),
        });
    }
    variants.push(Variant {
        name: "f64".into(),
        setting: format!("run -s {TRACER} --precision f64"),
        known_defect: None,
        is_without: false,
        is_reference: true,
        error: compared(&reference.answers, &reference.answers).error(),
        also: vec![("MiB of primitives", mebibytes(geometry.bytes()))],
        work: Box::new(reference),
    });
    let said = AxisReport {
        timed: format!("{rays} rays of the scene through {TRACER}"),
        judged: "the same rays".into(),
        ..AxisReport::default()
    };
    Ok(timed(stage, said, variants))
}

fn mebibytes(bytes: usize) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

fn compared<S: Scalar>(answers: &[Answers<S>], exact: &[Answers<f64>]) -> TrialCounts {
    let mut tally = TrialCounts::default();
    for pair in answers.iter().zip(exact) {
        match pair {
            (Answers::Hits(hits), Answers::Hits(exact)) => {
                for (hit, exact) in hits.iter().zip(exact) {
                    let off = (hit.t.to_f64() - exact.t).abs();
                    let is_far = exact.is_hit() && off > TOLERATED * exact.t.abs();
                    tally.add(hit.id != exact.id || is_far);
                }
            }
            (Answers::Blocked(blocked), Answers::Blocked(exact)) => {
                blocked.iter().zip(exact).for_each(|(b, e)| tally.add(b != e));
            }
            _ => {}
        }
    }
    tally
}
