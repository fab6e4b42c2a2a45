//! Cost of each effect in scenes that need it, against the error without it.
//!
//! The error that is removed is that to the finely sampled image, without the effect less with it;
//! the time is what the image takes beyond that without the effect, in the same rounds. Their
//! quotient is the price of a hundredth of the range of colours, a pixel. It rises with the number
//! of samples: the first ones remove the most.

use presentation::numbers::interval;
use presentation::table::{Cell, Table, dash};
use statistics::estimate::Estimate;

use crate::accuracy::record::{AccuracyRecord, SceneOutcome, VariantRecord};

/// The error whose removal has a price: a hundredth of the range of colours.
const UNIT: f64 = 0.01;
const MICROSECONDS: f64 = 1e6;

/// Cost of a variant of an effect over an image without the effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Price {
    /// Error that it removes, root mean square of colours; negative where it adds some.
    pub removed: f64,
    pub added_s: Estimate,
}

impl Price {
    /// Seconds a pixel for each 0.01 of error removed; `None` where it removes none.
    pub fn per_unit_s(&self) -> Option<Estimate> {
        let units = self.removed / UNIT;
        (units > 0.0).then(|| self.added_s.map(|x| x / units))
    }
}

/// The price of a variant over the image without it; `None` without rounds or pixels.
pub fn price(
    scene: &SceneOutcome,
    without: &VariantRecord,
    row: &VariantRecord,
    seed: u64,
) -> Option<Price> {
    let added = scene.differences(&row.seconds, &without.seconds).estimate_of_differences(seed)?;
    let added_s = added.map(|s| s / f64::from(scene.pixels));
    let removed = without.error.value() - row.error.value();
    (scene.pixels > 0).then_some(Price { removed, added_s })
}

/// The table over all effects of a run that were measured; `None` where none was.
pub fn table(run: &AccuracyRecord) -> Option<Table> {
    let mut rows = Vec::new();
    for axis in &run.axes {
        for scene in &axis.scenes {
            // of images, the one that others are compared with is the one without effects
            let is_without = |row: &VariantRecord| row.is_without || row.is_reference;
            let of_image = scene.rows.iter().filter(|_| scene.pixels > 0);
            let Some(without) = of_image.clone().find(|row| is_without(row)) else { continue };
            let with = of_image.filter(|row| !is_without(row));
            rows.extend(with.filter_map(|row| cells(&axis.axis, scene, without, row, run.seed)));
        }
    }
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

fn cells(
    effect: &str,
    scene: &SceneOutcome,
    without: &VariantRecord,
    row: &VariantRecord,
    seed: u64,
) -> Option<Vec<Cell>> {
    let price = price(scene, without, row, seed)?;
    let in_microseconds = |e: &Estimate| interval(&e.map(|s| s * MICROSECONDS));
    Some(vec![
        effect.to_owned().into(),
        scene.scene.clone().into(),
        row.variant.clone().into(),
        format!("{:.2e}", without.error.value()).into(),
        format!("{:.2e}", row.error.value()).into(),
        in_microseconds(&price.added_s).into(),
        price.per_unit_s().map_or_else(dash, |e| in_microseconds(&e).into()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::record::ErrorOf;
    use crate::accuracy::test_records::{axis, row};

    fn image(seconds: f64, rmse: f64) -> VariantRecord {
        VariantRecord { error: ErrorOf::Rmse { rmse }, ..row("image", seconds, 0) }
    }

    fn price_of(pixels: u32, with: f64) -> Option<Price> {
        let mut scene = axis(vec![image(1.0, 0.05), image(3.0, with)]).scenes.remove(0);
        scene.pixels = pixels;
        price(&scene, &scene.rows[0], &scene.rows[1], 1)
    }

    #[test]
    fn a_price_is_time_added_for_error_removed() {
        let price = price_of(100, 0.01).unwrap();
        assert!(
            (price.removed - 0.04).abs() < 1e-12 && (price.added_s.median - 0.02).abs() < 1e-12
        );
        let per_unit = price.per_unit_s().unwrap().median;
        assert!((per_unit - 0.005).abs() < 1e-12, "{per_unit}");
    }

    #[test]
    fn effects_that_remove_no_error_have_no_price() {
        let per_unit = |rmse| price_of(100, rmse).unwrap().per_unit_s();
        assert!(per_unit(0.05).is_none() && per_unit(0.06).is_none());
        assert!(price_of(0, 0.01).is_none());
    }
}
