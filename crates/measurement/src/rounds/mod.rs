//! Timing: rounds in seeded random order over the rows of a scene.

pub mod interleaved;
#[allow(clippy::indexing_slicing)]
pub mod measure;
pub mod scene_run;
pub mod scope;
pub mod trial;

use accel_core::structure::BuildError;
use renderer::GeometryError;

use crate::scenes::LoadError;
use crate::system::panics::CaughtPanic;

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error("scene {scene}: {source}")]
    Build { scene: String, source: BuildError },
    #[error("scene {scene}: no structure could be built to compare answers with: {reasons}")]
    NoAnswers { scene: String, reasons: String },
    #[error("cannot start {threads} threads: {source}")]
    Threads { threads: usize, source: rayon::ThreadPoolBuildError },
    #[error(
        "scene {scene}: skipped: {times} times the program died while its rays and their \
         answers were prepared (killed, or out of memory?); the next --resume retries it"
    )]
    Deadly { scene: String, times: usize },
    #[error("scene {scene}: {source}; this is a defect of rtbench")]
    Panicked { scene: String, source: CaughtPanic },
}

impl MeasureError {
    /// What could not be built over the scene of that name.
    pub fn of_build(scene: &str) -> impl Fn(BuildError) -> Self + Copy {
        move |source| Self::Build { scene: scene.to_owned(), source }
    }
}
