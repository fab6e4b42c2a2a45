//! Content of `tracers.json`: one type for writer and reader; and the cost of reaching an error by
//! sampling, where time and error follow a power law between two numbers of samples.

use std::collections::BTreeMap;

use measurement::record::Machine;
use renderer::Image;
use serde::{Deserialize, Serialize};
use statistics::estimate::{Estimate, estimate, median};

use crate::accuracy::record::VariantStanding;

/// A comparison; its images are not written.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TracersRecord {
    /// The command line, program first.
    pub command_line: Vec<String>,
    /// Machine of the run; not read, as older records have other machines.
    #[serde(skip_deserializing)]
    pub machine: Option<Machine>,
    pub scene: String,
    #[serde(default)]
    pub primitives: usize,
    pub resolution: [u32; 2],
    /// Structures of sampling, and of cones and beams.
    #[serde(default)]
    pub through: [String; 2],
    pub threads: usize,
    pub seed: u64,
    pub reference: ReferenceRecord,
    pub images: Vec<ImageRecord>,
    #[serde(default)]
    pub queries: Vec<QueryRecord>,
}

impl TracersRecord {
    /// Seconds of an image, of those of each round, with their interval.
    pub fn time(&self, seconds: &[f64]) -> Option<Estimate> {
        estimate(seconds, self.seed)
    }
}

/// Reference of images: the mean of two.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ReferenceRecord {
    pub own_error: f64,
    /// Samples per pixel of each of the two.
    pub samples: u32,
}

/// An image by one way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImageRecord {
    pub row: RowName,
    pub outcome: Outcome,
}

impl ImageRecord {
    /// The measurements, unless the tracer refuses the scene.
    pub fn made(&self) -> Option<&ImageMeasurement> {
        match &self.outcome {
            Outcome::Made(measured) => Some(measured),
            Outcome::Refused { .. } => None,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RowName {
    pub tracer: String,
    /// Its settings where they are not the default ones.
    pub settings: String,
    /// Samples per pixel, for the tracer by samples.
    pub samples: Option<u32>,
}

impl RowName {
    /// `whitted 16`, `cone subdivisions=0`.
    pub fn short_label(&self) -> String {
        match self.samples {
            Some(n) => format!("{} {n}", self.tracer),
            None => format!("{} {}", self.tracer, self.settings).trim_end().to_owned(),
        }
    }

    /// `whitted 16 samples`
    pub fn label(&self) -> String {
        let unit = match self.samples {
            None => "",
            Some(1) => " sample",
            Some(_) => " samples",
        };
        self.short_label() + unit
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Outcome {
    /// The tracer refuses the scene.
    Refused {
        refused: String,
        /// The unsupported part.
        #[serde(skip)]
        what: String,
    },
    Made(ImageMeasurement),
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ImageMeasurement {
    pub seconds: Vec<f64>,
    #[serde(rename = "rmse")]
    pub error: f64,
    /// The same over the pixels of edges, if there are any.
    #[serde(rename = "edge_rmse", default)]
    pub edge_error: Option<f64>,
    /// The error is not ten times that of the reference.
    #[serde(rename = "below_reference")]
    pub is_below_reference: bool,
    /// True if another row is faster and has a smaller error.
    pub standing: VariantStanding,
    #[serde(default)]
    pub counts: BTreeMap<String, u64>,
    /// Time over that of the cheapest row, round by round.
    #[serde(skip)]
    pub ratio: Option<Estimate>,
    /// None of a record that was read.
    #[serde(skip)]
    pub image: Option<Image>,
    /// Time of sampling at the same error; `None` for sampling itself.
    #[serde(skip)]
    pub by_samples: Option<AtError>,
}

impl ImageMeasurement {
    pub fn median(&self) -> f64 {
        median(&self.seconds).unwrap_or(f64::NAN)
    }
}

/// Cost of the queries of a structure, and their work in one round.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct QueryRecord {
    pub structure: String,
    /// Queries a round: all pixels, or every so many of them.
    pub queries: usize,
    pub microseconds: Estimate,
    /// Its time over that of brute force on the same frusta in the same rounds.
    pub ratio_to_brute_force: Estimate,
    pub cells: u64,
    /// Ids in those cells.
    pub references: u64,
    /// Tests of a hull against a frustum.
    pub hull_tests: u64,
    pub found: u64,
    /// Queries that did not find what the ray through the pixel's centre hits: a wrong row.
    pub missed: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledImage {
    /// Samples per pixel.
    pub samples: f64,
    pub error: f64,
    pub seconds: f64,
}

/// Samples per pixel and seconds at which the samples reach an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AtError {
    /// By interpolation between two that were measured.
    Reached {
        /// Samples per pixel.
        samples: f64,
        seconds: f64,
    },
    /// One sample per pixel is as good already.
    AtOnce {
        /// Seconds of the image with the fewest samples.
        seconds: f64,
    },
    /// None that was measured has an error so small.
    Never {
        /// The most samples measured.
        samples: f64,
        /// Their seconds: it takes longer than this.
        seconds: f64,
    },
}

/// Point at which a series by samples, ascending, first has an error of at most `error`.
pub fn at_error(series: &[SampledImage], error: f64) -> Option<AtError> {
    let (first, last) = (series.first()?, series.last()?);
    if first.error <= error {
        return Some(AtError::AtOnce { seconds: first.seconds });
    }
    let reached = series.windows(2).find(|pair| pair[1].error <= error);
    let Some([before, after]) = reached else {
        return Some(AtError::Never { samples: last.samples, seconds: last.seconds });
    };
    // an error of 0 is reached where it was measured
    let share = if after.error > 0.0 {
        (before.error / error).ln() / (before.error / after.error).ln()
    } else {
        1.0
    };
    let between = |a: f64, b: f64| a * (b / a).powf(share);
    Some(AtError::Reached {
        samples: between(before.samples, after.samples),
        seconds: between(before.seconds, after.seconds),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_laws_are_interpolated_exactly() {
        let series: Vec<SampledImage> = [1.0f64, 4.0, 16.0, 64.0]
            .map(|n| SampledImage { samples: n, error: 0.1 / n.sqrt(), seconds: 0.01 * n })
            .to_vec();
        let Some(AtError::Reached { samples, seconds }) = at_error(&series, 0.1 / 9f64.sqrt())
        else {
            panic!("it lies between 4 and 16 samples")
        };
        assert!((samples - 9.0).abs() < 1e-9 && (seconds - 0.09).abs() < 1e-12);
        assert_eq!(at_error(&series, 0.2), Some(AtError::AtOnce { seconds: 0.01 }));
        let never = AtError::Never { samples: 64.0, seconds: 0.64 };
        assert_eq!(at_error(&series, 0.001), Some(never));
        assert_eq!(at_error(&[], 0.1), None);
    }
}
