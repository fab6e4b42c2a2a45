//! The trait of structures, their registry lines, build statistics and build errors.

#![warn(missing_docs)]

use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::historical::bounds_rule::{BoundsOf, BoundsRule};
use crate::memory::{CountedItem, Limits, OutOfMemory};
use crate::params::config::{Config, Settings};
use crate::params::{ParamError, ParamSpec, Params};
use crate::primitives::{PrimSet, Primitives};
use crate::query::cells::{CellVisitor, NoCells};
use crate::query::counters::Counters;
use crate::query::kernel::{BlockSink, ListBlocks};
use crate::query::sink::Sink;
use crate::update::Change;

pub use crate::query::sink::{BatchAnswers, RayBatch};

/// An acceleration structure over primitive ids. `peers/rust-template/src/median_bvh.rs` is a small
/// one in a crate of its own.
pub trait Structure<S: Scalar>: Sized + Send + Sync + 'static {
    /// True if a traversal may push an id more than once. Without duplicates a mailbox is of no
    /// use, and none is compiled.
    const DUPLICATES: bool = true;

    /// Whether [`Structure::lists`] has lists, and [`PARAM`](crate::query::kernel::PARAM) is among
    /// its parameters.
    const HAS_LISTS: bool = false;

    /// True if its loop over single rays is compiled for AVX-512 too, where the set is of
    /// triangles: see [`batch`](crate::query::batch). For what takes eight boxes or triangles at
    /// once, and where it pays.
    const HAS_AVX512: bool = false;

    /// Its settings, which are read before anything is built: `()` where it has none.
    type Config: Config;

    /// Builds the structure over all primitives of the set.
    ///
    /// # Errors
    /// [`BuildError`] when the set or the settings cannot be served; never a panic.
    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
    ) -> Result<Self, BuildError>;

    /// Takes the structure to the next frame: to what [`Structure::build`] would make of these
    /// primitives, or what answers for them as well. They are those that it was made for, under the
    /// same ids, as many, but for what `moved` names (ascending). What it cannot do it builds anew,
    /// which is all it does where this is not written.
    ///
    /// # Errors
    /// As [`Structure::build`]; the structure is of no use then.
    fn update(
        &mut self,
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
        _moved: &[u32],
    ) -> Result<Change, BuildError> {
        *self = Self::build(prims, settings)?;
        Ok(Change::Rebuilt)
    }

    /// Pushes every primitive that the ray may hit within the sink's interval, in any order, and
    /// may stop as soon as the rest lies beyond `sink.t_max()`. The ray is traceable
    /// ([`Ray::is_traceable`]).
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K);

    /// Calls `each` with the lists that [`Structure::traverse`] hands to its sink, whole ones, each
    /// once; of one array. Lists that it leaves out are tested primitive by primitive.
    fn lists<'a>(&'a self, _each: &mut dyn FnMut(&'a [u32])) {}

    /// How a batch of rays is answered, where the lists are [blocks](crate::query::kernel) or as
    /// [`Structure::lists`] has them.
    #[inline(always)]
    fn batches<P: PrimSet<S>>(&self, _prims: &P, _blocks: Option<&ListBlocks<S>>) -> Batches {
        Batches::RayByRay
    }

    /// Answers the rays of a batch, where [`Structure::batches`] says that they are not traversed
    /// ray by ray. What it counts is asked for with [`Batches::Packets`] alone; elsewhere each
    /// ray has the steps of [`Structure::traverse`], which are counted.
    #[inline(always)]
    fn answer_batch<P: PrimSet<S>, C: Counters>(
        &self,
        _prims: &P,
        _blocks: Option<&ListBlocks<S>>,
        _batch: RayBatch<'_, S>,
    ) -> C {
        C::default()
    }

    /// Statistics of the built structure; a pass over it, not part of the build time.
    fn stats(&self) -> StructureStats;

    /// Calls `each` with every cell: as many of each kind, and as many references, as
    /// [`Structure::stats`] counts.
    ///
    /// # Errors
    /// [`NoCells`].
    fn cells(&self, _each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        Err(NoCells::UNTOLD)
    }
}

