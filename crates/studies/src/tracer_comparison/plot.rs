//! A comparison of tracers as a plot: error over time, both logarithmic.

use super::record::{ImageRecord, Outcome, TracersRecord};
use crate::accuracy::record::VariantStanding;
use presentation::svg_plot::{Axis, Level, Mark, Plot, Point, Ring, Scale, Series};

/// The images of a scene, those by samples joined.
pub fn error_over_time(record: &TracersRecord) -> Plot {
    let mark = |image: &ImageRecord| {
        let Outcome::Made { seconds, rmse: y, standing, .. } = &image.outcome else { return None };
        Some(Mark {
            // error bars are those of the vertical axis, and errors have none
            point: Point { x: record.time(seconds)?.median, y: *y, low: *y, high: *y },
            label: image.row.samples.map_or_else(|| image.row.label(), |n| n.to_string()),
            hover: String::new(),
            ring: match standing {
                VariantStanding::OnFront => Ring::Best,
                VariantStanding::NotToldApart => Ring::AsGood,
                VariantStanding::Dominated => Ring::None,
            },
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
