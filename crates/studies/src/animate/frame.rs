//! A frame, ready to be measured: its primitives, and what of them moved.

use accel_core::registry::Buildable;
use renderer::Geometry;
use scene_loading::Scene;

use crate::error::StudyError;

pub struct Frame<S: Buildable> {
    pub number: u32,
    /// The scene at rest.
    pub scene: Scene,
    /// What structures are over.
    pub geometry: Geometry<S>,
    /// What the oracle is over.
    pub exact: Geometry<f64>,
    /// Ids of the primitives that are others than in the frame before, ascending; none in the
    /// first, and where there are not the same primitives in both.
    pub moved: Option<Vec<u32>>,
}

impl<S: Buildable> Frame<S> {
    /// Of a scene. `first` and `before` are the primitives of the first frame measured and of the
    /// one before.
    ///
    /// # Errors
    /// [`StudyError`] for primitives that cannot be used.
    pub fn new(
        number: u32,
        scene: Scene,
        first: Option<&Geometry<S>>,
        before: Option<&Geometry<S>>,
    ) -> Result<Self, StudyError> {
        let exact = Geometry::<f64>::of(&scene)?;
        let mut geometry = Geometry::<S>::of(&scene)?;
        if let Some(first) = first {
            geometry.keep_rigid(first);
        }
        let moved = before.and_then(|before| geometry.moved_since(before));
        Ok(Self { number, scene, geometry, exact, moved })
    }
}
