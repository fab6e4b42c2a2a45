//! What a run says of the questions that it is made for: which row is the fastest, which the
//! smallest.

use serde::{Deserialize, Serialize};

use crate::record::query::Query;
use statistics::estimate::Estimate;

/// What a run is asked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Question {
    /// Least time for the build, one million primary rays and their shadow rays, seconds.
    FirstImage,
    /// Least time for a ray of a kind and order, seconds.
    Trace(String),
    /// Fewest bytes of what was built; no interval, as nothing of it is measured.
    Memory,
}

/// The row that answers a question best, and how it stands against the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Conclusion {
    pub question: Question,
    /// Of which rows: those that answer ray by ray, or those that answer batches as well.
    pub query: Query,
    /// The row with the least median.
    pub row: String,
    /// Its figure in the unit of the question; over several scenes the geometric mean.
    pub figure: Estimate,
    /// Rows that are not significantly different from it.
    pub not_different: Vec<String>,
    /// The nearest row that is significantly different; none where there is none.
    pub next: Option<NextRow>,
    /// Rows that do not lead, since answers may be wrong by a known defect, and are closer than the
    /// next row, as fast or faster; the fastest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub defective: Vec<Defective>,
}

/// A row with a known defect beside the best one without.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct Defective {
    /// Structure and settings.
    pub row: String,
    /// How many times as much as the best row it takes, paired by round.
    pub times: Estimate,
    /// Answers that were wrong.
    pub wrong: u64,
    /// Answers that were compared.
    pub rays: u64,
}

/// The nearest row that is significantly different from the best one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "testing", schemars(rename = "Next"))]
pub struct NextRow {
    /// Structure and settings.
    pub row: String,
    /// How many times as much it takes, paired by round.
    pub times: Estimate,
}

/// The row of least time, build included, from some number of rays on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct LeastTime {
    /// Structure and settings.
    pub row: String,
    /// Rays from which on it takes the least time; the first row does from 0 on.
    pub from_rays: f64,
    /// The lower end of the 95% interval of that number.
    pub low: f64,
    /// Its upper end; none where some resamples never reach it.
    pub high: Option<f64>,
}
