//! Results of an axis: rows of variants, by scene, and how wrong each is.

use std::collections::BTreeMap;

use presentation::svg_plot::Ring;
use serde::{Deserialize, Serialize};
use statistics::estimate::Estimate;
use statistics::series::Series;

/// Standing of a variant among those of its axis on a scene.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VariantStanding {
    /// No other is as accurate and as fast, and better in one of both.
    OnFront,
    /// Only variants whose time no difference was measured to beat it.
    NotToldApart,
    /// Another is as accurate and faster, or as fast and more accurate.
    #[default]
    Dominated,
}

impl VariantStanding {
    /// As tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::OnFront => "front",
            Self::NotToldApart => "~front",
            Self::Dominated => "-",
        }
    }

    /// Around its point in plots.
    pub fn ring(self) -> Ring {
        match self {
            Self::OnFront => Ring::Best,
            Self::NotToldApart => Ring::AsGood,
            Self::Dominated => Ring::None,
        }
    }
}

/// Time of one kind of ray within a variant's work.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartTime {
    pub part: String,
    /// Seconds of each round, process by process.
    pub seconds: Vec<f64>,
    /// Time over that of the first variant in the same rounds.
    pub ratio: Estimate,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariantRecord {
    pub variant: String,
    /// How to have it without this command, in the words of the command line.
    pub setting: String,
    /// Known defect, by design.
    pub known_defect: Option<String>,
    /// It is the one that all others are compared with, or has the same answers.
    pub is_reference: bool,
    pub error: ErrorOf,
    /// The error is too near to that of the reference itself to be told.
    pub is_below_reference: bool,
    /// Seconds of each round, process by process.
    pub seconds: Vec<f64>,
    pub time_s: Estimate,
    /// Time over that of the cheapest variant in the same rounds.
    pub ratio: Estimate,
    pub standing: VariantStanding,
    /// More of it, by name.
    pub also: BTreeMap<String, f64>,
    /// Its parts, where they are timed one by one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartTime>,
    /// It is what there is without any of the variants, and no variant itself: ratios are not taken
    /// to it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_without: bool,
}

/// The time of what has none.
pub const NO_TIME: Estimate = Estimate { median: f64::NAN, low: f64::NAN, high: f64::NAN };

impl VariantRecord {
    /// A variant that is judged and not timed yet.
    pub fn new(variant: String, setting: String, error: ErrorOf) -> Self {
        Self {
            variant,
            setting,
            known_defect: None,
            is_reference: false,
            error,
            is_below_reference: false,
            seconds: Vec::new(),
            time_s: NO_TIME,
            ratio: NO_TIME,
            standing: VariantStanding::default(),
            also: BTreeMap::new(),
            parts: Vec::new(),
            is_without: false,
        }
    }
}

fn is_none(pixels: &u32) -> bool {
    *pixels == 0
}

fn one() -> u32 {
    1
}

fn is_one(processes: &u32) -> bool {
    *processes == 1
}

/// An axis on a scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneOutcome {
    pub scene: String,
    /// Through which structure, where an axis has several.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub subject: String,
    /// Each variant is the one before it with one thing more.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_stepwise: bool,
    /// Pixels of the image that was timed; 0 where none was.
    #[serde(default, skip_serializing_if = "is_none")]
    pub pixels: u32,
    pub timed: String,
    pub judged: String,
    /// The reference's own error; 0 where it is exact.
    pub reference_error: f64,
    /// Variants in the order of the axis.
    pub rows: Vec<VariantRecord>,
    /// Impossible results, if any; see [`crate::accuracy::timing`].
    pub faults: Vec<String>,
    /// Processes that timed the variants, each in as many rounds.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub processes: u32,
}

impl SceneOutcome {
    /// What an axis says of its work, before its variants are timed.
    pub fn new(timed: impl Into<String>, judged: impl Into<String>) -> Self {
        Self { timed: timed.into(), judged: judged.into(), processes: 1, ..Self::default() }
    }

    pub fn series(&self, seconds: &[f64]) -> Series {
        Series::of_pairs(seconds, seconds, self.processes, |s, _| s)
    }

    /// One's time over another's.
    pub fn ratios(&self, seconds: &[f64], other: &[f64]) -> Series {
        Series::of_pairs(seconds, other, self.processes, |s, other| s / other)
    }

    /// One's time less another's.
    pub fn differences(&self, seconds: &[f64], other: &[f64]) -> Series {
        Series::of_pairs(seconds, other, self.processes, |s, other| s - other)
    }

