//! What a run over sizes is asked for.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::settings::MeasuringSettings;
use crate::settings::sizes::Sizes;

/// What a run over sizes is asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScaleSettings {
    /// A generated scene, without a size.
    pub scene: String,
    /// Numbers of primitives; the nearest size of the scene stands for each.
    pub sizes: Sizes,
    /// How many sizes a factor of ten, where the sizes are a range.
    pub per_decade: u32,
    /// Structures and occluders, each with its settings if any; none means each at its defaults.
    pub structures: Vec<String>,
    /// Overrides of defaults: `uniform-grid.density=4`.
    pub overrides: Vec<String>,
    /// How to measure.
    pub measuring: MeasuringSettings,
    /// Longest build, without loading.
    pub time_limit: Duration,
    /// Most bytes of the process that loads the scene and builds.
    pub max_memory: u64,
}

impl ScaleSettings {
    /// Most sizes a factor of ten.
    pub const MOST_PER_DECADE: u32 = 20;
}
