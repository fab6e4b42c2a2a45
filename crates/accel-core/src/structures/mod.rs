//! Acceleration structures. One file a structure, one line each in [`REGISTRY`].
//!
//! A structure holds ids and knows nothing of primitives but their bounds. Help, `rtbench list`,
//! the settings parser and the test matrix are all made from the registry.

pub mod adaptive_grid;
pub mod bounding_volumes;
pub mod bricked_grid;
pub mod brute_force;
mod cluster_bvh;
pub mod compact_grid;
#[cfg(feature = "embree")]
pub mod embree;
pub mod hashed_grid;
pub mod hug;
pub mod irregular_grid;
pub mod kay_kajiya;
pub mod kd_tree;
mod nested_grids;
mod obvhs_adapter;
mod obvhs_builder;
pub mod obvhs_bvh2;
pub mod obvhs_cwbvh;
pub mod octree;
pub mod proximity_clouds;
pub mod recursive_grid;
pub mod regular_grid;
pub mod specs;
#[cfg(test)]
pub(crate) mod test_scenes;
pub mod two_level_grid;
pub mod uniform_grid;

use crate::mailbox::Setting;
use crate::memory::{Counted, OutOfMemory};
use crate::params::{ParamError, ParamSpec, Params};
use crate::primitives::chosen::{self, Choice, ChosenTests};
use crate::primitives::{MixedSet, PrimSet, TriangleSet};
use crate::ray::{Hit, Ray};
use crate::scalar::Scalar;
use crate::sink::Sink;
use crate::tracer::{Bound, BoundInMotion, Tracer};

/// Every structure of the workspace: one line each.
pub static REGISTRY: &[Entry] = &[
    entry!(brute_force::BruteForce, brute_force::INFO),
    entry!(uniform_grid::UniformGrid, uniform_grid::INFO),
    entry!(hashed_grid::HashedGrid, hashed_grid::INFO),
    entry!(compact_grid::CompactGrid, compact_grid::INFO),
    entry!(bricked_grid::BrickedGrid, bricked_grid::INFO),
    entry!(proximity_clouds::ProximityClouds, proximity_clouds::INFO),
    entry!(recursive_grid::RecursiveGrid, recursive_grid::INFO),
    entry!(hug::Hug, hug::INFO),
    entry!(two_level_grid::TwoLevelGrid, two_level_grid::INFO),
    entry!(adaptive_grid::AdaptiveGrid, adaptive_grid::INFO),
    entry!(irregular_grid::IrregularGrid, irregular_grid::INFO),
    entry!(octree::Octree, octree::INFO),
    entry!(kd_tree::KdTree, kd_tree::INFO),
    entry!(bounding_volumes::BoundingVolumes, bounding_volumes::INFO),
    entry!(kay_kajiya::KayKajiya, kay_kajiya::INFO),
    entry!(obvhs_bvh2::ObvhsBvh2, obvhs_bvh2::INFO),
    entry!(obvhs_cwbvh::ObvhsCwBvh, obvhs_cwbvh::INFO),
    #[cfg(feature = "embree")]
    entry!(embree::Embree, embree::INFO),
];

/// An acceleration structure over primitive ids.
pub trait Structure<S: Scalar>: Sized + Send + Sync {
    /// Whether a walk may push an id more than once. Without duplicates a mailbox is of no use,
    /// and none is compiled.
    const DUPLICATES: bool = true;

    /// Builds the structure over all primitives of the set.
    ///
    /// # Errors
    /// [`BuildError`] when the set or the settings cannot be served; never a panic.
    fn build<P: PrimSet<S>>(prims: &P, params: &Params) -> Result<Self, BuildError>;

    /// Pushes every primitive that the ray may hit within the sink's interval, in any order, and
    /// may stop as soon as the rest lies beyond `sink.t_max()`. The ray is traceable
    /// ([`Ray::is_traceable`]).
    fn walk<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K);

    /// Answers the rays of a batch in a way of its own, with the answers of [`Structure::walk`];
    /// false when it has none for this set, and rays are walked one after the other. Rays are
    /// brought near ([`crate::far_ray`]) within `reach`.
    #[inline(always)]
    fn closest_batch<P: PrimSet<S>>(
        &self,
        _prims: &P,
        _rays: &[Ray<S>],
        _reach: S,
        _hits: &mut [Hit<S>],
    ) -> bool {
        false
    }

    /// [`Structure::closest_batch`] for occlusion by opaque primitives.
    #[inline(always)]
    fn occlusion_batch<P: PrimSet<S>>(
        &self,
        _prims: &P,
        _rays: &[Ray<S>],
        _reach: S,
        _blocked: &mut [bool],
    ) -> bool {
        false
    }

    /// Whether [`Structure::closest_batch`] and [`Structure::occlusion_batch`], where they serve,
    /// have several rays on their way at once: such a row is marked as one of batches.
    #[inline(always)]
    fn has_rays_side_by_side(&self) -> bool {
        false
    }

    /// What was built; a walk over the structure, not part of the build.
    fn shape(&self) -> Shape;
}

