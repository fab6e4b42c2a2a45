//! Registries: one line for each thing that can be named, its settings and its builders.

use crate::geometry::scalar::Scalar;
use crate::params::{ParamError, ParamSpec, Params};
use crate::structure::StructureInfo;

/// What a registry lists: structures, occluders, structures that frusta are asked of.
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
        "'{0}' cannot be the name of a structure: expected small letters, digits and hyphens, and not 'all'"
    )]
    Name(&'static str),
    /// The same name twice.
    #[error("two structures have the name '{0}'")]
    SameName(&'static str),
    /// The same parameter twice, perhaps one that all structures have.
    #[error("{structure} has two parameters of the name '{name}'")]
    SameParam {
        /// Structure.
        structure: &'static str,
        /// Of both.
        name: &'static str,
    },
    /// One of the variants that are measured or tested is not `name=value ...`.
    #[error("{structure}: '{settings}' is no variant: expected name=value, separated by spaces")]
    Variant {
        /// Structure.
        structure: &'static str,
        /// As written.
        settings: &'static str,
    },
    /// The default of a parameter, or a variant, is not valid.
    #[error(transparent)]
    Param(#[from] ParamError),
}

/// Whether a registry can be used: names of structures are such and are there once, none of them among
/// `taken`; all defaults and variants are valid.
///
/// # Errors
/// [`RegistryError`] for the first mistake.
pub fn check<L: Listed>(registry: &[Entry<L>], taken: &[&str]) -> Result<(), RegistryError> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::ParamKind;
    use crate::structures::{REGISTRY, Traceable};

    const LEAF: ParamSpec = ParamSpec {
        name: "leaf",
        summary: "",
        default: "4",
        kind: ParamKind::Integer { min: 1, max: 8 },
    };
    const PARAMS: &[ParamSpec] = &[LEAF];
    const LEAF_0: &[ParamSpec] = &[ParamSpec { default: "0", ..LEAF }];
    const TWICE: &[ParamSpec] = &[LEAF, LEAF];
    const OF_ALL: &[ParamSpec] = &[ParamSpec { name: Traceable::COMMON[0].name, ..LEAF }];

    /// What is said of a registry with that line in it, whose builders are never asked.
    fn said_of(info: StructureInfo) -> String {
        let info: &'static StructureInfo = Box::leak(Box::new(info));
        let line = Entry { info, ..REGISTRY[0] };
        let registry: Vec<_> = REGISTRY.iter().copied().chain([line]).collect();
        check(&registry, &["light-buffer"]).err().map(|e| e.to_string()).unwrap_or_default()
    }

    #[test]
    fn planted_mistakes_are_named() {
        let own = |params, variants| StructureInfo {
            params,
            variants,
            ..StructureInfo::new("my-tree", "a tree")
        };
        assert_eq!(said_of(own(PARAMS, &["", "leaf=8"])), "");
        for (info, expected) in [
            (StructureInfo::new("", ""), "cannot be the name"),
            (StructureInfo::new("all", ""), "cannot be the name"),
            (StructureInfo::new("my tree", ""), "'my tree' cannot be the name"),
            (StructureInfo::new("kd-tree", ""), "two structures have the name 'kd-tree'"),
            (StructureInfo::new("light-buffer", ""), "two structures have the name"),
            (own(TWICE, &[""]), "my-tree has two parameters of the name 'leaf'"),
            (own(OF_ALL, &[""]), "my-tree has two parameters of the name"),
            (own(LEAF_0, &[""]), "my-tree.leaf = '0': expected a whole number from 1 to 8"),
            (own(PARAMS, &["leaf=9"]), "my-tree.leaf = '9'"),
            (own(PARAMS, &["depth=9"]), "my-tree has no parameter 'depth'; it has leaf"),
            (own(PARAMS, &["leaf 9"]), "'leaf 9' is no variant"),
        ] {
            let said = said_of(info);
            assert!(said.contains(expected), "{said}: expected {expected}");
        }
    }
}
