//! Times of an axis that several processes measured: where code and data lie is drawn once for a
//! process, and moves times by more than most variants differ.

use crate::accuracy::record::{AxisRecord, SceneOutcome};
use crate::accuracy::timing::figure;
use crate::error::StudyError;

/// Takes the times of the axis that process number `process` (from 0) measured: those of the first
/// one in place of the axis' own, those of others beside them, of as many rounds each. Errors stay;
/// faults are added.
///
/// # Errors
/// [`StudyError::Unlike`] where the process has not measured the same variants on the same scenes.
pub fn join(
    axis: &mut AxisRecord,
    other: &AxisRecord,
    process: u32,
    seed: u64,
) -> Result<(), StudyError> {
    for scene in &mut axis.scenes {
        let same =
            other.scenes.iter().find(|o| (&o.scene, &o.subject) == (&scene.scene, &scene.subject));
        let unlike = |found: String| StudyError::Unlike {
            axis: axis.axis.clone(),
            place: scene.place(),
            process: process + 1,
            found,
        };
        let same = same.ok_or_else(|| unlike("nothing".into()))?;
        if let Some(found) = difference(scene, same, process) {
            return Err(unlike(found));
        }
        for (row, same) in scene.rows.iter_mut().zip(&same.rows) {
            take(&mut row.seconds, &same.seconds, process);
            for (part, same) in row.parts.iter_mut().zip(&same.parts) {
                take(&mut part.seconds, &same.seconds, process);
            }
        }
        let new = |fault: &&String| !scene.faults.contains(fault);
        let faults: Vec<String> = same.faults.iter().filter(new).cloned().collect();
        scene.faults.extend(faults);
        scene.processes = process + 1;
        figure(scene, seed);
    }
    Ok(())
}

fn take(seconds: &mut Vec<f64>, other: &[f64], process: u32) {
    if process == 0 {
        seconds.clear();
    }
    seconds.extend(other);
}

/// First difference from the outcome that it is merged into.
fn difference(scene: &SceneOutcome, other: &SceneOutcome, process: u32) -> Option<String> {
    let names = |of: &SceneOutcome| {
        let each = of.rows.iter().map(|row| (row.variant.clone(), row.parts.len()));
        each.collect::<Vec<_>>()
    };
    if names(scene) != names(other) {
        return Some(format!("other variants: {:?}", names(other)));
    }
    if scene.timed != other.timed {
        return Some(format!("timed {}", other.timed));
    }
    let rounds = |of: &SceneOutcome, processes: u32| {
        of.rows.first().map_or(0, |row| row.seconds.len()) / processes.max(1) as usize
    };
    (process > 0 && rounds(scene, process) != rounds(other, 1))
        .then(|| format!("{} rounds", rounds(other, 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::test_records::{axis, row};

    fn measured(times: [f64; 2]) -> AxisRecord {
        axis(vec![row("exact", times[0], 0), row("fast", times[1], 9)])
    }

    #[test]
    fn figures_are_over_processes_and_errors_stay() {
        let mut judged = measured([100.0, 1.0]);
        judged.scenes[0].rows[1].error = crate::accuracy::record::ErrorOf::Rmse { rmse: 0.5 };
        for (process, times) in [[2.0, 1.0], [8.0, 1.0]].into_iter().enumerate() {
            let mut other = measured(times);
            other.scenes[0].faults.push("it lies".into());
            join(&mut judged, &other, process as u32, 1).unwrap();
        }
        let scene = &judged.scenes[0];
        assert_eq!((scene.processes, &*scene.faults), (2, &["it lies".to_owned()][..]));
        let [exact, fast] = &scene.rows[..] else { panic!() };
        assert_eq!((exact.seconds.len(), fast.error.value()), (6, 0.5));
        assert!((exact.ratio.median - 4.0).abs() < 1e-9, "{:?}", exact.ratio);
        assert!(exact.ratio.high > 8.0, "of two processes alone: {:?}", exact.ratio);
    }

    #[test]
    fn processes_with_other_results_are_refused() {
        let refused = |judged: &mut AxisRecord, other: &AxisRecord, process| {
            join(judged, other, process, 1).unwrap_err().to_string()
        };
        let [mut judged, mut other] = [(); 2].map(|()| measured([1.0, 1.0]));
        other.scenes[0].rows.pop();
        assert!(refused(&mut judged, &other, 0).contains("other variants"));
        other.scenes.clear();
        let nothing = "process 1 measured nothing, which differs from what was judged";
        let error = refused(&mut judged, &other, 0);
        assert_eq!(error, format!("triangle-test on kitchen: {nothing}"));
        join(&mut judged, &measured([1.0, 1.0]), 0, 1).unwrap();
        let mut fewer = measured([1.0, 1.0]);
        fewer.scenes[0].timed = "100 rays".into();
        assert!(refused(&mut judged, &fewer, 1).contains("timed 100 rays"));
        let mut shorter = measured([1.0, 1.0]);
        shorter.scenes[0].rows[0].seconds.pop();
        assert!(refused(&mut judged, &shorter, 1).contains("2 rounds"));
    }
}
