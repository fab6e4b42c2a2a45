//! A built structure as an object: one dynamic call for a batch of rays, everything inside static.

mod bound;
pub(crate) mod compiled_once;
mod counting;
mod foreign;
mod in_motion;
mod kept;
pub(crate) mod nearby;
pub(crate) mod tested;
mod timing;

pub use bound::Bound;
pub use foreign::{Foreign, Origin};
pub use in_motion::BoundInMotion;
pub use kept::{KeptStructure, PreviousFrame};

use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::WorkCounters;
use crate::query::trace::TraversalTrace;
use crate::structure::{Batches, StructureStats};

/// Behaviour of shadow rays when counting; `results/published/README.md` explains the historical
/// rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowRule {
    /// Stops at the first opaque hit; transmissive primitives are ignored.
    OpaqueBlocks,
    /// As Havran and Sixta counted: glass that was hit is remembered and not tested again.
    Historical,
    /// As Havran and Sixta counted in the recursive grid: whatever is hit stops the ray, at once
    /// if the hit lies in the current cell.
    HistoricalInCell,
}

/// Answers of one historical shadow ray.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ShadowCount {
    /// An opaque primitive is in the way.
    pub blocked: bool,
    /// Distinct transmissive primitives hit before the traversal ended.
    pub glass: u32,
}

/// A structure with the primitives it was built over.
///
/// Output slices must be as long as `rays`; longer inputs are cut to the shorter of both.
#[warn(missing_docs)]
pub trait Tracer<S: Scalar>: Send + Sync {
    /// The closest hit of every ray.
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]);
    /// Writes for each ray whether an opaque primitive blocks it.
    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]);
    /// [`Tracer::closest_hits`], counting the work.
    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters;
    /// [`Tracer::occlusions`], counting the work.
    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters;
    /// Statistics of the built structure.
    fn stats(&self) -> StructureStats;
    /// The structure's cells: [`crate::structure::Structure::cells`].
    ///
    /// # Errors
    /// [`NoCells`].
    fn cells(&self, _each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        Err(NoCells::UNTOLD)
    }
    /// [`Tracer::count_closest_hits`] of one ray, step by step.
    ///
    /// # Errors
    /// [`NoCells`] for tracers that are not traversed with a sink.
    fn way(&self, _ray: &Ray<S>) -> Result<TraversalTrace<S>, NoCells> {
        Err(NoCells::UNTOLD)
    }
    /// The structure alone, to be taken to the next frame; none where there is nothing but to build
    /// anew.
    fn released(self: Box<Self>) -> Option<KeptStructure> {
        None
    }
    /// Returns whether it was taken from the frame before, and not built.
    fn is_updated(&self) -> bool {
        false
    }
    /// How a batch is answered while nothing is counted. A library's own primitive test differs
    /// from that of the set by its rounding, and by its defects.
    fn batches(&self) -> Batches {
        Batches::RayByRay
    }
    /// The interface of foreign code; `None` if the code is compiled into this program.
    fn foreign(&self) -> Option<&dyn Foreign> {
        None
    }
    /// The types of the primitives and of the structure that its traversals are compiled for, as
    /// the compiler names them: tracers of the same name run the same instructions.
    fn code(&self) -> &'static str {
        std::any::type_name::<Self>()
    }
}