    pub fn place(&self) -> String {
        match self.subject.as_str() {
            "" => self.scene.clone(),
            subject => format!("{}, {subject}", self.scene),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisRecord {
    pub axis: String,
    /// Definition of the error.
    pub metric: String,
    /// The oracle that decides which answer is right.
    pub reference: String,
    pub scenes: Vec<SceneOutcome>,
}

impl AxisRecord {
    /// The same for each subject by itself, which the axis is then named after; itself where it has
    /// none.
    pub fn by_subject(&self) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for scene in &self.scenes {
            let axis = match scene.subject.as_str() {
                "" => self.axis.clone(),
                subject => format!("{} ({subject})", self.axis),
            };
            match all.iter_mut().find(|of| of.axis == axis) {
                Some(of) => of.scenes.push(scene.clone()),
                None => all.push(Self { axis, scenes: vec![scene.clone()], ..self.clone() }),
            }
        }
        all
    }
}

#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AccuracyRecord {
    pub command_line: Vec<String>,
    pub tool: measurement::record::Tool,
    pub machine: measurement::record::Machine,
    pub compiler: measurement::record::Compiler,
    /// Seed of rays, aims, schedules and intervals.
    pub seed: u64,
    /// A first look only.
    pub quick: bool,
    /// Rounds of each variant, in each process.
    pub rounds: usize,
    /// Processes that timed them.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub processes: u32,
    /// Seconds of the whole run so far.
    pub took_s: f64,
    pub axes: Vec<AxisRecord>,
}

impl AccuracyRecord {
    /// Each axis on each of its scenes.
    pub fn scenes(&self) -> impl Iterator<Item = (&AxisRecord, &SceneOutcome)> {
        self.axes.iter().flat_map(|axis| axis.scenes.iter().map(move |scene| (axis, scene)))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ErrorOf {
    /// Answers, of which some are wrong.
    Counted { wrong: u64, trials: u64 },
    /// Root of the mean square of the differences to the reference's colours, a channel.
    Rmse { rmse: f64 },
}

impl ErrorOf {
    /// The number that is plotted: wrong answers in a million, or the difference itself.
    pub fn value(self) -> f64 {
        match self {
            Self::Counted { wrong, trials } => in_a_million(wrong, trials),
            Self::Rmse { rmse } => rmse,
        }
    }

    /// Upper bound of the error rate when none was found: 3 / trials, with 95% confidence.
    pub fn bound(self) -> Option<f64> {
        match self {
            Self::Counted { wrong: 0, trials } => Some(3e6 / trials.max(1) as f64),
            _ => None,
        }
    }
}

pub fn in_a_million(n: u64, of: u64) -> f64 {
    n as f64 / of.max(1) as f64 * 1e6
}

#[derive(Debug, Clone, Copy, Default)]
pub struct TrialCounts {
    wrong: u64,
    trials: u64,
}

impl TrialCounts {
    pub fn add(&mut self, is_wrong: bool) {
        self.trials += 1;
        self.wrong += u64::from(is_wrong);
    }

    pub fn add_counts(&mut self, other: Self) {
        self.trials += other.trials;
        self.wrong += other.wrong;
    }

    pub fn wrong(self) -> u64 {
        self.wrong
    }

    pub fn error(self) -> ErrorOf {
        ErrorOf::Counted { wrong: self.wrong, trials: self.trials }
    }
}

#[cfg(test)]
pub(crate) mod made_up {
    use super::*;

    /// A variant that takes so many seconds and is wrong so often in a million.
    pub fn row(variant: &str, seconds: f64, wrong: u64) -> VariantRecord {
        let error = ErrorOf::Counted { wrong, trials: 1_000_000 };
        VariantRecord {
            is_reference: wrong == 0,
            seconds: vec![seconds; 3],
            time_s: Estimate::exactly(seconds),
            ratio: Estimate::exactly(seconds / 2.0),
            standing: VariantStanding::OnFront,
            ..VariantRecord::new(variant.into(), String::new(), error)
        }
    }

    pub fn record(axes: Vec<AxisRecord>) -> AccuracyRecord {
        let run = measurement::record::made_up::run(&[]);
        AccuracyRecord {
            command_line: run.command_line,
            tool: run.tool,
            machine: run.machine,
            compiler: run.compiler,
            seed: 1,
            quick: false,
            rounds: 3,
            processes: 1,
            took_s: 1.0,
            axes,
        }
    }

    /// An axis of these variants on one scene.
    pub fn axis(rows: Vec<VariantRecord>) -> AxisRecord {
        let scene = SceneOutcome { scene: "kitchen".into(), rows, ..SceneOutcome::new("", "") };
        let [axis, metric, reference] = ["triangle-test", "misses", "exact"].map(str::to_owned);
        AxisRecord { axis, metric, reference, scenes: vec![scene] }
    }
}