/// How a structure answers a batch of rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Batches {
    /// Each is traversed ([`Structure::traverse`]) to its end before the next one begins.
    RayByRay,
    /// Several go side by side, or are prepared at once, with the answers of
    /// [`Structure::traverse`].
    Together,
    /// The same, and those that run alike share steps, which count once: see
    /// [`Structure::answer_batch`].
    Packets,
    /// With the triangles, the test and the traversal of the library that the structure is of, and
    /// nothing else. The answers are the library's own: see [`StructureInfo::known_defect`].
    Library,
}

impl Batches {
    /// Returns whether several rays are answered at a time, with the answers of
    /// [`Structure::traverse`].
    #[inline(always)]
    pub fn are_together(self) -> bool {
        matches!(self, Self::Together | Self::Packets)
    }
}

/// Statistics of a structure, in the symbols of Havran and Sixta (1999).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StructureStats {
    /// N_IN: hierarchical cells (inner nodes).
    pub inner_cells: u64,
    /// N_V: elementary cells (voxels, leaves).
    pub cells: u64,
    /// N_EV: elementary cells without primitives.
    pub empty_cells: u64,
    /// N_OIV: primitive references in elementary cells.
    pub references: u64,
    /// Voxels per axis, for structures that have one resolution.
    pub resolution: Option<[u32; 3]>,
    /// Bytes of the structure itself, without the primitives.
    pub bytes: u64,
    /// Structures that build on demand: cells no ray has asked to divide yet. They count as
    /// elementary cells until then.
    pub pending_cells: Option<u64>,
}

/// Why a structure could not be built.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the message of a variant says what its fields are")]
pub enum BuildError {
    /// There is nothing to build over.
    #[error("{structure}: the scene has no primitives")]
    NoPrimitives { structure: &'static str },
    /// The scene's box is too large for the scalar.
    #[error("{structure}: the scene is too large for this precision (see primitive {id})")]
    NonFiniteBounds {
        structure: &'static str,
        /// The first of the farthest primitives.
        id: u32,
    },
    /// The scene's coordinates are all too small, or the largest too large, for the products of
    /// primitive tests.
    #[error(
        "{structure}: the scene's largest coordinate is about 2^{exponent}; {precision} serves \
         2^{} to 2^{}: scale the scene", .served[0], .served[1]
    )]
    OutOfScale {
        structure: &'static str,
        /// Logarithm of the largest coordinate, base 2, rounded down.
        exponent: i32,
        precision: &'static str,
        /// Smallest and largest exponent of 2 that the precision supports.
        served: [i32; 2],
    },
    /// A limit on its size would be exceeded.
    #[error("{structure}: {what} would be {needed}, more than the limit of {limit}")]
    TooLarge {
        structure: &'static str,
        /// Name of the quantity that is too large.
        what: &'static str,
        /// Bytes that would be needed.
        needed: u128,
        limit: u128,
    },
    /// It needs more memory than there is for it.
    #[error(transparent)]
    OutOfMemory(#[from] OutOfMemory),
    /// A library that builds the structure refuses to.
    #[error("{structure}: cannot be built: {message}")]
    Library {
        structure: &'static str,
        /// The reason that it gives.
        message: String,
    },
    /// The process that was to build it, or to answer for it, ended or hung.
    #[error("{0}")]
    Died(String),
    /// A setting is wrong.
    #[error(transparent)]
    Param(#[from] ParamError),
}

/// Registry line of a structure.
///
/// Fields may be added. What is written so goes on compiling:
///
/// ```
/// use accel_core::structure::StructureInfo;
///
/// pub static INFO: StructureInfo = StructureInfo {
///     variants: &["", "leaf=8"],
///     ..StructureInfo::new("my-tree", "a tree of my own")
/// };
/// ```
#[derive(Debug)]
pub struct StructureInfo {
    /// Name as typed: `uniform-grid`.
    pub name: &'static str,
    /// Description in one line, for lists.
    pub summary: &'static str,
    /// The origin of the structure.
    pub paper: &'static str,
    /// Deviations from the paper.
    pub deviations: &'static str,
    /// Its parameters.
    pub params: &'static [ParamSpec],
    /// The settings that a run over "all structures" measures, each as `name=value ...`.
    pub variants: &'static [&'static str],
    /// Further settings that only the tests go through, written likewise.
    pub also_tested: &'static [&'static str],
    /// A defect that these settings keep on purpose (a library as shipped): its wrong hits are
    /// shown but are not a failure of this harness.
    pub known_defect: fn(&Params) -> Option<&'static str>,
    /// Only measured on a sample of the rays: it is too slow for all.
    pub sampled: bool,
}

