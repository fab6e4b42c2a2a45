//! A built structure as an object: one dynamic call for a batch of rays, everything inside static.

use std::any::Any;

use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::WorkCounters;
use crate::query::kernel::ListBlocks;
use crate::query::sink::{ErasedSink, RelayedSink};
use crate::query::trace::TraversalTrace;
use crate::structure::{Batches, Structure, StructureStats};

mod bound;
mod counting;
mod in_motion;
pub(crate) mod nearby;
pub(crate) mod tested;
mod timing;

pub use bound::Bound;
pub use in_motion::BoundInMotion;

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
    fn trace(&self, _ray: &Ray<S>) -> Result<TraversalTrace<S>, NoCells> {
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

/// The traversal of all passes that count.
#[inline(never)]
pub(crate) fn traverse_counted<S: Scalar, T: Structure<S>>(
    structure: &T,
    ray: &Ray<S>,
    mut sink: ErasedSink<'_, S>,
) {
    structure.traverse(ray, &mut sink);
}

/// The traversal of passes that are timed, for queries that are not compiled into it.
#[inline(never)]
pub(crate) fn traverse_relayed<S: Scalar, T: Structure<S>>(
    structure: &T,
    ray: &Ray<S>,
    mut sink: RelayedSink<'_, S>,
) {
    structure.traverse(ray, &mut sink);
}

/// A structure apart from the primitives of its frame.
pub struct KeptStructure(Box<dyn Any + Send>);

pub struct PreviousFrame<'m> {
    pub kept: KeptStructure,
    /// Ids of the primitives that stand elsewhere now or have another shape, ascending. All others
    /// are the same.
    pub moved: &'m [u32],
}

/// A structure and the blocks of its lists.
pub(crate) struct Parts<S, T> {
    pub(crate) structure: T,
    pub(crate) blocks: Option<ListBlocks<S>>,
    pub(crate) primitives: usize,
}

impl KeptStructure {
    pub(crate) fn new<S: Scalar, T: Structure<S>>(parts: Parts<S, T>) -> Self {
        Self(Box::new(parts))
    }
}

impl<'m> PreviousFrame<'m> {
    /// The structure, if it is a `T`.
    pub(crate) fn parts<S: Scalar, T: Structure<S>>(self) -> Option<(Parts<S, T>, &'m [u32])> {
        let parts = self.kept.0.downcast::<Parts<S, T>>().ok()?;
        Some((*parts, self.moved))
    }
}

/// A structure that comes out of a file, and may answer in a process of its own. Its calls are
/// timed where they are made, so that no way there and back is counted.
///
/// A batch is answered in one call, whatever the number of threads: it divides rays among its own.
pub trait Foreign: Sync {
    /// The origin of the structure.
    fn origin(&self) -> &Origin;
    /// Seconds of the call that built it.
    fn build_seconds(&self) -> f64;
    /// Seconds of the calls that answered rays since this was asked last.
    fn take_seconds(&self) -> f64;
    /// Share of the time of all ray queries spent by threads other than the caller; 0 if unknown.
    fn share_of_other_threads(&self) -> f64;
    /// Remark of its own for the notes of its row, in one line.
    fn note(&self) -> Option<String>;
    /// Why nothing that it answers counts: how its process ended.
    fn failure(&self) -> Option<String>;
    /// Returns whether it counts its work.
    fn has_counters(&self) -> bool;
    /// Returns whether it has several rays of a batch in flight.
    fn answers_batches(&self) -> bool;
}

/// Origin of a foreign structure, and how it is queried.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    /// Name of the file, without folders.
    pub file: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Its version, as it says.
    pub version: String,
    /// Its own triangle test decides: answers differ from those of the set at edges.
    pub has_own_test: bool,
    /// It answers in a process of its own.
    pub own_process: bool,
    /// Seconds of a call that asks for nothing, there and back; not part of any time.
    pub empty_call_s: f64,
}
