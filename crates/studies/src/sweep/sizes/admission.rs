//! Admits rows at a size if their trial builds keep the limits, there and at all smaller sizes.

use measurement::plan::Plan;
use measurement::plan::measured_row::MeasuredRow;
use measurement::record::{RowRecord, RunRecord, SceneRecord, Verdict};
use measurement::rounds::scene_run::SceneInput;
use measurement::rounds::trial::{TrialBuild, TrialOutcome};

/// The outcome of each row's trial on a scene; empty where the plan has no limits.
pub fn trials(
    plan: &Plan<'_>,
    finished: &[SceneRecord],
    scene: &str,
    equipment: &SceneInput<'_>,
) -> Vec<TrialOutcome> {
    let outcome = |row: &MeasuredRow<'_>| {
        let trial = TrialBuild {
            scene: scene.to_owned(),
            view: plan.scenes.first().map(|known| known.view()).unwrap_or_default(),
            row: row.label(),
            threads: plan.threads,
            precision: plan.precision,
            limits: plan.build_limits?,
        };
        equipment.progress.message(format!("{scene}: trial build of {}", trial.row));
        Some(match earlier(finished, &trial.row) {
            Some(reason) => TrialOutcome::OverLimit(reason),
            None => equipment.world.trial_build(&trial),
        })
    };
    plan.rows.iter().filter_map(outcome).collect()
}

/// Why a row is not tried again: it was over a limit at a smaller size.
fn earlier(finished: &[SceneRecord], label: &str) -> Option<String> {
    finished.iter().find_map(|scene| {
        let over = |row: &&RowRecord| row.verdict == Verdict::OverLimit && row.label() == label;
        let reason = scene.rows.iter().find(over)?.error.as_deref().unwrap_or_default();
        Some(format!("not tried: over a limit at {} already: {reason}", scene.name))
    })
}

/// The record of a size where no row is left to measure: it is not even loaded.
pub fn without_rows(
    plan: &Plan<'_>,
    run: &RunRecord,
    scene: &str,
    trials: &[TrialOutcome],
) -> Option<SceneRecord> {
    let reasons = trials.iter().map(|outcome| match outcome {
        TrialOutcome::OverLimit(reason) => Some(reason.clone()),
        TrialOutcome::Ended { .. } | TrialOutcome::Died(_) => None,
    });
    let reasons: Vec<String> = reasons.collect::<Option<_>>()?;
    if reasons.is_empty() {
        return None;
    }
    let size = run.scale.as_ref().and_then(|scale| scale.size(scene));
    let rows = plan.rows.iter().zip(reasons).enumerate().map(|(i, (row, reason))| RowRecord {
        is_reference: i == plan.baseline,
        ..row.unmeasured(Verdict::OverLimit, Some(reason))
    });
    Some(SceneRecord {
        name: scene.to_owned(),
        source: "not loaded: every row is over a limit".into(),
        primitives: size.map_or(0, |size| size.primitives),
        rows: rows.collect(),
        ..SceneRecord::default()
    })
}
