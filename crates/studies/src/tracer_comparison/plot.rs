//! A comparison of tracers as a plot: error over time, both logarithmic.

use crate::accuracy::record::VariantStanding;
use presentation::svg_plot::{Axis, Level, Mark, Plot, Point, Ring, Scale, Series};

/// An image and where it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct PlottedImage {
    pub seconds: f64,
    /// Root mean square error.
    pub error: f64,
    /// Samples per pixel, of images that are sampled.
    pub samples: Option<u32>,
    pub label: String,
    /// True if anything beats it.
    pub standing: VariantStanding,
}

impl PlottedImage {
    fn point(&self) -> Point {
        // error bars are those of the vertical axis, and errors have none
        Point { x: self.seconds, y: self.error, low: self.error, high: self.error }
    }

    fn mark(&self) -> Mark {
        Mark {
            hover: String::new(),
            point: self.point(),
            label: self.samples.map_or_else(|| self.label.clone(), |n| n.to_string()),
            ring: match self.standing {
                VariantStanding::OnFront => Ring::Best,
                VariantStanding::NotToldApart => Ring::AsGood,
                VariantStanding::Dominated => Ring::None,
            },
            is_in_series: self.samples.is_some(),
        }
    }
}

/// The images of a scene, those by samples joined.
pub fn error_over_time(
    scene: &str,
    [width, height]: [u32; 2],
    threads: usize,
    reference_error: f64,
    images: Vec<PlottedImage>,
) -> Plot {
    let axis = |label: &str| Axis { label: label.to_owned(), scale: Scale::Log };
    Plot {
        title: format!("{scene}: samples, cones and beams"),
        subtitle: format!(
            "{width} x {height} pixels, {threads} thread(s); ringed: nothing is faster and more accurate"
        ),
        x: axis("time of the image (seconds)"),
        y: axis("root mean square error"),
        series: vec![Series {
            name: "whitted, by samples per pixel".to_owned(),
            points: images
                .iter()
                .filter(|i| i.samples.is_some())
                .map(PlottedImage::point)
                .collect(),
            is_joined: true,
        }],
        marks: images.iter().map(PlottedImage::mark).collect(),
        marks_name: "cones and beams".to_owned(),
        levels: vec![Level { y: reference_error, label: "the reference's own error".to_owned() }],
    }
}
