//! Tables of work that is timed part by part: what each variant takes for each kind of ray, over
//! the first variant, and what each step adds where variants build on one another.

use std::collections::BTreeSet;

use presentation::numbers::{ratio, short};
use presentation::table::{Cell, Table, dash};
use renderer::RayKind;
use statistics::estimate::Estimate;
use statistics::series::{Series, geometric_mean_of};

use crate::accuracy::record::{AxisRecord, SceneOutcome, VariantRecord};

/// The part of rays that no kind stands for; see `axes/right_work.rs`.
pub const OFFSET_RAYS: &str = "leaving surfaces";

/// A name that table heads can have.
fn head(part: &str) -> &'static str {
    let kind = RayKind::ALL.into_iter().map(RayKind::name).find(|name| *name == part);
    kind.unwrap_or(if part == OFFSET_RAYS { OFFSET_RAYS } else { "other" })
}

/// The parts of an outcome's variants, in order.
fn names(scene: &SceneOutcome) -> Vec<&str> {
    let first = scene.rows.first().map_or(&[][..], |row| &row.parts);
    first.iter().map(|part| part.part.as_str()).collect()
}

/// Subjects of an axis, in the order in which they were measured.
fn subjects(axis: &AxisRecord) -> Vec<&str> {
    let mut seen = BTreeSet::new();
    axis.scenes.iter().map(|s| s.subject.as_str()).filter(|s| seen.insert(*s)).collect()
}

/// Times of the variants of an axis by kind of ray, over all scenes; one table per subject, none if
/// work is timed as a whole.
pub fn over_scenes(axis: &AxisRecord, seed: u64) -> Vec<Table> {
    subjects(axis).into_iter().filter_map(|subject| of_subject(axis, subject, seed)).collect()
}

fn of_subject(axis: &AxisRecord, subject: &str, seed: u64) -> Option<Table> {
    let scenes: Vec<&SceneOutcome> = axis.scenes.iter().filter(|s| s.subject == subject).collect();
    let first = scenes.first()?;
    let parts = names(first);
    let leading = first.rows.first().filter(|_| !parts.is_empty())?;
    let rows = first.rows.iter().map(|row| {
        let of_part = |part: &&str| {
            let groups: Vec<Series> =
                scenes.iter().filter_map(|scene| of_variant(scene, &row.variant, part)).collect();
            geometric_mean_of(&groups.iter().collect::<Vec<_>>(), seed)
                .map_or_else(dash, |e| ratio(&e).into())
        };
        let cells = std::iter::once(row.variant.clone().into());
        cells.chain(parts.iter().map(of_part)).collect()
    });
    let names: Vec<&str> = scenes.iter().map(|scene| scene.scene.as_str()).collect();
    let of = if subject.is_empty() { String::new() } else { format!(", {subject}") };
    Some(Table {
        title: format!("{}{of}: time over that of {}, by kind of ray", axis.axis, leading.variant),
        header: std::iter::once("variant").chain(parts.iter().map(|part| head(part))).collect(),
        rows: rows.collect(),
        notes: vec![format!(
            "Geometric mean over {}; medians of rounds, 95% intervals, = where they contain 1.",
            names.join(", ")
        )],
    })
}

/// Ratios of a variant's part to that of the first one, round by round.
fn of_variant(scene: &SceneOutcome, variant: &str, part: &str) -> Option<Series> {
    let seconds =
        |row: &VariantRecord| row.parts.iter().find(|p| p.part == part).map(|p| p.seconds.clone());
    let row = scene.rows.iter().find(|row| row.variant == variant)?;
    Some(scene.ratios(&seconds(row)?, &seconds(scene.rows.first()?)?))
}

/// Time added and errors removed by each step; `None` if variants are no steps.
pub fn steps(axis: &AxisRecord, scene: &SceneOutcome, seed: u64) -> Option<Table> {
    let first = scene.rows.first().filter(|_| scene.is_stepwise)?;
    let over = |row: &VariantRecord, other: &VariantRecord| {
        let ratios = scene.ratios(&row.seconds, &other.seconds);
        ratios.estimate(seed).map_or_else(dash, |e| more(&e).into())
    };
    let mut before = first;
    let rows = scene.rows.iter().enumerate().map(|(i, row)| {
        let gone = before.error.value() - row.error.value();
        let cells: Vec<Cell> = vec![
            row.variant.clone().into(),
            if i == 0 { dash() } else { over(row, before) },
            if i == 0 { dash() } else { over(row, first) },
            short(row.error.value()).into(),
            if i == 0 { dash() } else { short(gone).into() },
        ];
        before = row;
        cells
    });
    Some(Table {
        title: format!("{}: {}, step by step", axis.axis, scene.place()),
        header: vec!["step", "time added [95%]", "in all [95%]", "wrong in 10^6", "removed"],
        rows: rows.collect(),
        notes: vec![
            "Each row adds one measure to the row before; in all: over the first row. A step \
             that removes no errors here may remove some that earlier steps removed already."
                .into(),
        ],
    })
}

/// A ratio as what is more than 1.
pub(super) fn more(e: &Estimate) -> String {
    let percent = |x: f64| format!("{:+.1}", (x - 1.0) * 100.0);
    let mark = if e.holds(1.0) { " =" } else { "" };
    format!("{}% [{}, {}]{mark}", percent(e.median), percent(e.low), percent(e.high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::record::PartTime;
    use crate::accuracy::test_records::{axis, row};

    #[test]
    fn parts_are_compared_with_those_of_the_first_variant() {
        let with_parts = |name: &str, seconds: [f64; 2]| {
            let mut row = row(name, seconds[0] + seconds[1], 0);
            let part = |(part, s): (&str, f64)| PartTime {
                part: part.into(),
                seconds: vec![s; 3],
                ratio: Estimate::exactly(s),
            };
            row.parts = ["primary", "shadow"].into_iter().zip(seconds).map(part).collect();
            row
        };
        assert!(over_scenes(&axis(vec![row("a", 1.0, 0)]), 1).is_empty());
        let axis = axis(vec![with_parts("leaky", [2.0, 4.0]), with_parts("tight", [3.0, 4.0])]);
        let tables = over_scenes(&axis, 1);
        assert_eq!(tables.len(), 1);
        assert_eq!(tables[0].header, ["variant", "primary", "shadow"]);
        assert_eq!(tables[0].rows[1][1].text.trim(), "1.50 [1.50, 1.50]");
        assert_eq!(tables[0].rows[1][2].text, "1.00 [1.00, 1.00] =");
    }

    #[test]
    fn steps_add_time_and_take_errors() {
        let mut axis =
            axis(vec![row("fast", 2.0, 50), row("padded", 2.2, 20), row("right", 3.3, 0)]);
        assert!(steps(&axis, &axis.scenes[0], 1).is_none());
        axis.scenes[0].is_stepwise = true;
        let table = steps(&axis, &axis.scenes[0], 1).unwrap();
        let texts: Vec<&str> = table.rows[2].iter().map(|cell| cell.text.as_str()).collect();
        assert_eq!(texts[..3], ["right", "+50.0% [+50.0, +50.0]", "+65.0% [+65.0, +65.0]"]);
        assert_eq!(texts[4].parse::<f64>().unwrap(), 20.0);
    }
}
