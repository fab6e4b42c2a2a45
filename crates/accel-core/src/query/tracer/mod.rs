//! A built structure as an object: one dynamic call for a batch of rays, everything inside static.

use std::any::Any;

use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::memory::{Limits, OutOfMemory};
use crate::params::config::Settings;
use crate::primitives::Primitives;
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::WorkCounters;
use crate::query::kernel::ListBlocks;
use crate::query::sink::{ErasedSink, RelayedSink};
use crate::query::trace::TraversalTrace;
use crate::structure::{Batches, BuildError, Structure, StructureStats};
use crate::update::{Change, ChangedLists};

mod bound;
mod erased;
mod in_motion;
pub(crate) mod tested;

pub use bound::Bound;
pub use in_motion::BoundInMotion;

/// Behaviour of historical shadow rays; `results/published/README.md` explains the rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowRule {
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
    fn count_occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) -> WorkCounters;
    /// Traces historical shadow rays, counting the work.
    ///
    /// # Errors
    /// [`NoCells`] for tracers other than [`Bound`].
    fn count_historical(
        &self,
        _rays: &[Ray<S>],
        _rule: ShadowRule,
        _answers: &mut [ShadowCount],
    ) -> Result<WorkCounters, NoCells> {
        Err(NoCells::UNTOLD)
    }
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

/// What passes reach through one dynamic call a ray, so that they are compiled once for each kind
/// of primitive, not for each structure.
pub(crate) trait Traversals<S: Scalar> {
    /// The traversal of all passes that count.
    fn counted(&self, ray: &Ray<S>, sink: ErasedSink<'_, S>);
    /// The traversal of passes that are timed, for queries that are not compiled into it.
    fn relayed(&self, ray: &Ray<S>, sink: RelayedSink<'_, S>);
    /// The blocks of the lists that a ray may meet, where there are some.
    fn blocks(&self, ray: &Ray<S>) -> Option<&ListBlocks<S>>;
}

/// A structure, and the blocks of its lists where they were asked for and serve the set.
pub(crate) struct Parts<S, T> {
    pub(crate) structure: T,
    pub(crate) blocks: Option<ListBlocks<S>>,
}

impl<S: Scalar, T: Structure<S>> Parts<S, T> {
    pub(crate) fn build(
        over: &dyn Primitives<S>,
        settings: &Settings<T::Config>,
        has_blocks: bool,
    ) -> Result<Self, BuildError> {
        let parts = Self { structure: T::build(over, settings)?, blocks: None };
        Ok(if has_blocks { parts.with_blocks(over, settings.limits(), None)? } else { parts })
    }

    /// The same brought to the next frame, and whether it is not built anew.
    pub(crate) fn updated(
        mut self,
        over: &dyn Primitives<S>,
        settings: &Settings<T::Config>,
        has_blocks: bool,
        moved: &[u32],
    ) -> Result<(Self, bool), BuildError> {
        let change = self.structure.update(over, settings, moved)?;
        let is_updated = !matches!(change, Change::Rebuilt);
        let changed = if let Change::Lists(lists) = &change { Some(lists) } else { None };
        let parts = if has_blocks {
            self.with_blocks(over, settings.limits(), changed)?
        } else {
            Self { blocks: None, ..self }
        };
        Ok((parts, is_updated))
    }

    /// The same with the lists as [blocks](crate::query::kernel). Where there were blocks before,
    /// those of the lists that have `changed` alone are made anew.
    fn with_blocks(
        mut self,
        over: &dyn Primitives<S>,
        limits: Limits,
        changed: Option<&ChangedLists>,
    ) -> Result<Self, OutOfMemory> {
        let before = self.blocks.take();
        if T::HAS_LISTS {
            let mut lists = Vec::new();
            self.structure.lists(&mut |list| lists.push(list));
            limits.fits(ListBlocks::<S>::bytes_for(&lists))?;
            self.blocks = match before.zip(changed) {
                Some((blocks, changed)) => blocks.changed(over, &lists, changed),
                None => ListBlocks::of(over, &lists),
            };
        }
        Ok(self)
    }

    pub(crate) fn stats(&self) -> StructureStats {
        let stats = self.structure.stats();
        let blocks = self.blocks.as_ref().map_or(0, ListBlocks::bytes);
        StructureStats { bytes: stats.bytes + blocks, ..stats }
    }
}

impl<S: Scalar, T: Structure<S>> Traversals<S> for Parts<S, T> {
    #[inline(never)]
    fn counted(&self, ray: &Ray<S>, mut sink: ErasedSink<'_, S>) {
        self.structure.traverse(ray, &mut sink);
    }

    #[inline(never)]
    fn relayed(&self, ray: &Ray<S>, mut sink: RelayedSink<'_, S>) {
        self.structure.traverse(ray, &mut sink);
    }

    #[inline(always)]
    fn blocks(&self, _: &Ray<S>) -> Option<&ListBlocks<S>> {
        if T::HAS_LISTS { self.blocks.as_ref() } else { None }
    }
}

/// A structure apart from the primitives of its frame.
pub struct KeptStructure(Box<dyn Any + Send>);

pub struct PreviousFrame<'m> {
    pub kept: KeptStructure,
    /// Ids of the primitives that stand elsewhere now or have another shape, ascending. All others
    /// are the same.
    pub moved: &'m [u32],
}

impl KeptStructure {
    /// Keeps what was built over so many primitives.
    pub(crate) fn new<S: Scalar, T: Structure<S>>(parts: Parts<S, T>, primitives: usize) -> Self {
        Self(Box::new((parts, primitives)))
    }
}

impl<'m> PreviousFrame<'m> {
    /// The structure, if it is a `T` over so many primitives.
    pub(crate) fn parts<S: Scalar, T: Structure<S>>(
        self,
        primitives: usize,
    ) -> Option<(Parts<S, T>, &'m [u32])> {
        let kept = self.kept.0.downcast::<(Parts<S, T>, usize)>().ok()?;
        (kept.1 == primitives).then_some((kept.0, self.moved))
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
