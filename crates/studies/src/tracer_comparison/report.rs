//! A comparison as tables, CSV, JSON and a plot.

use std::fmt::Write as _;

use renderer::Image;

use super::columns::{ImageRow, columns, is_on_front};
use super::equal_error::AtError;
use super::plot::error_over_time;
use super::record::{ImageRecord, Outcome, RowName, TracersRecord};
use super::{ImageMeasurement, TracerRow};
use presentation::column;
use presentation::json::FormatError;
use presentation::markdown::{code, push_table};
use presentation::numbers::{ratio, short};
use presentation::svg_plot::figure;
use presentation::table::{Cell, Style, Table};

/// A comparison with its images.
pub struct Report {
    pub record: TracersRecord,
    /// The image that all others are compared with.
    pub reference: Image,
    pub rows: Vec<TracerRow>,
}

impl Report {
    /// `record` has all but the images of `rows`.
    pub fn new(record: TracersRecord, reference: Image, rows: Vec<TracerRow>) -> Self {
        let images = rows.iter().map(image_record).collect();
        Self { record: TracersRecord { images, ..record }, reference, rows }
    }

    /// A structure did not find what it must.
    pub fn is_failure(&self) -> bool {
        self.record.queries.iter().any(|q| q.missed > 0)
    }

    fn measured(&self) -> impl Iterator<Item = (&TracerRow, &ImageMeasurement)> {
        self.rows.iter().filter_map(|row| Some((row, row.outcome.as_ref().ok()?)))
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
        for (cells, row) in table.rows.iter_mut().zip(&self.rows) {
            if row.outcome.as_ref().is_ok_and(is_on_front) {
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
        let (scene, seed, reference_error) =
            (&*self.record.scene, self.record.seed, self.record.reference.own_error);
        self.rows.iter().map(move |row| ImageRow { scene, seed, reference_error, row })
    }

    /// Conclusions of the table on cones and beams.
    fn verdicts(&self) -> Vec<String> {
        let say = |(row, m): (&TracerRow, &ImageMeasurement)| {
            let label = row.label();
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
        self.measured().filter_map(say).collect()
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

fn image_record(row: &TracerRow) -> ImageRecord {
    let tracer = row.tracer.to_owned();
    ImageRecord {
        row: RowName { tracer, settings: row.settings.clone(), samples: row.samples },
        outcome: match &row.outcome {
            Ok(m) => Outcome::Made {
                seconds: m.seconds.clone(),
                rmse: m.error,
                edge_rmse: m.edge_error,
                below_reference: m.is_below_reference,
                standing: m.standing,
                counts: m.counts.iter().map(|(kind, n)| ((*kind).to_owned(), *n)).collect(),
            },
            Err(refusal) => Outcome::Refused { refused: refusal.to_string() },
        },
    }
}
