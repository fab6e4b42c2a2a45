//! The record of a run: everything that tables, CSV and plots are made from, and what JSON holds.

pub mod file;
#[cfg(any(test, feature = "testing"))]
#[allow(clippy::unwrap_used)]
pub mod made_up;
pub mod merge;
pub mod metrics;
pub mod processes;
pub mod query;
pub mod reference;
mod row;
pub mod scale;
mod scene;
pub mod settings;
pub mod summary;
pub mod warning;
pub mod warnings;

use serde::{Deserialize, Serialize};

use crate::settings::shard::ShardRecord;

pub use processes::FloorRecord;
pub use row::{
    AnsweredRays, ForeignRecord, Outliers, PluginRecord, RowRecord, Sample, StatsRecord, Verdict,
    WorkRecord, label, with_query,
};
pub use scale::ScaleRecord;
pub use scene::{
    Conclusion, Defective, LeastTime, NextRow, OracleRecord, Question, SceneRecord, SummaryRow,
};
pub use settings::{Compiler, Load, Machine, Settings, Ticks, Tool};
pub use warning::Warning;

/// Version of this schema; raised when a field changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 2;

/// A run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct RunRecord {
    /// Version of this schema: 2. Raised when a field changes its meaning or goes away, not for new
    /// ones.
    pub schema_version: u32,
    /// What was run.
    pub tool: Tool,
    /// The command line, program first.
    pub command_line: Vec<String>,
    /// When it began, seconds since 1970.
    pub started_unix_s: u64,
    /// What it ran on.
    pub machine: Machine,
    /// What it was compiled with.
    pub compiler: Compiler,
    /// What was asked for.
    pub settings: Settings,
    /// One for each finished scene.
    pub scenes: Vec<SceneRecord>,
    /// Over all finished scenes, one for each row.
    pub summary: Vec<SummaryRow>,
    /// Which rows are the fastest and the smallest over all finished scenes, by geometric means;
    /// empty of one scene, and in records from before.
    #[serde(default)]
    pub conclusions: Vec<Conclusion>,
    /// Largest resident set of the process so far, bytes.
    pub peak_rss_bytes: Option<u64>,
    /// The scenes asked for, finished or not; empty in records from before there was a journal.
    #[serde(default)]
    pub planned: Vec<String>,
    /// Every scene had its turn; false in what a killed or interrupted run leaves.
    #[serde(default = "from_before")]
    pub complete: bool,
    /// How busy the machine was before the run and after it.
    #[serde(default)]
    pub load: [Load; 2],
    /// What makes the figures less certain than they look.
    #[serde(default)]
    pub warnings: Vec<Warning>,
    /// Which part of a run it is, where the run was divided by `--shard`.
    #[serde(default)]
    pub shard: Option<ShardRecord>,
    /// The parts that it was joined of; empty unless `rtbench merge` made it.
    #[serde(default)]
    pub parts: Vec<PartRecord>,
    /// How far a copy of the program was from the program; none where none was timed.
    #[serde(default)]
    pub floor: Option<FloorRecord>,
    /// The sizes and slopes, where the scenes are the sizes of one (`rtbench sweep --sizes`).
    #[serde(default)]
    pub scale: Option<ScaleRecord>,
}

impl RunRecord {
    /// Keeps some rows, and the scenes that have one.
    pub fn retain_rows(&mut self, is_kept: impl Fn(&str, &RowRecord) -> bool) {
        for SceneRecord { name, rows, .. } in &mut self.scenes {
            rows.retain(|row| is_kept(name, row));
        }
        self.scenes.retain(|scene| !scene.rows.is_empty());
    }
}

/// A part that a run was joined of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct PartRecord {
    /// Which part, from 1.
    pub index: u32,
    /// Its command line, program first.
    pub command_line: Vec<String>,
    /// What it ran on.
    pub machine: Machine,
    /// When it began, seconds since 1970.
    pub started_unix_s: u64,
}

/// Of records from before there was a journal.
fn from_before() -> bool {
    true
}
