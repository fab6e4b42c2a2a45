//! Settings of a run, from the command line, a file or an earlier record.

pub mod choice;
pub mod quantity;
pub mod shard;

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::rays::order::Orders;
use crate::settings::choice::{Choice, as_typed};
use crate::settings::shard::Shard;

/// Which lights shadow rays run to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Lights {
    /// Every light that a hit faces, from every hit.
    #[default]
    Each,
    /// The first light, from primary hits only: one shadow ray per hit.
    First,
}

impl Choice for Lights {
    const ALL: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Each, "each", "From every hit, each that the hit faces"),
        (Self::First, "first", "From every primary hit, the first: one shadow ray per hit"),
    ];
}

impl Lights {
    pub fn name(self) -> &'static str {
        self.as_typed()
    }
}

/// Arithmetic of primitives and rays.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Precision {
    #[default]
    F32,
    F64,
}

impl Choice for Precision {
    const ALL: &'static [(Self, &'static str, &'static str)] =
        &[(Self::F32, "f32", "Single"), (Self::F64, "f64", "Double")];
}

impl Precision {
    pub fn name(self) -> &'static str {
        self.as_typed()
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeasuringSettings {
    /// Kinds of rays; none means all.
    pub rays: Vec<String>,
    /// The order in which rays are issued to rows.
    #[serde(with = "as_typed")]
    pub order: Orders,
    #[serde(with = "as_typed")]
    pub lights: Lights,
    /// Longest pass over the rays; none means that of a full run or of a quick one.
    pub pass_limit: Option<Duration>,
    pub rounds: Option<u32>,
    /// Time for all rounds, all scenes together, where no rounds are said.
    pub time_budget: Option<Duration>,
    /// Small images and few rounds.
    pub quick: bool,
    pub threads: u16,
    /// Seed of schedules, samples and intervals.
    pub seed: u64,
    /// The reference row of ratios; none means the default.
    pub reference: Option<String>,
    #[serde(with = "as_typed")]
    pub precision: Precision,
    /// Width and height of the image; none means that of a full run or of a quick one.
    pub size: Option<u32>,
    /// Most memory of a structure, bytes; none means
    /// [`memory_limit`](crate::system::machine::memory_limit)'s.
    pub max_memory: Option<u64>,
}

impl MeasuringSettings {
    pub const MOST_THREADS: u16 = 1024;
    pub const MOST_ROUNDS: u32 = 10_000;
    /// Largest width and height of an image.
    pub const LARGEST_SIZE: u32 = 8192;
}

impl Default for MeasuringSettings {
    fn default() -> Self {
        Self {
            rays: Vec::new(),
            order: Orders::default(),
            lights: Lights::default(),
            pass_limit: None,
            rounds: None,
            time_budget: None,
            quick: false,
            threads: 1,
            seed: 1,
            reference: None,
            precision: Precision::default(),
            size: None,
            max_memory: None,
        }
    }
}

/// Where a number is out of range, [`Plan::new`](crate::plan::Plan::new) says so.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RunSettings {
    /// Scenes, scene sets or scene files; none means the default set.
    pub scenes: Vec<String>,
    /// Structures and occluders, each with its settings if any, as
    /// [`Params::label`](accel_core::params::Params::label) has them; none means all.
    pub structures: Vec<String>,
    /// Overrides of defaults: `uniform-grid.density=4`.
    pub overrides: Vec<String>,
    pub measuring: MeasuringSettings,
    /// The part of the table that is measured; none means all of it.
    pub shard: Option<Shard>,
    /// Tables of each kind of ray are wanted, too.
    pub by_kind: bool,
    /// Processes in which each scene is built and timed; 0 is 1.
    pub processes: u32,
}

impl RunSettings {
    pub const MOST_PROCESSES: u32 = 1000;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run() -> RunSettings {
        RunSettings {
            scenes: vec!["balls:4".into()],
            overrides: vec!["uniform-grid.density=4".into()],
            measuring: MeasuringSettings {
                rays: vec!["shadow".into()],
                order: Orders::Both,
                lights: Lights::First,
                pass_limit: Some(Duration::from_millis(100)),
                rounds: Some(7),
                precision: Precision::F64,
                max_memory: Some(u64::MAX),
                ..MeasuringSettings::default()
            },
            shard: Some(Shard { index: 2, count: 8 }),
            ..RunSettings::default()
        }
    }

    #[test]
    fn settings_survive_a_round_trip() {
        let text = serde_json::to_string(&run()).unwrap();
        assert_eq!(serde_json::from_str::<RunSettings>(&text).unwrap(), run(), "{text}");
    }

    #[test]
    fn invalid_settings_cannot_be_deserialized() {
        let text = serde_json::to_string(&run()).unwrap();
        for (from, to, said) in [
            ("2/8", "0/0", "expected I/N"),
            ("\"both\"", "\"none\"", "'none' is not a valid value"),
            ("\"seed\":1", "\"seed\":-1", "expected u64"),
        ] {
            let error = serde_json::from_str::<RunSettings>(&text.replace(from, to)).unwrap_err();
            assert!(error.to_string().contains(said), "{said}: {error}");
        }
    }

    #[test]
    fn values_are_parsed_from_their_names() {
        assert_eq!(Lights::typed("first"), Some(Lights::First));
        assert_eq!(Precision::typed("f16"), None);
        assert_eq!((Lights::Each.name(), Precision::F64.name()), ("each", "f64"));
    }
}
