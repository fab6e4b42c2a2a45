//! Samples, cones and beams on a scene: time against error, as `rtbench compare-tracers` found it.

use crate::report::glossary::look;
use crate::report::material::Material;
use crate::report::page::{Page, Shown};
use crate::report::records::{Outcome, TracersRecord};
use presentation::numbers::{milliseconds, short};
use presentation::page::tables::{self, words};
use presentation::table::Table;
use statistics::estimate::{Estimate, estimate};
use studies::tracer_comparison::plot::{Placed, error_over_time};

/// Scene by scene.
pub fn write(material: &Material, page: &mut Page) -> Shown {
    if material.tracers.is_empty() {
        return Shown::Missing;
    }
    for record in &material.tracers {
        page.html.element("h3", &[], &record.scene);
        page.plot(&format!("tracers-{}", record.scene), record.plot());
        tables::write(&mut page.html, &record.table(), look());
    }
    Shown::Yes
}

impl TracersRecord {
    fn time(&self, seconds: &[f64]) -> Option<Estimate> {
        estimate(seconds, self.seed)
    }

    fn table(&self) -> Table {
        let rows = self.images.iter().map(|image| {
            let mut cells = vec![image.row.label()];
            match &image.outcome {
                Outcome::Refused { refused } => {
                    cells.extend(["-", "-", "-"].map(str::to_owned));
                    cells.push(format!("refused: {refused}"));
                }
                Outcome::Made { seconds, rmse, below_reference, standing } => {
                    let below = if *below_reference { "< " } else { "" };
                    let time = self.time(seconds);
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
        let mut table = words(format!("{}: images", self.scene), header, rows.collect());
        table.notes.push(format!(
            "Reference: the mean of two images of {} samples per pixel; its own error is {}; errors \
             below ten times that are marked <.",
            self.reference.samples,
            short(self.reference.own_error)
        ));
        table
    }

    fn plot(&self) -> presentation::svg_plot::Plot {
        let placed = self.images.iter().filter_map(|image| {
            let Outcome::Made { seconds, rmse, standing, .. } = &image.outcome else { return None };
            Some(Placed {
                seconds: self.time(seconds)?.median,
                error: *rmse,
                samples: image.row.samples,
                label: image.row.label(),
                standing: *standing,
            })
        });
        error_over_time(
            &self.scene,
            self.resolution,
            self.threads,
            self.reference.own_error,
            placed.collect(),
        )
    }
}
