//! Errors that end a command, with exit codes.

use std::io;
use std::path::PathBuf;

use accel_core::query::cells::NoCells;
use renderer::GeometryError;

use crate::baselines::BaselineError;
use crate::comparison::CompareError;
use crate::comparison::pairing::{MissingRow, in_words};
use crate::gate::against::AgainstError;
use crate::history::HistoryError;
use crate::outputs::OutputError;
use crate::replan::ReplanError;
use crate::report::ReportError;
use measurement::callgrind::CallgrindError;
use measurement::journal::JournalError;
use measurement::plan::error::PlanError;
use measurement::rays::text::RayTextError;
use measurement::record::file::RecordError;
use measurement::record::merge::MergeError;
use measurement::rounds::MeasureError;
use measurement::scenes::LoadError;
use measurement::system::child_process::{ChildError, CopyError};
use measurement::system::files::WriteError;
use plugins::PluginError;
use plugins::files::FileError;
use presentation::drawing::ImageError;
use presentation::json::FormatError;
use studies::error::{StudyError, UnsavedImage};
use studies::reproduce::ReproduceError;

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error(transparent)]
    Plugin(#[from] PluginError),
    #[error(
        "scene {scene}: has other primitives than static triangles; scenes named ...-tess are tessellated"
    )]
    NotOfTriangles { scene: String },
    #[error(transparent)]
    Study(Box<StudyError>),
    #[error(transparent)]
    Outputs(#[from] OutputError),
    #[error("the images of {scenes} were too fast to predict from")]
    NoModel { scenes: String },
    #[error("cannot watch for signals: {0}")]
    Signals(io::Error),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error(transparent)]
    Replan(Box<ReplanError>),
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    #[error("this cannot be compared with the baseline: {}", .0.join("; "))]
    NotComparable(Vec<String>),
    #[error("nothing was compared: no row is in both; {}", in_words(.0).join("; "))]
    NothingCompared(Vec<MissingRow>),
    #[error(
        "the baseline has no instruction counts; save one that has them: `rtbench baseline save \
         NAME --instructions ...`"
    )]
    NoCounts,
    #[error("structure {row}: {source}")]
    NoCells { row: String, source: NoCells },
    #[error("cannot draw {}: {source}", path.display())]
    Undrawn { path: PathBuf, source: ImageError },
    #[error("cannot write to standard output: {0}")]
    Output(#[from] io::Error),
    /// An error of a subsystem that nobody distinguishes from others.
    #[error(transparent)]
    Other(Box<dyn std::error::Error + Send + Sync>),
}

macro_rules! other {
    ($($error:ty),+ $(,)?) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::Other(Box::new(error))
            }
        }
    )+};
}

other! {
    FileError, RayTextError, WriteError, FormatError, JournalError,
    RecordError, MergeError, ReportError, HistoryError, CopyError, ReproduceError,
    CallgrindError, ChildError, AgainstError, UnsavedImage,
}

impl From<MeasureError> for Error {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Load(error) => Self::Load(error),
            other => Self::Other(Box::new(other)),
        }
    }
}

impl From<GeometryError> for Error {
    fn from(error: GeometryError) -> Self {
        MeasureError::from(error).into()
    }
}

impl From<StudyError> for Error {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Plan(error) => Self::Plan(error),
            StudyError::Measure(error) => (*error).into(),
            other => Self::Study(Box::new(other)),
        }
    }
}

impl From<ReplanError> for Error {
    fn from(error: ReplanError) -> Self {
        match error {
            ReplanError::Plan(error) => Self::Plan(error),
            other => Self::Replan(Box::new(other)),
        }
    }
}

impl Error {
    pub fn exit_code(&self) -> u8 {
        use CompareError::{Filter, Match, NothingMatches};
        use OutputError::{IsRead, NothingSelected, SameFile, StandardOutput};
        match self {
            Self::Plan(PlanError::Scene(e)) | Self::Load(e) => {
                use LoadError::{NoSizes, Procedural, UnknownScene};
                let is_usage =
                    matches!(e, UnknownScene { .. } | Procedural { .. } | NoSizes { .. });
                if is_usage { USAGE } else { FAILURE }
            }
            Self::Compare(Filter { .. } | Match { .. } | NothingMatches { .. }) => USAGE,
            Self::Replan(error) if matches!(**error, ReplanError::Unknown { .. }) => USAGE,
            Self::Baseline(error) if error.is_usage() => USAGE,
            Self::NothingCompared(_) => NOTHING_COMPARED,
            Self::Plan(_) => USAGE,
            Self::Plugin(PluginError::NameTaken { .. } | PluginError::NoProcesses { .. }) => USAGE,
            Self::Outputs(SameFile(_) | IsRead(_) | NothingSelected(..) | StandardOutput) => USAGE,
            _ => FAILURE,
        }
    }

    /// The reader of our output went away, as `head` does: nothing to report, unless a run was
    /// not finished.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Output(e) if e.kind() == io::ErrorKind::BrokenPipe)
    }
}

pub const SUCCESS: u8 = 0;
pub const FAILURE: u8 = 1;
/// The command line makes no sense.
pub const USAGE: u8 = 2;
/// Something got worse than a baseline.
pub const REGRESSION: u8 = 3;
pub const WRONG_HITS: u8 = 4;
/// Something was inconclusive, or a row was missing, and `--strict` was given; or `verify` ran out
/// of time before it had asked everything.
pub const INCONCLUSIVE: u8 = 5;
/// No row was in both, or none that `check` asks about was built.
pub const NOTHING_COMPARED: u8 = 6;
/// SIGINT (Ctrl-C) ended the run; other signals as shells count them, 128 and their number.
pub const INTERRUPTED: u8 = 130;
