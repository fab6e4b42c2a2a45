//! Registries: one line for each thing that can be named, its settings and its builders.

use crate::geometry::scalar::Scalar;
use crate::params::{ParamError, ParamSpec, Params};
use crate::structure::StructureInfo;

/// Items of a registry: structures, occluders, structures for frustum queries.
pub trait RegistryItem: 'static {
    /// How one is built in a scalar.
    type Builder<S: Scalar>: Copy + Send + Sync;
    /// Parameters that all of them have besides their own.
    const COMMON: &'static [ParamSpec] = &[];
}

/// One line of a registry.
pub struct Entry<L: RegistryItem> {
    /// Its description of itself.
    pub info: &'static StructureInfo,
    build_f32: L::Builder<f32>,
    build_f64: L::Builder<f64>,
}

impl<L: RegistryItem> Clone for Entry<L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<L: RegistryItem> Copy for Entry<L> {}

impl<L: RegistryItem> Entry<L> {
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
        self.defaults().set_all(settings)
    }

    /// The defaults, to be set one by one: [`Params::set`].
    pub fn defaults(&self) -> Params {
        Params::defaults(self.info.name, self.info.params, L::COMMON)
    }
}

/// A line that cannot be used: a mistake in its source.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegistryError {
    /// Settings are typed as `NAME:setting=value`, and `all` means all of them.
    #[error(
        "'{0}' cannot be the name of a structure: expected lowercase letters, digits and hyphens, and not 'all'"
    )]
    Name(&'static str),
    /// The same name twice.
    #[error("two structures have the name '{0}'")]
    SameName(&'static str),
    /// The same parameter twice, perhaps one that all structures have.
    #[error("{structure} has two parameters of the name '{name}'")]
    SameParam { structure: &'static str, name: &'static str },
    /// One of the variants that are measured or tested is not `name=value ...`.
    #[error("{structure}: '{settings}' is not a variant: expected name=value, separated by spaces")]
    Variant { structure: &'static str, settings: &'static str },
    /// The default of a parameter, or a variant, is not valid.
    #[error(transparent)]
    Param(#[from] ParamError),
}

/// Checks a registry: names of structures are valid and unique, none of
/// them among `taken`; all defaults and variants are valid.
///
/// # Errors
/// [`RegistryError`] for the first mistake.
pub fn check<L: RegistryItem>(registry: &[Entry<L>], taken: &[&str]) -> Result<(), RegistryError> {
    for (i, entry) in registry.iter().enumerate() {
        let info = entry.info;
        let is_letter = |c: char| matches!(c, 'a'..='z' | '0'..='9' | '-');
        if info.name.is_empty() || !info.name.chars().all(is_letter) || info.name == "all" {
            return Err(RegistryError::Name(info.name));
        }
        let before = registry.iter().take(i).map(|other| other.info.name);
        if before.chain(taken.iter().copied()).any(|name| name == info.name) {
            return Err(RegistryError::SameName(info.name));
        }
        let specs = || info.params.iter().chain(L::COMMON);
        for (i, spec) in specs().enumerate() {
            if specs().take(i).any(|other| other.name == spec.name) {
                return Err(RegistryError::SameParam { structure: info.name, name: spec.name });
            }
            entry.defaults().set(spec.name, spec.default)?;
        }
        for &settings in info.variants.iter().chain(info.also_tested) {
            let pairs = settings.split_whitespace().map(|part| part.split_once('='));
            let Some(pairs) = pairs.collect::<Option<Vec<_>>>() else {
                return Err(RegistryError::Variant { structure: info.name, settings });
            };
            entry.params(pairs)?;
        }
    }
    Ok(())
}

/// The scalars that registries have builders for.
pub trait Buildable: Scalar {
    /// The entry's builder for this scalar.
    fn builder<L: RegistryItem>(entry: &Entry<L>) -> L::Builder<Self>;
    /// The function for this scalar.
    fn of_both<F: PerScalar>(both: &ScalarPair<F>) -> F::In<Self>;
}

macro_rules! buildable {
    ($scalar:ident, $build:ident) => {
        impl Buildable for $scalar {
            fn builder<L: RegistryItem>(entry: &Entry<L>) -> L::Builder<$scalar> {
                entry.$build
            }

            fn of_both<F: PerScalar>(both: &ScalarPair<F>) -> F::In<$scalar> {
                both.$scalar
            }
        }
    };
}
buildable!(f32, build_f32);
buildable!(f64, build_f64);

/// A function over a scalar.
pub trait PerScalar {
    /// It, in a scalar.
    type In<S: Buildable>: Copy;
}

/// A function over a scalar, compiled for both where this stands and not again in each crate that
/// calls it, with whatever that one is optimised for.
pub struct ScalarPair<F: PerScalar> {
    pub f32: F::In<f32>,
    pub f64: F::In<f64>,
}

/// The entry of that name.
pub fn find<L: RegistryItem>(
    registry: &'static [Entry<L>],
    name: &str,
) -> Option<&'static Entry<L>> {
    registry.iter().find(|e| e.info.name == name)
}
