//! Segments of time: structures over what moves, each over the way within its part of the exposure.
//!
//! Paper: A. Glassner, "Spacetime Ray Tracing for Animation", IEEE CG&A 8(2), 1988. Deviations: he
//! divides space and time in turns, as need be; we divide time alone, first, into equal parts. A
//! ray has one time and so goes to one structure; nothing else changes, and neither do answers.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::config::Settings;
use crate::params::{ParamSpec, Params};
use crate::primitives::{MixedSet, Primitives};
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::kernel::ListBlocks;
use crate::query::sink::{ErasedSink, RelayedSink, Sink};
use crate::query::tracer::tested::TestChoice;
use crate::query::tracer::{Parts, Traversals};
use crate::structure::{BuildError, Structure, StructureStats, traverse_by_blocks};

/// The setting, which every structure has.
pub const PARAM: ParamSpec = ParamSpec::integer("time-segments", "1", 1, 8).about(
    "equal parts of the time the shutter is open, each with a structure of its own over what moves \
     in it; a scene at rest has one",
);

/// Number of segments in the settings.
pub(crate) fn of(params: &Params) -> usize {
    params.get(PARAM.name).map_or(1, |_| params.integer(PARAM.name) as usize)
}

/// The structures of all segments.
pub struct TimeSegments<'a, S: Scalar, T> {
    set: &'a MixedSet<S>,
    segments: Vec<Parts<S, T>>,
}

impl<'a, S: Scalar, T: Structure<S>> TimeSegments<'a, S, T> {
    /// Builds as many structures as the settings say.
    ///
    /// # Errors
    /// [`BuildError`] of the first that cannot be built.
    pub(crate) fn build(
        set: &'a MixedSet<S>,
        settings: &Settings<T::Config>,
        testing: &TestChoice,
        n: usize,
    ) -> Result<Self, BuildError> {
        if n == 1 {
            let all = Parts::build(set, settings, testing.has_blocks)?;
            return Ok(Self { set, segments: vec![all] });
        }
        // a copy of the set, whose bounds are those of a segment while its structure is built
        settings.fits(set.bytes() as u128)?;
        let (mut part, mut left) = (set.clone(), settings.clone());
        let mut narrowed = |k| {
            part.narrow_to(k, n);
            let segment = Parts::<S, T>::build(&part, &left, testing.has_blocks)?;
            let memory = left.limits().memory.beside(segment.stats().bytes);
            left = left.clone().within(memory);
            Ok(segment)
        };
        Ok(Self { set, segments: (0..n).map(&mut narrowed).collect::<Result<_, BuildError>>()? })
    }

    #[inline(always)]
    fn at(&self, ray: &Ray<S>) -> &Parts<S, T> {
        match &self.segments[..] {
            [all] => all,
            several => &several[self.set.motion().segment(ray.time, several.len())],
        }
    }

    /// The query after its traversal, which is compiled for it.
    #[inline(always)]
    pub(crate) fn traversed<K: Sink<S>>(&self, ray: &Ray<S>, mut query: K) -> K {
        let Parts { structure, blocks } = self.at(ray);
        match blocks {
            Some(blocks) if T::HAS_LISTS => traverse_by_blocks(structure, blocks, ray, &mut query),
            _ => structure.traverse(ray, &mut query),
        }
        query
    }

    /// The sum of all; the resolution is that of the first.
    pub(crate) fn stats(&self) -> StructureStats {
        let shapes = self.segments.iter().map(Parts::stats);
        shapes.reduce(with).unwrap_or_default()
    }

    /// The cells of each segment, one after the other.
    pub(crate) fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.segments.iter().try_for_each(|segment| segment.structure.cells(each))
    }
}

impl<S: Scalar, T: Structure<S>> Traversals<S> for TimeSegments<'_, S, T> {
    fn counted(&self, ray: &Ray<S>, sink: ErasedSink<'_, S>) {
        self.at(ray).counted(ray, sink);
    }

    fn relayed(&self, ray: &Ray<S>, sink: RelayedSink<'_, S>) {
        self.at(ray).relayed(ray, sink);
    }

    #[inline(always)]
    fn blocks(&self, ray: &Ray<S>) -> Option<&ListBlocks<S>> {
        self.at(ray).blocks(ray)
    }
}

fn with(a: StructureStats, b: StructureStats) -> StructureStats {
    StructureStats {
        inner_cells: a.inner_cells + b.inner_cells,
        cells: a.cells + b.cells,
        empty_cells: a.empty_cells + b.empty_cells,
        references: a.references + b.references,
        resolution: a.resolution,
        bytes: a.bytes + b.bytes,
        pending_cells: a.pending_cells.map(|n| n + b.pending_cells.unwrap_or(0)),
    }
}