/// What a structure consists of, in the symbols of Havran and Sixta (1999).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Shape {
    /// N_IN: hierarchical cells (inner nodes).
    pub inner_cells: u64,
    /// N_V: elementary cells (voxels, leaves).
    pub cells: u64,
    /// N_EV: elementary cells without primitives.
    pub empty_cells: u64,
    /// N_OIV: primitive references in elementary cells.
    pub references: u64,
    /// Voxels an axis, for structures that have one resolution.
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
pub enum BuildError {
    /// There is nothing to build over.
    #[error("{structure}: the scene has no primitives")]
    NoPrimitives {
        /// Structure.
        structure: &'static str,
    },
    /// The scene's box is too large for the scalar.
    #[error("{structure}: the scene is too large for this precision (see primitive {id})")]
    NonFiniteBounds {
        /// Structure.
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
        /// Structure.
        structure: &'static str,
        /// Logarithm of the largest coordinate, base 2, rounded down.
        exponent: i32,
        /// `f32` or `f64`.
        precision: &'static str,
        /// What would be served.
        served: [i32; 2],
    },
    /// A limit on its size would be exceeded.
    #[error("{structure}: {what} would be {needed}, more than the limit of {limit}")]
    TooLarge {
        /// Structure.
        structure: &'static str,
        /// What is too large.
        what: &'static str,
        /// How much was needed.
        needed: u128,
        /// The limit.
        limit: u128,
    },
    /// It needs more memory than there is for it.
    #[error(transparent)]
    OutOfMemory(#[from] OutOfMemory),
    /// A library that builds the structure refuses to.
    #[error("{structure}: the library reports an error: {message}")]
    Library {
        /// Structure.
        structure: &'static str,
        /// What it says.
        message: String,
    },
    /// A setting is wrong.
    #[error(transparent)]
    Param(#[from] ParamError),
}

/// What a registry line says of a structure.
#[derive(Debug)]
pub struct StructureInfo {
    /// Name as typed: `uniform-grid`.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Where it comes from.
    pub paper: &'static str,
    /// What we do differently.
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

/// A set of primitives, whichever.
pub enum PrimsRef<'a, S: Scalar> {
    /// Triangles with the watertight test.
    Watertight(&'a TriangleSet<S>),
    /// Primitives of any kind.
    Mixed(&'a MixedSet<S>),
}

impl<S: Scalar> Clone for PrimsRef<'_, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Scalar> Copy for PrimsRef<'_, S> {}

type Builder<S> =
    for<'a> fn(PrimsRef<'a, S>, &Params) -> Result<Box<dyn Tracer<S> + 'a>, BuildError>;

/// One line of the registry.
pub struct Entry {
    /// What it says of itself.
    pub info: &'static StructureInfo,
    build_f32: Builder<f32>,
    build_f64: Builder<f64>,
}

impl Entry {
    /// Validates settings.
    ///
    /// # Errors
    /// [`ParamError`] naming what is valid.
    pub fn params<'s>(
        &self,
        settings: impl IntoIterator<Item = (&'s str, &'s str)>,
    ) -> Result<Params, ParamError> {
        Params::with_common(self.info.name, self.info.params, chosen::PARAMS, settings)
    }

    /// Builds the structure over the set, ready to trace.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn build<'a, S: Buildable>(
        &self,
        prims: PrimsRef<'a, S>,
        params: &Params,
    ) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
        S::builder(self)(prims, params)
    }
}

/// The scalars that registry entries have builders for.
pub trait Buildable: Scalar {
    /// The entry's builder for this scalar.
    fn builder(entry: &Entry) -> Builder<Self>;
}

impl Buildable for f32 {
    fn builder(entry: &Entry) -> Builder<f32> {
        entry.build_f32
    }
}

