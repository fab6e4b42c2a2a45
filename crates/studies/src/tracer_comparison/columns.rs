//! The columns of images: one line each, from which the table and CSV come.

use presentation::column::{Column, Unit, Value};
use presentation::numbers::{milliseconds, short};
use presentation::table::{Cell, Style};

use super::equal_error::AtError;
use super::record::{ImageMeasurement, ImageRecord, Outcome};
use crate::accuracy::record::VariantStanding;
use statistics::estimate::estimate;

#[derive(Clone, Copy)]
pub struct ImageRow<'a> {
    pub scene: &'a str,
    pub seed: u64,
    /// The reference's own error.
    pub reference_error: f64,
    pub image: &'a ImageRecord,
}

impl ImageRow<'_> {
    /// Value of an image that was measured.
    fn value(&self, of: impl FnOnce(&ImageMeasurement) -> Value) -> Value {
        self.image.made().map_or(Value::None, of)
    }

    /// The same in words.
    fn text_cell(&self, of: impl FnOnce(&ImageMeasurement) -> String) -> Option<Cell> {
        self.image.made().map(|measured| of(measured).into())
    }
}

/// All columns, in the order of the CSV file and of the table.
#[rustfmt::skip]
pub fn columns<'a>() -> [Column<ImageRow<'a>>; 14] {
    use Unit::{None, Ratio, Seconds};
    use Value::{Count, Real, Text};
    let c = Column::new;
    [
        c(&["scene"], "", None, |of: &ImageRow<'a>| Text(of.scene.to_owned())),
        c(&["tracer"], "tracer", None, |of| Text(of.image.row.tracer.clone()))
            .or(|of| Some(of.image.row.short_label().into())),
        c(&["settings"], "", None, |of| Text(of.image.row.settings.clone())),
        c(&["samples"], "", None, |of| Value::of(of.image.row.samples.map(u64::from), Count)),
        c(&["image_s", "image_s_low", "image_s_high"], "image ms", Seconds, |of| {
            of.value(|m| Value::of(estimate(&m.seconds, of.seed), Value::Measured))
        }).or(|of| of.text_cell(|m| milliseconds(m.median()))),
        c(&["ratio_to_cheapest", "ratio_low", "ratio_high"], "to cheapest [95%]", Ratio, |of| {
            of.value(|m| Value::of(m.ratio, Value::Measured))
        }),
        c(&["rmse"], "RMSE", None, |of| of.value(|m| Real(m.error))).or(|of| of.text_cell(rmse)),
        c(&["edge_rmse"], "edge RMSE", None, |of| of.value(|m| Value::of(m.edge_error, Real))),
        c(&["reference_error"], "", None, |of| of.value(|_| Real(of.reference_error))),
        c(&["below_reference"], "", None, |of| of.value(|m| Text(m.is_below_reference.to_string()))),
        c(&["on_front"], "front", None, |of| of.value(|m| Text(is_on_front(m).to_string())))
            .or(|of| of.text_cell(|m| front(m.standing).to_owned())),
        c(&["time_to_samples_of_equal_error"], "time / samples of equal error", None, |of| {
            of.value(|m| match m.by_samples {
                Some(AtError::Reached { seconds, .. }) => Real(m.median() / seconds),
                _ => Value::None,
            })
        }).or(|of| of.text_cell(|m| m.by_samples.map_or(String::new(), |at| against(m.median(), at)))),
        c(&[], "counted", None, |of| of.value(|m| Text(counted(m)))).or(refused),
        c(&["refused"], "", None, |of| match &of.image.outcome {
            Outcome::Refused { refused, .. } => Text(refused.clone()),
            Outcome::Made(_) => Value::None,
        }),
    ]
}

/// No other image takes less and is nearer to the right one.
pub fn is_on_front(measured: &ImageMeasurement) -> bool {
    measured.standing == VariantStanding::OnFront
}

fn rmse(measured: &ImageMeasurement) -> String {
    let below = if measured.is_below_reference { "<" } else { "" };
    format!("{below}{}", short(measured.error))
}

/// Returns whether anything beats a row: `*` where nothing does, `~` where it is not significantly
/// different.
fn front(standing: VariantStanding) -> &'static str {
    match standing {
        VariantStanding::OnFront => "*",
        VariantStanding::NotToldApart => "~",
        VariantStanding::Dominated => "",
    }
}

/// The time over that of samples with the same error.
fn against(seconds: f64, at: AtError) -> String {
    match at {
        AtError::Reached { samples, seconds: theirs } => {
            format!("{} ({} samples)", short(seconds / theirs), short(samples))
        }
        AtError::AtOnce { seconds: theirs } => format!("{} (fewest)", short(seconds / theirs)),
        AtError::Never { samples, seconds: theirs } => {
            format!("under {} (over {samples} samples)", short(seconds / theirs))
        }
    }
}

fn counted(measured: &ImageMeasurement) -> String {
    let counts = measured.counts.iter().map(|(kind, n)| format!("{n} {kind}"));
    counts.collect::<Vec<_>>().join(", ")
}

/// Refusal of a tracer, shown instead of its counters.
fn refused(of: &ImageRow<'_>) -> Option<Cell> {
    let Outcome::Refused { what, .. } = &of.image.outcome else { return None };
    Some(Cell { text: format!("refused: it has {what}"), style: Style::Dim })
}
