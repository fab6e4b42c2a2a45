//! Registries: one line for each thing that can be named, its settings and its builders.

use crate::geometry::scalar::Scalar;
use crate::params::{ParamError, ParamSpec, Params};
use crate::structure::StructureInfo;

/// What a registry lists: structures, occluders, structures that shafts are asked of.
pub trait Listed: 'static {
    /// How one is built in a scalar.
    type Builder<S: Scalar>: Copy + Send + Sync;
    /// Parameters that all of them have besides their own.
    const COMMON: &'static [ParamSpec] = &[];
}

/// One line of a registry.
pub struct Entry<L: Listed> {
    /// What it says of itself.
    pub info: &'static StructureInfo,
    build_f32: L::Builder<f32>,
    build_f64: L::Builder<f64>,
}

impl<L: Listed> Clone for Entry<L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<L: Listed> Copy for Entry<L> {}

impl<L: Listed> Entry<L> {
    /// A line with its builders.
    pub const fn new(
        info: &'static StructureInfo,
        build_f32: L::Builder<f32>,
        build_f64: L::Builder<f64>,
    ) -> Self {
        Self { info, build_f32, build_f64 }
    }

    /// Validates settings.
    ///
    /// # Errors
    /// [`ParamError`] naming what is valid.
    pub fn params<'s>(
        &self,
        settings: impl IntoIterator<Item = (&'s str, &'s str)>,
    ) -> Result<Params, ParamError> {
        Params::with_common(self.info.name, self.info.params, L::COMMON, settings)
    }
}

/// The scalars that registries have builders for.
pub trait Buildable: Scalar {
    /// The entry's builder for this scalar.
    fn builder<L: Listed>(entry: &Entry<L>) -> L::Builder<Self>;
}

impl Buildable for f32 {
    fn builder<L: Listed>(entry: &Entry<L>) -> L::Builder<f32> {
        entry.build_f32
    }
}

impl Buildable for f64 {
    fn builder<L: Listed>(entry: &Entry<L>) -> L::Builder<f64> {
        entry.build_f64
    }
}

/// The entry of that name.
pub fn find<L: Listed>(registry: &'static [Entry<L>], name: &str) -> Option<&'static Entry<L>> {
    registry.iter().find(|e| e.info.name == name)
}
