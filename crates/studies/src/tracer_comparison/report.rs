//! A comparison as tables, CSV, JSON and a plot; the columns of images stand here, one line each.

use std::fmt::Write as _;

use presentation::column;
use presentation::column::{Column, Unit, Value};
use presentation::json::FormatError;
use presentation::markdown::{code, push_table};
use presentation::numbers::{milliseconds, ratio, short};
use presentation::svg_plot::{Axis, Level, Mark, Plot, Point, Scale, Series, figure};
use presentation::table::{Cell, Style, Table};
use renderer::Image;

use crate::accuracy::record::VariantStanding;
use crate::tracer_comparison::record::{
    AtError, ImageMeasurement, ImageRecord, Outcome, TracersRecord,
};

pub struct Report {
    pub record: TracersRecord,
    pub reference: Image,
}

impl Report {
    /// A structure did not find what it must.
    pub fn is_failure(&self) -> bool {
        self.record.queries.iter().any(|q| q.missed > 0)
    }

    /// Images down; time, error and what they mean across.
    pub fn images(&self) -> Table {
        let [w, h] = self.record.resolution;
        let columns = columns();
        let mut table = Table {
            title: format!(
                "{}: images of {w} x {h} by samples, cones and beams ({} primitives)",
                self.record.scene, self.record.primitives
            ),
            ..column::table(&columns, &column::heads(&columns), self.image_rows())
        };
        for (cells, image) in table.rows.iter_mut().zip(&self.record.images) {
            if image.made().is_some_and(is_on_front) {
                cells.iter_mut().for_each(|cell| cell.style = Style::Best);
            }
        }
        let (own_error, samples) = (self.record.reference.own_error, self.record.reference.samples);
        table.notes.push(format!(
            "reference: the mean of two images of {samples} samples per pixel; its own error is \
             {}; errors below ten times that are marked <",
            short(own_error)
        ));
        table.notes.push(format!(
            "samples in f32 through {}, cones and beams in f64 through {}; {} thread(s); \
             structures are built before; edge: pixels that differ from a neighbour by 0.05",
            self.record.through[0], self.record.through[1], self.record.threads
        ));
        table.notes.extend(self.verdicts());
        table
    }

    fn image_rows(&self) -> impl Iterator<Item = ImageRow<'_>> {
        let record = &self.record;
        record.images.iter().map(move |image| ImageRow { record, image })
    }

    /// Conclusions of the table on cones and beams.
    fn verdicts(&self) -> Vec<String> {
        let say = |image: &ImageRecord| {
            let (label, m) = (image.row.short_label(), image.made()?);
            Some(match m.by_samples? {
                AtError::Reached { samples, seconds } => {
                    let ratio = m.median() / seconds;
                    let (times, than) =
                        if ratio >= 1.0 { (ratio, "longer") } else { (1.0 / ratio, "less") };
                    format!(
                        "{label}: as accurate as {} samples per pixel, and took {} times {than}",
                        short(samples),
                        short(times)
                    )
                }
                AtError::AtOnce { seconds } => format!(
                    "{label}: no more accurate than the fewest samples, and took {} times as \
                     long",
                    short(m.median() / seconds)
                ),
                AtError::Never { samples, seconds } => format!(
                    "{label}: more accurate than {samples} samples per pixel, in {} of their \
                     time",
                    short(m.median() / seconds)
                ),
            })
        };
        self.record.images.iter().filter_map(say).collect()
    }

    /// Structures down; what a candidate query of a pixel costs across.
    pub fn query_table(&self) -> Option<Table> {
        let (first, scene) = (self.record.queries.first()?, &self.record.scene);
        let mut table = Table {
            title: format!("{scene}: candidates of a pixel's beam or cone, one thread"),
            header: vec![
                "structure",
                "us/query",
                "to brute force [95%]",
                "cells",
                "references",
                "hull tests",
                "found",
                "verdict",
            ],
            ..Table::default()
        };
        for q in &self.record.queries {
            let per_query = |n: u64| short(n as f64 / q.queries.max(1) as f64);
            let (verdict, style) = match q.missed {
                0 => ("ok".to_owned(), Style::Plain),
                n => (format!("wrong: {n} queries miss what their ray hits"), Style::Bad),
            };
            let times = match q.missed {
                0 => [short(q.microseconds.median), ratio(&q.ratio_to_brute_force)],
                _ => ["-".into(), "-".into()],
            };
            let mut texts = vec![q.structure.clone()];
            texts.extend(times);
            texts.extend([q.cells, q.references, q.hull_tests, q.found].map(per_query));
            texts.push(verdict);
            table.rows.push(texts.into_iter().map(|text| Cell { text, style }).collect());
        }
        let note = "queries a round, rounds interleaved; counts are means a query";
        table.notes.push(format!("{} {note}", first.queries));
        Some(table)
    }

    pub fn to_markdown(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "# rtbench compare-tracers\n");
        let _ = writeln!(text, "- command: {}\n", code(&self.record.command_line.join(" ")));
        push_table(&mut text, &self.images());
        if let Some(table) = self.query_table() {
            push_table(&mut text, &table);
        }
        text
    }

    pub fn to_csv(&self) -> Result<String, FormatError> {
        column::csv(&columns(), self.image_rows())
    }

    /// Everything but the images, raw samples too.
    pub fn to_json(&self) -> Result<String, FormatError> {
        Ok(serde_json::to_string_pretty(&self.record)?)
    }

    pub fn to_svg(&self) -> String {
        figure(&[error_over_time(&self.record)])
    }
}

