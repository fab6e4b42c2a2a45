//! A row over all finished scenes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::record::label::{label, with_query};
use crate::record::row::{Answered, RowRecord};
use crate::record::scene::SceneRecord;
use crate::record::verdict::Verdict;
use statistics::estimate::Estimate;

/// A row over all finished scenes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct SummaryRow {
    /// Structure.
    pub structure: String,
    /// What differs from its defaults.
    pub settings: String,
    /// Scenes that its means are over: those with a ratio, all of them to one reference.
    pub scenes: u64,
    /// Scenes where it gave wrong answers.
    pub wrong_scenes: u64,
    /// Scenes where it was not built, or panicked.
    pub not_built_scenes: u64,
    /// Wrong answers in all scenes.
    pub mismatches: u64,
    /// Which rays it answers.
    #[serde(default)]
    pub answers: Answered,
    /// Geometric mean over those scenes of the trace ratio.
    pub ratio: Option<Estimate>,
    /// The same for each kind of ray. Empty in records from before.
    #[serde(default)]
    pub ratio_by_kind: BTreeMap<String, Estimate>,
    /// Of those scenes, the ones where it answered batches.
    #[serde(default)]
    pub batch_scenes: u64,
    /// Geometric mean over those scenes of the build ratio.
    pub build_ratio: Option<Estimate>,
    /// What is said of it: the worst of its scenes.
    pub verdict: Verdict,
}

impl SummaryRow {
    /// Whether it may be called the best of anything in every scene that it is in.
    pub fn may_lead(&self, scenes: &[SceneRecord]) -> bool {
        let is_same =
            |row: &&RowRecord| row.structure == self.structure && row.settings == self.settings;
        scenes.iter().all(|scene| scene.rows.iter().filter(is_same).all(|row| scene.may_lead(row)))
    }

    /// Structure and settings, with a word where it answers batches in any of its scenes.
    pub fn label_with_query(&self) -> String {
        with_query(label(&self.structure, &self.settings), self.batch_scenes > 0)
    }
}
