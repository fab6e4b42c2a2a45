//! Tables of what variants cost: for each kind of ray, over the first variant; what each step adds,
//! where variants build on one another; and the price of each effect.

use presentation::numbers::{interval, ratio, short};
use presentation::table::{Cell, Table, dash};
use renderer::RayKind;
use statistics::estimate::Estimate;
use statistics::series::{Series, geometric_mean_of};

use crate::accuracy::record::{AccuracyRecord, AxisRecord, SceneOutcome, VariantRecord};

/// The part of rays that no kind stands for, as the axis `right-answers` has it.
pub const OFFSET_RAYS: &str = "leaving surfaces";

/// A name that table heads can have.
fn head(part: &str) -> &'static str {
    let kind = RayKind::ALL.into_iter().map(RayKind::name).find(|name| *name == part);
    kind.unwrap_or(if part == OFFSET_RAYS { OFFSET_RAYS } else { "other" })
}

/// Times of the variants of an axis by kind of ray, over all scenes; one table per subject, none if
/// work is timed as a whole.
pub fn over_scenes(axis: &AxisRecord, seed: u64) -> Vec<Table> {
    let subjects = axis.by_subject();
    subjects.iter().filter_map(|of| of_subject(&axis.axis, &of.scenes, seed)).collect()
}

fn of_subject(axis: &str, scenes: &[SceneOutcome], seed: u64) -> Option<Table> {
    let first = scenes.first()?;
    let leading = first.rows.first().filter(|row| !row.parts.is_empty())?;
    let parts: Vec<&str> = leading.parts.iter().map(|part| part.part.as_str()).collect();
    let rows = first.rows.iter().map(|row| {
        let of_part = |part: &&str| {
            let groups: Vec<Series> =
                scenes.iter().filter_map(|scene| of_variant(scene, &row.variant, part)).collect();
            geometric_mean_of(&groups, seed).map_or_else(dash, |e| ratio(&e).into())
        };
        let cells = std::iter::once(row.variant.clone().into());
        cells.chain(parts.iter().map(of_part)).collect()
    });
    let names: Vec<&str> = scenes.iter().map(|scene| scene.scene.as_str()).collect();
    let of = if first.subject.is_empty() { String::new() } else { format!(", {}", first.subject) };
    Some(Table {
        title: format!("{axis}{of}: time over that of {}, by kind of ray", leading.variant),
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
    let before = std::iter::once(None).chain(scene.rows.iter().map(Some));
    let rows = scene.rows.iter().zip(before).map(|(row, before)| {
        let or_dash = |cell: &dyn Fn(&VariantRecord) -> Cell| before.map_or_else(dash, cell);
        vec![
            row.variant.clone().into(),
            or_dash(&|before| over(row, before)),
            or_dash(&|_| over(row, first)),
            short(row.error.value()).into(),
            or_dash(&|before| short(before.error.value() - row.error.value()).into()),
        ]
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
fn more(e: &Estimate) -> String {
    let percent = |x: f64| format!("{:+.1}", (x - 1.0) * 100.0);
    let mark = if e.holds(1.0) { " =" } else { "" };
    format!("{}% [{}, {}]{mark}", percent(e.median), percent(e.low), percent(e.high))
}

/// The error whose removal has a price: a hundredth of the range of colours.
const UNIT: f64 = 0.01;
const MICROSECONDS: f64 = 1e6;

/// Seconds a pixel that a variant of an effect adds to the image without it, and its price: those
/// for each 0.01 of error removed, none where it removes none. `None` without rounds or pixels.
fn price(
    scene: &SceneOutcome,
    without: &VariantRecord,
    row: &VariantRecord,
    seed: u64,
) -> Option<(Estimate, Option<Estimate>)> {
    if scene.pixels == 0 {
        return None;
    }
    let added = scene.differences(&row.seconds, &without.seconds).estimate_of_differences(seed)?;
    let added = added.map(|s| s / f64::from(scene.pixels));
    let units = (without.error.value() - row.error.value()) / UNIT;
    Some((added, (units > 0.0).then(|| added.map(|s| s / units))))
}

/// Cost of each effect in scenes that need it, against the error without it; `None` where none was
/// measured. The price rises with the number of samples: the first ones remove the most.
pub fn effects(run: &AccuracyRecord) -> Option<Table> {
    // of images, the one that others are compared with is the one without effects
    let is_without = |row: &&VariantRecord| row.is_without || row.is_reference;
    let microseconds = |e: &Estimate| Cell::from(interval(&e.map(|s| s * MICROSECONDS)));
    let of_scene = |(axis, scene): (&AxisRecord, &SceneOutcome)| -> Vec<Vec<Cell>> {
        let Some(without) = scene.rows.iter().find(is_without) else { return Vec::new() };
        let with = scene.rows.iter().filter(|row| !is_without(row));
        let cells = with.filter_map(|row| {
            let (added, price) = price(scene, without, row, run.seed)?;
            Some(vec![
                axis.axis.clone().into(),
                scene.scene.clone().into(),
                row.variant.clone().into(),
                format!("{:.2e}", without.error.value()).into(),
                format!("{:.2e}", row.error.value()).into(),
                microseconds(&added),
                price.map_or_else(dash, |e| microseconds(&e)),
            ])
        });
        cells.collect()
    };
    let rows: Vec<Vec<Cell>> = run.scenes().flat_map(of_scene).collect();
    let notes = vec![
        "error: root mean square difference of colours (0 to 1) to the finely sampled image; added: \
         time beyond that of the image without the effect, in the same rounds; price: added time \
         per 0.01 of error removed; - if no error is removed."
            .to_owned(),
        "effect-gating: effects that the scene does not use, left out or simulated: they remove \
         no error, so any added time is wasted."
            .to_owned(),
    ];
    (!rows.is_empty()).then(|| Table {
        title: "effects: the price of each in scenes that use it".into(),
        header: vec![
            "effect",
            "scene",
            "variant",
            "error without",
            "error with",
            "added us per pixel [95%]",
            "price us per pixel [95%]",
        ],
        rows,
        notes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::record::made_up::{axis, row};
    use crate::accuracy::record::{ErrorOf, PartTime};

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

    fn image(seconds: f64, rmse: f64) -> VariantRecord {
        VariantRecord { error: ErrorOf::Rmse { rmse }, ..row("image", seconds, 0) }
    }

    fn price_of(pixels: u32, with: f64) -> Option<(Estimate, Option<Estimate>)> {
        let mut scene = axis(vec![image(1.0, 0.05), image(3.0, with)]).scenes.remove(0);
        scene.pixels = pixels;
        price(&scene, &scene.rows[0], &scene.rows[1], 1)
    }

    #[test]
    fn a_price_is_time_added_for_error_removed() {
        let (added, price) = price_of(100, 0.01).unwrap();
        assert!((added.median - 0.02).abs() < 1e-12);
        assert!((price.unwrap().median - 0.005).abs() < 1e-12, "{price:?}");
    }

    #[test]
    fn effects_that_remove_no_error_have_no_price() {
        let price = |rmse| price_of(100, rmse).unwrap().1;
        assert!(price(0.05).is_none() && price(0.06).is_none());
        assert!(price_of(0, 0.01).is_none());
    }
}
