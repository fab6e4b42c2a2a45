//! The samples of a scene that another process of the same program made, joined to its record.

use crate::record::{RowRecord, SceneRecord, Verdict};

/// Takes over the samples of `other`, a record of the same scene and of some of its rows, and what
/// was wrong with its answers: a structure may be wrong, or fail, in one process only. The figures
/// of the rows are made anew. Rows that the other process lacks keep what they have.
pub fn join(scene: &mut SceneRecord, other: SceneRecord, seed: u64) {
    for row in &mut scene.rows {
        let Some(same) = other.rows.iter().find(|o| o.is_same(row)) else { continue };
        if same.verdict != row.verdict && !same.verdict.is_timed() {
            let RowRecord { verdict, error, example, .. } = same.clone();
            (row.verdict, row.error) = (verdict, error);
            row.example = row.example.take().or(example);
            row.samples.clear();
            row.render_s = None;
        } else if row.verdict == Verdict::Ok && same.verdict != Verdict::Ok {
            // wrong as it is known to be, in this process only
            row.verdict = same.verdict;
        }
        row.mismatches = row.mismatches.max(same.mismatches);
        if row.verdict.is_timed() {
            row.samples.extend(same.samples.iter().cloned());
        } else {
            row.rays_by_kind.clear();
        }
        row.figure(seed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::made_up::run;

    fn scene(times: &[f64], process: u32) -> SceneRecord {
        let mut run = run(&[("tetra", &[("a", times), ("b", times)])]);
        let mut scene = run.scenes.remove(0);
        for sample in scene.rows.iter_mut().flat_map(|row| &mut row.samples) {
            sample.process = process;
        }
        scene
    }

    #[test]
    fn samples_are_joined_and_figures_are_over_both_levels() {
        let mut first = scene(&[1.0, 1.0, 1.0], 0);
        join(&mut first, scene(&[4.0, 4.0], 1), 1);
        let row = &first.rows[1];
        assert_eq!(row.samples.len(), 5);
        let time = row.trace_s.unwrap();
        assert!((time.median - 2.0).abs() < 1e-12, "the mean of processes: {time:?}");
        assert!(time.low < 1.0 && time.high > 4.0, "{time:?}");
        assert!((row.ratio.unwrap().median - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rows_wrong_in_one_process_are_wrong() {
        let mut first = scene(&[1.0], 0);
        let mut other = scene(&[1.0], 1);
        other.rows[1].verdict = Verdict::Wrong;
        other.rows[1].mismatches = 7;
        other.rows.remove(0);
        join(&mut first, other, 1);
        assert_eq!((first.rows[0].verdict, first.rows[0].samples.len()), (Verdict::Ok, 1));
        let wrong = &first.rows[1];
        assert_eq!((wrong.verdict, wrong.mismatches), (Verdict::Wrong, 7));
        assert!(wrong.samples.is_empty() && wrong.trace_s.is_none() && wrong.ratio.is_none());
    }
}
