//! Input and output of stages.

use serde::Serialize;

use crate::comparison::pairing::{Pairing, RowPair};
use crate::gate::contest::{Key, PairedTimes};
use crate::gate::thresholds::Thresholds;
use measurement::callgrind::CountedRow;
use measurement::record::{FloorRecord, RowRecord, RunRecord};
use statistics::estimate::Estimate;

/// Outcome of a check, best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GateOutcome {
    Improved,
    /// Equal, or certainly within the threshold.
    Unchanged,
    NotJudged,
    /// Neither a regression nor an improvement, nor certainly unchanged.
    Inconclusive,
    /// Worse by more than the threshold.
    Regression,
    WrongHits,
}

impl GateOutcome {
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
    #[serde(rename = "stage")]
    pub stage: &'static str,
    pub scene: String,
    pub row: String,
    /// Quantity of the row: a metric, `build`, `trace`, `answers`.
    pub quantity: &'static str,
    pub baseline: Option<f64>,
    pub now: Option<f64>,
    /// Now over the baseline; with an interval where it is a measured one.
    pub change: Option<Estimate>,
    /// The probability of such times without any difference, corrected for all that were tested.
    pub p: Option<f64>,
    pub outcome: GateOutcome,
    /// Free-form note, may be empty.
    pub note: String,
}

impl Finding {
    /// A finding without figures.
    pub fn of(
        stage: &'static str,
        row: &RowPair<'_>,
        quantity: &'static str,
        outcome: GateOutcome,
        note: impl Into<String>,
    ) -> Self {
        Self {
            stage,
            scene: row.scenes[1].name.clone(),
            row: row.rows[1].label(),
            quantity,
            baseline: None,
            now: None,
            change: None,
            p: None,
            outcome,
            note: note.into(),
        }
    }

    pub fn key(&self) -> Key {
        Key { scene: self.scene.clone(), row: self.row.clone(), quantity: self.quantity }
    }

    /// The row with its scene.
    pub fn place(&self) -> String {
        format!("{}: {}", self.scene, self.row)
    }
}

/// Availability of instruction counts.
#[derive(Debug, Clone, Copy)]
pub enum Instructions<'a> {
    /// They were not asked for, and the baseline has none.
    NotAsked,
    /// They are wanted and could not be counted: why.
    Missing(&'a str),
    Counted {
        base: &'a [CountedRow],
        now: &'a [CountedRow],
    },
}

/// Method of comparing times.
#[derive(Debug, Clone, Copy)]
pub enum Times<'a> {
    /// The samples of both records: ratios to the reference within each run.
    InRun {
        /// The share of the time in which some thread waited for a processor, of the busier of both
        /// runs; none where that is not known.
        cpu_pressure: Option<f64>,
        /// Ratios are judged though the baseline's processor is another.
        across_processors: bool,
    },
    /// Two programs measured in turns: ratios within each turn.
    Paired {
        pairs: &'a [PairedTimes],
        /// Number of looks at the results, the last one included.
        looks: u32,
    },
}

/// Everything that stages look at.
#[derive(Debug, Clone, Copy)]
pub struct Evidence<'a> {
    pub thresholds: &'a Thresholds,
    /// The baseline, no more than what was measured anew.
    pub base: &'a RunRecord,
    pub now: &'a RunRecord,
    pub instructions: Instructions<'a>,
    pub times: Times<'a>,
}

impl<'a> Evidence<'a> {
    /// The larger of both records' floors.
    pub fn floor(&self) -> Option<FloorRecord> {
        let both = [&self.base.floor, &self.now.floor].into_iter().flatten();
        both.max_by(|a, b| a.floor.total_cmp(&b.floor)).cloned()
    }

    /// The rows that both records have.
    pub fn rows(&self) -> Vec<RowPair<'a>> {
        Pairing::of(self.base, self.now).scenes.into_iter().flat_map(|scene| scene.rows).collect()
    }

    /// Returns whether some rows are asked about, and none of these was built on either side.
    pub fn is_unbuilt(&self, is_asked: impl Fn(&RowRecord) -> bool) -> bool {
        let rows = self.rows();
        let mut asked = rows.iter().filter(|pair| is_asked(pair.rows[1])).peekable();
        let is_unbuilt = |pair: &RowPair<'_>| pair.rows.iter().all(|row| !row.verdict.is_judged());
        asked.peek().is_some() && asked.all(is_unbuilt)
    }
}

/// A way to judge.
pub struct Stage {
    /// As in tables and files.
    pub name: &'static str,
    pub summary: &'static str,
    pub judge: fn(&Evidence<'_>) -> Vec<Finding>,
}
