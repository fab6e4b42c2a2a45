//! Samples, cones and beams on a scene: time against error, as `rtbench compare-tracers` found it.

use crate::report::glossary::look;
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use presentation::numbers::{milliseconds, short};
use presentation::page::tables::{self, words};
use presentation::table::Table;
use studies::tracer_comparison::plot::{PlottedImage, error_over_time};
use studies::tracer_comparison::record::{Outcome, TracersRecord};

pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
    if material.tracers.is_empty() {
        return SectionOutcome::Missing;
    }
    for record in &material.tracers {
        page.html.element("h3", &[], &record.scene);
        page.plot(&format!("tracers-{}", record.scene), plot(record));
        tables::write(&mut page.html, &table(record), look());
    }
    SectionOutcome::Yes
}

fn table(record: &TracersRecord) -> Table {
    let rows = record.images.iter().map(|image| {
        let mut cells = vec![image.row.label()];
        match &image.outcome {
            Outcome::Refused { refused } => {
                cells.extend(["-", "-", "-"].map(str::to_owned));
                cells.push(format!("refused: {refused}"));
            }
            Outcome::Made { seconds, rmse, below_reference, standing, .. } => {
                let below = if *below_reference { "< " } else { "" };
                let time = record.time(seconds);
                cells.push(time.map_or("-".to_owned(), |t| milliseconds(t.median)));
                cells.push(time.map_or("-".to_owned(), |t| {
                    format!("[{}, {}]", milliseconds(t.low), milliseconds(t.high))
                }));
                cells.push(format!("{below}{}", short(*rmse)));
                cells.push(standing.name().to_owned());
            }
        }
        cells
    });
    let header = vec!["tracer", "image, milliseconds", "95%", "RMSE", "stands"];
    let mut table = words(format!("{}: images", record.scene), header, rows.collect());
    table.notes.push(format!(
        "Reference: the mean of two images of {} samples per pixel; its own error is {}; errors \
         below ten times that are marked <.",
        record.reference.samples,
        short(record.reference.own_error)
    ));
    table
}

fn plot(record: &TracersRecord) -> presentation::svg_plot::Plot {
    let placed = record.images.iter().filter_map(|image| {
        let Outcome::Made { seconds, rmse, standing, .. } = &image.outcome else { return None };
        Some(PlottedImage {
            seconds: record.time(seconds)?.median,
            error: *rmse,
            samples: image.row.samples,
            label: image.row.label(),
            standing: *standing,
        })
    });
    error_over_time(
        &record.scene,
        record.resolution,
        record.threads,
        record.reference.own_error,
        placed.collect(),
    )
}
