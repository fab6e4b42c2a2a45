//! Results of several processes of one program: their samples joined, and the A/A floor, which says
//! how far the same program is from itself.
//!
//! What a copy of the program's own file takes, in processes of its own, over what the program
//! takes differs from 1 by what a process draws once and for all: where the linker's pages, the
//! heap and the stack come to lie. No smaller difference between two programs is worth a word,
//! however narrow its interval.

use serde::{Deserialize, Serialize};

use crate::record::metrics::METRICS;
use crate::record::{RowRecord, SceneRecord, Verdict};
use statistics::estimate::{median, quantile};
use statistics::series::Series;

/// Takes over the samples of `other`, another process's record of the same scene and of some of its
/// rows, and what was wrong with its answers: a structure may be wrong, or fail, in one process only. The figures
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

/// The share of all figures that are within the floor; of fewer than twenty, all of them.
const SHARE: f64 = 0.95;

/// How far a copy of the program was from the program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct FloorRecord {
    /// Figures that were compared: build and trace times, or their ratios, of rows.
    pub figures: u64,
    /// 95 of 100 figures differ by no more than this factor less 1: 0.03 is 3%.
    pub floor: f64,
    /// What the one that differs most differs by, likewise.
    pub largest: f64,
    /// The row of that, and what of it.
    pub row: String,
}

impl FloorRecord {
    /// A line below tables.
    pub fn in_words(&self) -> String {
        let Self { figures, floor, largest, row } = self;
        format!(
            "A/A floor {:.1}%: {} figures of a copy of this program differ by less from \
             its own, all by at most {:.1}% ({row}); smaller differences between programs mean \
             nothing.",
            floor * 100.0,
            if *figures < 20 { format!("all {figures}") } else { format!("95% of {figures}") },
            largest * 100.0
        )
    }

    /// Of the factors between program and copy by row, in either direction; none of none.
    pub fn of(factors: impl Iterator<Item = (String, f64)>) -> Option<Self> {
        let apart = |factor: f64| factor.ln().abs().exp_m1();
        let mut all: Vec<(f64, String)> = factors
            .filter(|(_, factor)| factor.is_finite() && *factor > 0.0)
            .map(|(row, factor)| (apart(factor), row))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let sorted: Vec<f64> = all.iter().map(|(apart, _)| *apart).collect();
        let figures = all.len() as u64;
        let (largest, row) = all.pop()?;
        let floor = if figures < 20 { largest } else { quantile(&sorted, SHARE) };
        Some(Self { figures, floor, largest, row })
    }
}

/// The factors of a scene whose processes are of the program and, of those that `is_copy` says, of
/// its copy: of build and trace ratios, the reference's own times left out.
pub fn factors<'s>(
    scene: &'s SceneRecord,
    is_copy: impl Fn(u32) -> bool + Copy + 's,
) -> impl Iterator<Item = (String, f64)> + 's {
    let metrics = METRICS.iter().filter(|m| ["build-ratio", "ratio"].contains(&m.name));
    let rows = scene.rows.iter().filter(|row| !row.is_reference && row.verdict.is_timed());
    let of = move |row: &RowRecord, what: &str, values: Series| {
        let (copies, own): (Vec<_>, Vec<_>) =
            values.by_numbered_process().into_iter().partition(|(process, _)| is_copy(*process));
        let middle = |side: &[(u32, Vec<f64>)]| {
            median(&side.iter().filter_map(|(_, rounds)| median(rounds)).collect::<Vec<_>>())
        };
        Some((format!("{}: {}, {what}", scene.name, row.label()), middle(&copies)? / middle(&own)?))
    };
    rows.flat_map(move |row| {
        metrics.clone().filter_map(move |metric| of(row, metric.name, metric.values(scene, row)))
    })
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

    #[test]
    fn a_planted_difference_of_the_copy_is_the_floor() {
        let rows: &[(&str, &[f64])] = &[("a", &[1.0, 1.0, 1.0]), ("b", &[2.0, 2.0, 2.2])];
        let mut run = run(&[("tetra", rows)]);
        for sample in run.scenes[0].rows.iter_mut().flat_map(|row| &mut row.samples) {
            sample.process = sample.round;
        }
        let of = |copy: u32| {
            FloorRecord::of(factors(&run.scenes[0], |process| process == copy)).unwrap()
        };
        let found = of(2);
        assert!((found.floor - 0.1).abs() < 1e-12 && found.figures == 2, "{found:?}");
        assert!(found.row.starts_with("tetra: b, "), "{found:?}");
        assert!((of(1).floor - 0.05).abs() < 0.01, "{:?}", of(1));
        assert_eq!(FloorRecord::of(factors(&run.scenes[0], |_| false)), None);
        // a copy that is faster is as far away
        let both = |factor| FloorRecord::of([("x".to_owned(), factor)].into_iter()).unwrap().floor;
        assert!((both(1.25) - both(0.8)).abs() < 1e-12);
    }

    #[test]
    fn the_floor_ignores_the_largest_5_percent() {
        let factors = (0..100).map(|i| (format!("row {i}"), if i == 7 { 2.0 } else { 1.01 }));
        let floor = FloorRecord::of(factors).unwrap();
        assert!((floor.floor - 0.01).abs() < 1e-9 && floor.largest == 1.0 && floor.row == "row 7");
    }
}
