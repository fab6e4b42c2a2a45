//! Segments of time: structures over what moves, each over the way within its part of the exposure.
//!
//! Paper: A. Glassner, "Spacetime Ray Tracing for Animation", IEEE CG&A 8(2), 1988. Deviations: he
//! divides space and time in turns, as need be; we divide time alone, first, into equal parts. A
//! ray has one time and so goes to one structure; nothing else changes, and neither do answers.

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::config::Settings;
use crate::params::{ParamSpec, Params};
use crate::primitives::{MixedSet, PrimSet};
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::kernel::ListBlocks;
use crate::query::sink::{ErasedSink, RelayedSink, Sink};
use crate::query::tracer::tested::TestChoice;
use crate::query::tracer::{traverse_counted, traverse_relayed};
use crate::structure::{BuildError, Structure, StructureStats, blocks_of, traverse_by_blocks};

/// The setting, which every structure has.
pub const PARAM: ParamSpec = ParamSpec::integer("time-segments", "1", 1, 8).about(
    "equal parts of the time the shutter is open, each with a structure of its own over what moves \
     in it; a scene at rest has one",
);

/// Number of segments in the settings.
pub(crate) fn of(params: &Params) -> usize {
    params.get(PARAM.name).map_or(1, |_| params.integer(PARAM.name) as usize)
}

/// A structure, with its lists as blocks where that is asked for.
struct Segment<S, T> {
    structure: T,
    blocks: Option<ListBlocks<S>>,
}

impl<S: Scalar, T: Structure<S>> Segment<S, T> {
    fn build(
        part: &MixedSet<S>,
        settings: &Settings<T::Config>,
        testing: &TestChoice,
    ) -> Result<Self, BuildError> {
        let structure = T::build(part, settings)?;
        let blocks =
            if testing.has_blocks { blocks_of(part, &structure, settings.limits())? } else { None };
        Ok(Self { structure, blocks })
    }

    fn stats(&self) -> StructureStats {
        let stats = self.structure.stats();
        let blocks = self.blocks.as_ref().map_or(0, ListBlocks::bytes);
        StructureStats { bytes: stats.bytes + blocks, ..stats }
    }
}

/// The structures of all segments.
pub struct TimeSegments<'a, S: Scalar, T> {
    set: &'a MixedSet<S>,
    segments: Vec<Segment<S, T>>,
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
            return Ok(Self { set, segments: vec![Segment::build(set, settings, testing)?] });
        }
        // a copy of the set, whose bounds are those of a segment while its structure is built
        settings.fits(set.bytes() as u128)?;
        let (mut part, mut left) = (set.clone(), settings.clone());
        let mut narrowed = |k| {
            part.narrow_to(k, n);
            let segment = Segment::<S, T>::build(&part, &left, testing)?;
            let memory = left.limits().memory.beside(segment.stats().bytes);
            left = left.clone().within(memory);
            Ok(segment)
        };
        Ok(Self { set, segments: (0..n).map(&mut narrowed).collect::<Result<_, BuildError>>()? })
    }

    #[inline(always)]
    fn at(&self, ray: &Ray<S>) -> &Segment<S, T> {
        match &self.segments[..] {
            [all] => all,
            several => &several[self.set.motion().segment(ray.time, several.len())],
        }
    }

    /// The blocks of the lists that a ray may meet.
    #[inline(always)]
    pub(crate) fn blocks(&self, ray: &Ray<S>) -> Option<&ListBlocks<S>> {
        if T::HAS_LISTS { self.at(ray).blocks.as_ref() } else { None }
    }

    /// The query after its traversal, which is compiled for it.
    #[inline(always)]
    pub(crate) fn traversed<K: Sink<S>>(&self, ray: &Ray<S>, mut query: K) -> K {
        let Segment { structure, blocks } = self.at(ray);
        match blocks {
            Some(blocks) if T::HAS_LISTS => traverse_by_blocks(structure, blocks, ray, &mut query),
            _ => structure.traverse(ray, &mut query),
        }
        query
    }

    /// The traversal of all passes that count.
    pub(crate) fn counted_traversal(&self, ray: &Ray<S>, sink: ErasedSink<'_, S>) {
        traverse_counted(&self.at(ray).structure, ray, sink);
    }

    /// The traversal of all passes that are timed, where it is compiled once for all queries.
    pub(crate) fn timed_traversal(&self, ray: &Ray<S>, sink: RelayedSink<'_, S>) {
        traverse_relayed(&self.at(ray).structure, ray, sink);
    }

    /// The sum of all; the resolution is that of the first.
    pub(crate) fn stats(&self) -> StructureStats {
        let shapes = self.segments.iter().map(Segment::stats);
        shapes.reduce(with).unwrap_or_default()
    }

    /// The cells of each segment, one after the other.
    pub(crate) fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        self.segments.iter().try_for_each(|segment| segment.structure.cells(each))
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
