//! Why a study ended early.

use std::path::PathBuf;

use measurement::plan::error::PlanError;
use measurement::rounds::MeasureError;
use renderer::{GeometryError, ImageError};

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error(transparent)]
    Measure(Box<MeasureError>),
    /// A scene has nothing that an axis of accuracy is about.
    #[error("{axis}: scene {scene} is not suitable: {reason}")]
    UnfitScene { axis: &'static str, scene: String, reason: &'static str },
    /// Process number `process`, from 1, measured something else than what was judged.
    #[error(
        "{axis} on {place}: process {process} measured {found}, which differs from what was judged"
    )]
    Unlike { axis: String, place: String, process: u32, found: String },
    #[error(transparent)]
    Image(#[from] UnsavedImage),
}

#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct UnsavedImage {
    pub path: PathBuf,
    pub source: ImageError,
}

impl From<MeasureError> for StudyError {
    fn from(error: MeasureError) -> Self {
        Self::Measure(Box::new(error))
    }
}

impl From<GeometryError> for StudyError {
    fn from(error: GeometryError) -> Self {
        MeasureError::from(error).into()
    }
}
