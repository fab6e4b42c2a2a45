//! The A/A floor: how far the same program is from itself.
//!
//! What a copy of the program's own file takes, in processes of its own, over what the program
//! takes differs from 1 by what a process draws once and for all: where the linker's pages, the
//! heap and the stack come to lie. No smaller difference between two programs is worth a word,
//! however narrow its interval.

use serde::{Deserialize, Serialize};

use crate::record::metrics::METRICS;
use crate::record::{RowRecord, SceneRecord};
use statistics::estimate::median;
use statistics::outliers::quantile;
use statistics::series::Series;

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
