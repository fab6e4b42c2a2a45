//! What the record of a run over the sizes of a scene holds beside its rows.

use serde::{Deserialize, Serialize};

use crate::record::row::label;

/// A scene in several sizes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct ScaleRecord {
    /// The scene, without a size.
    pub scene: String,
    /// The sizes measured, ascending; each is a scene of the run.
    pub sizes: Vec<SizeRecord>,
    /// Seconds that a build may take; rows that take longer are not measured.
    pub time_limit_s: f64,
    /// Bytes that a process may take which loads the scene and builds one row.
    pub max_memory_bytes: u64,
    /// How each quantity of each row grows, over the finished sizes.
    pub slopes: Vec<SlopeRecord>,
}

/// A size that was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct SizeRecord {
    /// Numbers of primitives asked for; this is the nearest size to each of them.
    pub asked: Vec<u64>,
    /// The scene of that size.
    pub name: String,
    /// Its primitives, by the generator's formula.
    pub primitives: u64,
}

/// How a quantity grows with the number of primitives: as that to the power of the slope.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct SlopeRecord {
    /// Name of the structure, without its settings.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// `build`, `trace`, `memory` or `peak`.
    pub quantity: String,
    /// Sizes that it was fitted to.
    pub sizes: u64,
    /// The slope of the line of least squares on logarithmic axes.
    pub slope: f64,
    /// Lower end of its 95% interval, by Student's distribution of the points' distances from the
    /// line; none of two sizes.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

impl ScaleRecord {
    pub fn size(&self, scene: &str) -> Option<&SizeRecord> {
        self.sizes.iter().find(|size| size.name == scene)
    }

    pub fn slope(&self, row: &str, quantity: &str) -> Option<&SlopeRecord> {
        let is =
            |s: &&SlopeRecord| s.quantity == quantity && label(&s.structure, &s.settings) == row;
        self.slopes.iter().find(is)
    }
}