impl StructureInfo {
    /// A structure without parameters, measured on all rays, with no known defect.
    pub const fn new(name: &'static str, summary: &'static str) -> Self {
        Self {
            name,
            summary,
            paper: "none",
            deviations: "none",
            params: &[],
            variants: &[""],
            also_tested: &[],
            known_defect: no_defect,
            sampled: false,
        }
    }

    /// The defaults of its parameters, to be set one by one: [`Params::set`].
    pub fn defaults(&self) -> Params {
        Params::defaults(self.name, self.params, &[])
    }
}

/// Refuses a set that no structure serves: without primitives, or out of scale.
pub(crate) fn refuse_unusable<S: Scalar>(
    prims: &dyn Primitives<S>,
    limits: Limits,
) -> Result<(), BuildError> {
    if prims.is_empty() {
        return Err(BuildError::NoPrimitives { structure: limits.structure });
    }
    // an id of each
    limits.fits(4 * prims.len() as u128)?;
    refuse_out_of_scale::<S, S>(prims.magnitude(), limits.structure)
}

/// Refuses a scene whose largest coordinate lies outside [`Scalar::SCENE_EXPONENTS`] of the scalar
/// `C` that a structure computes in; one that lies at the very origin has no scale.
pub(crate) fn refuse_out_of_scale<S: Scalar, C: Scalar>(
    magnitude: S,
    structure: &'static str,
) -> Result<(), BuildError> {
    let (largest, served) = (magnitude.to_f64(), C::SCENE_EXPONENTS);
    let exponent = largest.log2().floor();
    if largest == 0.0 || (f64::from(served[0])..f64::from(served[1])).contains(&exponent) {
        return Ok(());
    }
    // f64 has exponents down to -1074 only; infinity saturates
    let exponent = exponent as i32;
    Err(BuildError::OutOfScale { structure, exponent, precision: C::NAME, served })
}

/// The boxes of a set under a rule, where the scalar has room for the scene's.
pub(crate) fn bounds_of<'a, S: Scalar>(
    prims: &'a dyn Primitives<S>,
    rule: BoundsRule,
    structure: &'static str,
) -> Result<BoundsOf<'a, S>, BuildError> {
    BoundsOf::new(prims, rule).map_err(|id| BuildError::NonFiniteBounds { structure, id })
}

/// [`Structure::traverse`] of a ray, with the blocks in place of the lists.
#[inline(always)]
pub(crate) fn traverse_by_blocks<S: Scalar, T: Structure<S>, K: Sink<S>>(
    structure: &T,
    blocks: &ListBlocks<S>,
    ray: &Ray<S>,
    sink: &mut K,
) {
    structure.traverse(ray, &mut BlockSink { blocks, query: sink });
}

/// The error where something is more than [`Limits::most`] of it: out of memory, where its own
/// limit would allow it.
pub(crate) fn too_many(
    limits: Limits,
    counted: &CountedItem,
    limit: u64,
    needed: u64,
) -> BuildError {
    let bytes = u128::from(needed) * u128::from(counted.bytes);
    match limits.fits(bytes) {
        Err(error) if needed <= limit => error.into(),
        _ => BuildError::TooLarge {
            structure: limits.structure,
            what: counted.what,
            needed: u128::from(needed),
            limit: u128::from(limit),
        },
    }
}

/// Value of [`StructureInfo::known_defect`] for structures without one.
pub fn no_defect(_: &Params) -> Option<&'static str> {
    None
}
