//! Why a scene could not be measured.

use accel_core::structure::BuildError;
use renderer::GeometryError;

use crate::scenes::LoadError;
use crate::system::panics::CaughtPanic;

/// Why a scene could not be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// It could not be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// Its geometry could not be made.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A structure could not be built where nothing can be done without it.
    #[error("scene {scene}: {source}")]
    Build { scene: String, source: BuildError },
    /// No structure could be built that gives the answers to compare with.
    #[error("scene {scene}: no structure could be built to compare answers with: {reasons}")]
    NoAnswers {
        scene: String,
        /// Reasons given by the candidates.
        reasons: String,
    },
    /// Threads could not be started.
    #[error("cannot start {threads} threads: {source}")]
    Threads { threads: usize, source: rayon::ThreadPoolBuildError },
    /// The program ended too often while it was prepared.
    #[error(
        "scene {scene}: skipped: {times} times the program died while its rays and their \
         answers were prepared (killed, or out of memory?); the next --resume retries it"
    )]
    Deadly { scene: String, times: usize },
    /// Something panicked while it was measured: a defect of ours.
    #[error("scene {scene}: {source}; this is a defect of rtbench")]
    Panicked { scene: String, source: CaughtPanic },
}
