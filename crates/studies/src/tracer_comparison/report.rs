//! A comparison as tables, CSV, JSON and a plot.

use std::fmt::Write as _;

use accel_core::query::region::FrustumWork;

use super::columns::{ImageRow, columns, is_on_front};
use super::equal_error::AtError;
use super::plot::{PlottedImage, error_over_time};
use super::queries::QueryRow;
use super::record::{ImageRecord, Outcome, QueryRecord, ReferenceRecord, RowName, TracersRecord};
use super::{ImageMeasurement, TracerRow};
use crate::image_error::ConvergedImage;
use measurement::record::Machine;
use presentation::column;
use presentation::json::FormatError;
use presentation::markdown::{code, push_table};
use presentation::numbers::{ratio, short};
use presentation::svg_plot::figure;
use presentation::table::{Cell, Style, Table};
use statistics::estimate::{Estimate, estimate};

pub struct Report {
    pub scene: String,
    pub primitives: usize,
    /// Width and height of the images.
    pub resolution: [u32; 2],
    /// Structures of sampling, and of cones and beams.
    pub through: [String; 2],
    pub threads: usize,
    pub seed: u64,
    pub command_line: Vec<String>,
    pub machine: Machine,
    /// Reference of the image errors.
    pub reference: ConvergedImage,
    /// Samples per pixel of each of its two images.
    pub reference_samples: u32,
    pub rows: Vec<TracerRow>,
    /// The candidate queries; empty where no tracer that makes them took part.
    pub queries: Vec<QueryRow>,
}

impl Report {
    /// A structure did not find what it must.
    pub fn is_failure(&self) -> bool {
        self.queries.iter().any(|q| q.missed > 0)
    }

    fn measured(&self) -> impl Iterator<Item = (&TracerRow, &ImageMeasurement)> {
        self.rows.iter().filter_map(|row| Some((row, row.outcome.as_ref().ok()?)))
    }

    /// Seconds of an image with their interval.
    fn seconds(&self, m: &ImageMeasurement) -> Option<Estimate> {
        estimate(&m.seconds, self.seed)
    }

    /// Images down; time, error and what they mean across.
    pub fn images(&self) -> Table {
        let [w, h] = self.resolution;
        let columns = columns();
        let mut table = Table {
            title: format!(
                "{}: images of {w} x {h} by samples, cones and beams ({} primitives)",
                self.scene, self.primitives
            ),
            ..column::table(&columns, &column::heads(&columns), self.image_rows())
        };
        for (cells, row) in table.rows.iter_mut().zip(&self.rows) {
            if row.outcome.as_ref().is_ok_and(is_on_front) {
                cells.iter_mut().for_each(|cell| cell.style = Style::Best);
            }
        }
        let (own_error, samples) = (self.reference.own_error, self.reference_samples);
        table.notes.push(format!(
            "reference: the mean of two images of {samples} samples per pixel; its own error is \
             {}; errors below ten times that are marked <",
            short(own_error)
        ));
        table.notes.push(format!(
            "samples in f32 through {}, cones and beams in f64 through {}; {} thread(s); \
             structures are built before; edge: pixels that differ from a neighbour by 0.05",
            self.through[0], self.through[1], self.threads
        ));
        table.notes.extend(self.verdicts());
        table
    }

    fn image_rows(&self) -> impl Iterator<Item = ImageRow<'_>> {
        let (scene, seed, reference_error) = (&*self.scene, self.seed, self.reference.own_error);
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
        let first = self.queries.first()?;
        let mut table = Table {
            title: format!("{}: candidates of a pixel's beam or cone, one thread", self.scene),
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
        for q in &self.queries {
            let per_query = |n: u64| short(n as f64 / q.work.queries.max(1) as f64);
            let (verdict, style) = match q.missed {
                0 => ("ok".to_owned(), Style::Plain),
                n => (format!("wrong: {n} queries miss what their ray hits"), Style::Bad),
            };
            let times = match q.missed {
                0 => [short(q.microseconds.median), ratio(&q.ratio)],
                _ => ["-".into(), "-".into()],
            };
            let mut texts = vec![q.structure.to_owned()];
            texts.extend(times);
            let FrustumWork { cells, references, tests, found, .. } = q.work;
            texts.extend([cells, references, tests, found].map(per_query));
            texts.push(verdict);
            table.rows.push(texts.into_iter().map(|text| Cell { text, style }).collect());
        }
        table.notes.push(format!(
            "{} queries a round, rounds interleaved; counts are means a query",
            first.queries
        ));
        Some(table)
    }

    pub fn to_markdown(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "# rtbench compare-tracers\n");
        let _ = writeln!(text, "- command: {}\n", code(&self.command_line.join(" ")));
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
        serde_json::to_string_pretty(&self.record())
            .map_err(|e| FormatError { format: "JSON", message: e.to_string() })
    }

    fn record(&self) -> TracersRecord {
        let outcome = |row: &TracerRow| match &row.outcome {
            Ok(m) => Outcome::Made {
                seconds: m.seconds.clone(),
                rmse: m.error,
                edge_rmse: m.edge_error,
                below_reference: m.is_below_reference,
                standing: m.standing,
                counts: m.counts.iter().map(|(kind, n)| ((*kind).to_owned(), *n)).collect(),
            },
            Err(refusal) => Outcome::Refused { refused: refusal.to_string() },
        };
        let image = |row: &TracerRow| ImageRecord {
            row: RowName {
                tracer: row.tracer.to_owned(),
                settings: row.settings.clone(),
                samples: row.samples,
            },
            outcome: outcome(row),
        };
        let query = |q: &QueryRow| QueryRecord {
            structure: q.structure.to_owned(),
            queries: q.queries,
            microseconds: q.microseconds,
            ratio_to_brute_force: q.ratio,
            cells: q.work.cells,
            references: q.work.references,
            hull_tests: q.work.tests,
            found: q.work.found,
            missed: q.missed,
        };
        TracersRecord {
            command_line: self.command_line.clone(),
            machine: Some(self.machine.clone()),
            scene: self.scene.clone(),
            primitives: self.primitives,
            resolution: self.resolution,
            through: self.through.clone(),
            threads: self.threads,
            seed: self.seed,
            reference: ReferenceRecord {
                own_error: self.reference.own_error,
                samples: self.reference_samples,
            },
            images: self.rows.iter().map(image).collect(),
            queries: self.queries.iter().map(query).collect(),
        }
    }

    /// Error over time, both logarithmic.
    pub fn to_svg(&self) -> String {
        let images = self.measured().filter_map(|(row, m)| {
            Some(PlottedImage {
                seconds: self.seconds(m)?.median,
                error: m.error,
                samples: row.samples,
                label: row.label(),
                standing: m.standing,
            })
        });
        let own_error = self.reference.own_error;
        let images = images.collect();
        figure(&[error_over_time(&self.scene, self.resolution, self.threads, own_error, images)])
    }
}
