//! An axis of accuracy: what varies on it, and how its variants are measured; with all that the axes
//! are written with.

use crate::accuracy::stage::PreparedScene;

pub(super) use crate::accuracy::record::{ErrorOf, SceneOutcome, TrialCounts, in_a_million};
pub(super) use crate::accuracy::stage::{
    Batches, Replay, Stage, TRACER, build_columns, compare, count, counted, diagonal, mebibytes,
    widened,
};
pub(super) use crate::accuracy::timing::{Variant, timed, timed_settings};
pub(super) use crate::error::StudyError;

/// One way to be more or less accurate.
#[derive(Debug)]
pub struct Axis {
    pub name: &'static str,
    /// The varied quantity, in one line.
    pub summary: &'static str,
    /// Source of the variants.
    pub paper: &'static str,
    /// Definition of the error, with its unit.
    pub metric: &'static str,
    /// The oracle that decides which answer is right.
    pub reference: &'static str,
    /// Scenes where none are named: two of SPD and a modelled one.
    pub scenes: &'static [&'static str],
    /// The setting of the product that varies.
    pub setting: &'static str,
    pub measure: Measure,
}

#[derive(Debug, Clone, Copy)]
pub enum Measure {
    Whole(fn(&Stage<'_>) -> Result<SceneOutcome, StudyError>),
    /// Subject by subject, each with variants, ratios and a front of its own: structures with
    /// settings, as `run -s` takes them.
    Each {
        subjects: &'static [&'static str],
        /// True if one tells more of a scene than others do.
        serves: fn(&PreparedScene, &str) -> bool,
        measure: fn(&Stage<'_>, &str) -> Result<SceneOutcome, StudyError>,
    },
}

impl Measure {
    /// The subjects for a scene; an empty name where there is no choice of them.
    pub fn subjects(self, prepared: &PreparedScene) -> Vec<&'static str> {
        match self {
            Self::Whole(_) => vec![""],
            Self::Each { subjects, serves, .. } => {
                subjects.iter().copied().filter(|subject| serves(prepared, subject)).collect()
            }
        }
    }

    pub fn outcome(self, stage: &Stage<'_>, subject: &str) -> Result<SceneOutcome, StudyError> {
        match self {
            Self::Whole(measure) => measure(stage),
            Self::Each { measure, .. } => {
                Ok(SceneOutcome { subject: subject.replace(':', " "), ..measure(stage, subject)? })
            }
        }
    }
}
