//! What stages look at, and what they say.

use serde::Serialize;

use crate::gate::contest::{PairedTimes, place};
use crate::gate::thresholds::Thresholds;
use measurement::callgrind::CountedRow;
use measurement::record::{FloorRecord, RowRecord, RunRecord, SceneRecord};
use statistics::estimate::Estimate;

/// What became of something, best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Better by more than the threshold.
    Improved,
    /// Equal, or within the threshold.
    Unchanged,
    /// There is nothing to judge it by.
    NotJudged,
    /// It is indistinguishable from a regression.
    Inconclusive,
    /// Worse by more than the threshold.
    Regression,
    /// A structure gave wrong hits.
    WrongHits,
}

impl Outcome {
    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Improved => "improved",
            Self::Unchanged => "unchanged",
            Self::NotJudged => "not judged",
            Self::Inconclusive => "inconclusive",
            Self::Regression => "regression",
            Self::WrongHits => "wrong hits",
        }
    }
}

/// One thing that was judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The stage that judged it.
    #[serde(rename = "stage")]
    pub stage: &'static str,
    /// Scene.
    pub scene: String,
    /// Structure and settings.
    pub row: String,
    /// What of the row: a metric, `build`, `trace`, `answers`.
    pub quantity: &'static str,
    /// Its value in the baseline.
    pub baseline: Option<f64>,
    /// Its value now.
    pub now: Option<f64>,
    /// Now over the baseline; with an interval where it is a measured one.
    pub change: Option<Estimate>,
    /// The probability of such times without any difference, corrected for all that were tested.
    pub p: Option<f64>,
    /// What became of it.
    pub outcome: Outcome,
    /// What there is to say beyond the figures; empty where that is nothing.
    pub note: String,
}

impl Finding {
    /// A finding without figures.
    pub fn of(
        stage: &'static str,
        row: &MatchedRow<'_>,
        quantity: &'static str,
        outcome: Outcome,
        note: impl Into<String>,
    ) -> Self {
        Self::named(stage, &row.scene.1.name, row.now.label(), quantity, outcome, note)
    }

    /// The row with its scene, where it has one.
    pub fn place(&self) -> String {
        place(&self.scene, &self.row)
    }

    /// A finding of what has that name, without figures.
    pub fn named(
        stage: &'static str,
        scene: &str,
        row: String,
        quantity: &'static str,
        outcome: Outcome,
        note: impl Into<String>,
    ) -> Self {
        Self {
            stage,
            scene: scene.to_owned(),
            row,
            quantity,
            baseline: None,
            now: None,
            change: None,
            p: None,
            outcome,
            note: note.into(),
        }
    }
}

/// What is known of the instruction counts.
#[derive(Debug, Clone, Copy)]
pub enum Instructions<'a> {
    /// They were not asked for, and the baseline has none.
    NotAsked,
    /// They are wanted and could not be counted: why.
    Missing(&'a str),
    /// Counted.
    Counted {
        /// Of the baseline.
        base: &'a [CountedRow],
        /// Now.
        now: &'a [CountedRow],
    },
}

/// What times are compared by.
#[derive(Debug, Clone, Copy)]
pub enum Times<'a> {
    /// The samples of both records: ratios to the reference within each run.
    InRun {
        /// The share of the time in which some thread waited for a processor, of the busier of both
        /// runs; none where that is not known.
        cpu_pressure: Option<f64>,
    },
    /// Two binaries measured in turns: ratios within each turn.
    Paired(&'a [PairedTimes]),
}

/// Everything that stages look at.
#[derive(Debug, Clone, Copy)]
pub struct Evidence<'a> {
    /// What counts as a regression.
    pub thresholds: &'a Thresholds,
    /// The baseline, no more than what was measured anew.
    pub base: &'a RunRecord,
    /// What was measured.
    pub now: &'a RunRecord,
    /// Instruction counts.
    pub instructions: Instructions<'a>,
    /// Times.
    pub times: Times<'a>,
}

/// A row of both records.
#[derive(Debug, Clone, Copy)]
pub struct MatchedRow<'a> {
    /// The scene: in the baseline, now.
    pub scene: (&'a SceneRecord, &'a SceneRecord),
    /// The row in the baseline.
    pub base: &'a RowRecord,
    /// The row now.
    pub now: &'a RowRecord,
}

impl MatchedRow<'_> {
    /// Whether it is that row.
    pub fn is(&self, scene: &str, structure: &str, settings: &str) -> bool {
        let Self { scene: (_, own), now, .. } = self;
        own.name == scene && now.structure == structure && now.settings == settings
    }
}

impl<'a> Evidence<'a> {
    /// The larger of both records' floors.
    pub fn floor(&self) -> Option<FloorRecord> {
        let both = [&self.base.floor, &self.now.floor].into_iter().flatten();
        both.max_by(|a, b| a.floor.total_cmp(&b.floor)).cloned()
    }

    /// The rows that both records have, in the order of the newer one.
    pub fn rows(&self) -> Vec<MatchedRow<'a>> {
        let (base, now) = (self.base, self.now);
        let scenes = now.scenes.iter().filter_map(|scene| {
            let of_base = base.scenes.iter().find(|s| s.name == scene.name)?;
            Some((of_base, scene))
        });
        let matched = |scene: (&'a SceneRecord, &'a SceneRecord)| {
            scene.1.rows.iter().filter_map(move |now| {
                let base = scene.0.rows.iter().find(|r| r.is_same(now))?;
                Some(MatchedRow { scene, base, now })
            })
        };
        scenes.flat_map(matched).collect()
    }
}

/// A way to judge.
pub struct Stage {
    /// As in tables and files.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// What it says of the evidence.
    pub judge: fn(&Evidence<'_>) -> Vec<Finding>,
}
