//! What a run was asked for.

use serde::{Deserialize, Serialize};

use crate::rays::order::Orders;
use crate::scenes::ViewOptions;
use crate::settings::Lights;

/// Settings of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Settings {
    /// Seed of schedules, samples, directions and intervals.
    pub seed: u64,
    /// Threads that built and traced.
    pub threads: usize,
    /// `f32` or `f64`.
    pub precision: String,
    /// Pixels of the image.
    pub resolution: [u32; 2],
    /// Longest chain of closest-hit rays.
    pub max_depth: u32,
    /// Kinds of rays.
    pub rays: Vec<String>,
    /// The reference row of ratios, in every scene where it was built and is right; see
    /// `is_reference` of the rows.
    pub reference: String,
    /// Run with `--quick`.
    pub quick: bool,
    /// In which order rays were issued to rows: `scanline`, `shuffled`, or `both`.
    #[serde(default = "scanline")]
    pub order: String,
    /// Which lights were asked: `each` that a hit faces, or from primary hits the `first`.
    #[serde(default = "each_light")]
    pub lights: String,
    /// What the command line said of the view and the lights of all scenes; absent where it said
    /// nothing.
    #[serde(default, skip_serializing_if = "ViewOptions::is_empty")]
    pub view: ViewOptions,
    /// Tables of each kind of ray, and of the time to a picture, were asked for.
    #[serde(default)]
    pub by_kind: bool,
    /// Processes in which rows were built and timed, each scene in each of them.
    #[serde(default = "one")]
    pub processes: u32,
    /// What times are: `processor time` of the thread that builds and traces, where that is one;
    /// else `time of day`.
    #[serde(default = "time_of_day")]
    pub timed_by: String,
}

/// Of records from before threads were timed by their own time.
fn time_of_day() -> String {
    TIME_OF_DAY.to_owned()
}

/// What a run of one thread is timed by.
pub const PROCESSOR_TIME: &str = "processor time";
pub const TIME_OF_DAY: &str = "time of day";

/// Of records from before there could be more.
fn one() -> u32 {
    1
}

/// Of records from before there were orders.
fn scanline() -> String {
    Orders::Scanline.name().to_owned()
}

/// Of records from before lights could be chosen.
fn each_light() -> String {
    Lights::Each.name().to_owned()
}