impl Buildable for f64 {
    fn builder(entry: &Entry) -> Builder<f64> {
        entry.build_f64
    }
}

/// The entry of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    REGISTRY.iter().find(|e| e.info.name == name)
}

/// Builds `T` over whichever set it is and boxes it as a tracer.
pub fn build_tracer<'a, S: Scalar, T: Structure<S> + 'a>(
    prims: PrimsRef<'a, S>,
    params: &Params,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    fn over<'a, S: Scalar, P: PrimSet<S>, T: Structure<S> + 'a>(
        prims: &'a P,
        params: &Params,
    ) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
        let mailbox = mailbox::<S, P>(prims, params)?;
        Ok(Box::new(Bound::new(prims, T::build(prims, params)?).with_mailbox(mailbox)))
    }
    fn mailbox<S: Scalar, P: PrimSet<S>>(
        prims: &P,
        params: &Params,
    ) -> Result<Setting, BuildError> {
        refuse_unusable(prims, params)?;
        Ok(Setting::of(params, prims.len(), prims.bytes()))
    }
    if let Some(choice) = Choice::of(params) {
        // built from the same bounds, so the structure is that of the set itself
        let (view, mailbox, structure) = match prims {
            PrimsRef::Watertight(p) => {
                let mailbox = mailbox::<S, _>(p, params)?;
                (ChosenTests::of_triangles(p, choice), mailbox, T::build(p, params)?)
            }
            PrimsRef::Mixed(p) => {
                let mailbox = mailbox::<S, _>(p, params)?;
                (ChosenTests::of_mixed(p, choice), mailbox, T::build(p, params)?)
            }
        };
        return Ok(Box::new(Bound::new(Box::new(view), structure).with_mailbox(mailbox)));
    }
    match prims {
        PrimsRef::Watertight(p) => over::<S, _, T>(p, params),
        PrimsRef::Mixed(p) if p.has_motion() => {
            // built from the bounds of the whole way, so the structure is that of any mixed set
            let mailbox = mailbox::<S, _>(p, params)?;
            let bound = Bound::new(p.in_motion(), T::build(p, params)?).with_mailbox(mailbox);
            Ok(Box::new(BoundInMotion(bound)))
        }
        PrimsRef::Mixed(p) => over::<S, _, T>(p, params),
    }
}

/// Refuses a set that no structure serves: without primitives, or out of scale.
pub(crate) fn refuse_unusable<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    params: &Params,
) -> Result<(), BuildError> {
    if prims.is_empty() {
        return Err(BuildError::NoPrimitives { structure: params.structure() });
    }
    // an id of each
    params.fits(4 * prims.len() as u128)?;
    refuse_out_of_scale::<S, S>(prims.magnitude(), params.structure())
}

/// Refuses a scene whose largest coordinate lies outside [`Scalar::SCENE_EXPONENTS`] of the scalar
/// `C` that a structure computes in; one that lies at the very origin has no scale.
fn refuse_out_of_scale<S: Scalar, C: Scalar>(
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

/// The error where something is more than [`Params::most`] of it: out of memory, where the setting would
/// allow it.
pub(crate) fn too_many(params: &Params, counted: &Counted, needed: u64) -> BuildError {
    let (structure, limit) = (params.structure(), params.integer(counted.setting));
    let bytes = u128::from(needed) * u128::from(counted.bytes);
    match params.fits(bytes) {
        Err(error) if needed <= limit => error.into(),
        _ => BuildError::TooLarge {
            structure,
            what: counted.what,
            needed: u128::from(needed),
            limit: u128::from(limit),
        },
    }
}

/// A registry entry for a generic structure and its description.
#[macro_export]
macro_rules! entry {
    ($structure:path, $info:path) => {
        $crate::structures::Entry::new(
            &$info,
            |p, s| {
                use $structure as It;
                $crate::structures::build_tracer::<f32, It<f32>>(p, s)
            },
            |p, s| {
                use $structure as It;
                $crate::structures::build_tracer::<f64, It<f64>>(p, s)
            },
        )
    };
}
use entry;

impl Entry {
    /// Used by [`entry!`].
    pub const fn new(
        info: &'static StructureInfo,
        build_f32: Builder<f32>,
        build_f64: Builder<f64>,
    ) -> Self {
        Self { info, build_f32, build_f64 }
    }
}

/// For [`StructureInfo::known_defect`]: none.
pub fn no_defect(_: &Params) -> Option<&'static str> {
    None
}