/// Error over time of the images of a scene, both logarithmic, those by samples joined.
pub fn error_over_time(record: &TracersRecord) -> Plot {
    let mark = |image: &ImageRecord| {
        let ImageMeasurement { seconds, error: y, standing, .. } = image.made()?;
        Some(Mark {
            // error bars are those of the vertical axis, and errors have none
            point: Point { x: record.time(seconds)?.median, y: *y, low: *y, high: *y },
            label: image.row.samples.map_or_else(|| image.row.label(), |n| n.to_string()),
            hover: String::new(),
            ring: standing.ring(),
            is_in_series: image.row.samples.is_some(),
        })
    };
    let marks: Vec<Mark> = record.images.iter().filter_map(mark).collect();
    let axis = |label: &str| Axis { label: label.to_owned(), scale: Scale::Log };
    let [width, height] = record.resolution;
    Plot {
        title: format!("{}: samples, cones and beams", record.scene),
        subtitle: format!(
            "{width} x {height} pixels, {} thread(s); ringed: nothing is faster and more accurate",
            record.threads
        ),
        x: axis("time of the image (seconds)"),
        y: axis("root mean square error"),
        series: vec![Series {
            name: "whitted, by samples per pixel".to_owned(),
            points: marks.iter().filter(|m| m.is_in_series).map(|m| m.point).collect(),
            is_joined: true,
        }],
        marks,
        marks_name: "cones and beams".to_owned(),
        levels: vec![Level {
            y: record.reference.own_error,
            label: "the reference's own error".to_owned(),
        }],
    }
}

#[derive(Clone, Copy)]
pub struct ImageRow<'a> {
    pub record: &'a TracersRecord,
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
        c(&["scene"], "", None, |of: &ImageRow<'a>| Text(of.record.scene.clone())),
        c(&["tracer"], "tracer", None, |of| Text(of.image.row.tracer.clone()))
            .or(|of| Some(of.image.row.short_label().into())),
        c(&["settings"], "", None, |of| Text(of.image.row.settings.clone())),
        c(&["samples"], "", None, |of| Value::of(of.image.row.samples.map(u64::from), Count)),
        c(&["image_s", "image_s_low", "image_s_high"], "image ms", Seconds, |of| {
            of.value(|m| Value::of(of.record.time(&m.seconds), Value::Measured))
        }).or(|of| of.text_cell(|m| milliseconds(m.median()))),
        c(&["ratio_to_cheapest", "ratio_low", "ratio_high"], "to cheapest [95%]", Ratio, |of| {
            of.value(|m| Value::of(m.ratio, Value::Measured))
        }),
        c(&["rmse"], "RMSE", None, |of| of.value(|m| Real(m.error))).or(|of| of.text_cell(rmse)),
        c(&["edge_rmse"], "edge RMSE", None, |of| of.value(|m| Value::of(m.edge_error, Real))),
        c(&["reference_error"], "", None, |of| of.value(|_| Real(of.record.reference.own_error))),
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
