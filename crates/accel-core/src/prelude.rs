//! Items for a structure in a crate of its own.
//!
//! It stays: what is here changes only with a new minor version of this crate (a new major one from
//! 1.0 on), and then `CHANGELOG.md` says how. Methods of traits with an implementation, fields of
//! [`StructureInfo`] and of [`StructureStats`], and errors may be added. `peers/rust-template` is
//! built and measured in CI against it. Whatever is not here may change at any time.

#![warn(missing_docs)]

pub use crate::geometry::aabb::Aabb;
pub use crate::geometry::ray::{Hit, MISS, Ray};
pub use crate::geometry::scalar::{Scalar, Vec3, Vector};
pub use crate::historical::bounds_rule::{BoundsOf, BoundsRule};
pub use crate::params::config::{Config, Settings};
pub use crate::params::{ParamError, ParamKind, ParamSpec, Params};
pub use crate::primitives::{PrimSet, Primitives, PrimsRef, TriangleSet};
pub use crate::query::sink::Sink;
pub use crate::query::tracer::Tracer;
pub use crate::structure::{
    BatchAnswers, Batches, BuildError, RayBatch, Structure, StructureInfo, StructureStats,
    no_defect,
};
pub use crate::structures::{Entry, REGISTRY, find};
pub use crate::{config, entry};
