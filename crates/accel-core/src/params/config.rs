//! Typed settings: what a structure is built by, read off [`Params`] once, before anything is
//! built.

#![warn(missing_docs)]

use std::ops::Deref;

use super::Params;
use crate::memory::{Limits, MemoryLimit, OutOfMemory};

/// The settings of a structure, typed; [`config!`](crate::config) writes them with their
/// parameters.
pub trait Config: Clone + Send + Sync + 'static {
    /// Reads the settings from parameters that the structure declares.
    fn of(params: &Params) -> Self;
}

/// Settings of a structure without parameters.
impl Config for () {
    fn of(_: &Params) {}
}

/// Input of a build: the settings of the structure, and its limits.
#[derive(Debug, Clone)]
pub struct Settings<C> {
    limits: Limits,
    config: C,
}

impl<C: Config> Settings<C> {
    /// Those of the parameters.
    pub fn of(params: &Params) -> Self {
        Self { limits: params.limits, config: C::of(params) }
    }
}

impl<C> Settings<C> {
    /// Other settings of the same structure, within the same memory.
    pub(crate) fn with<D>(&self, config: D) -> Settings<D> {
        Settings { limits: self.limits, config }
    }

    /// The same for a structure that may take so much memory.
    #[must_use]
    pub(crate) fn within(self, memory: MemoryLimit) -> Self {
        Self { limits: Limits { memory, ..self.limits }, ..self }
    }

    /// The structure being built, and its memory limit.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// The structure these belong to.
    pub fn structure(&self) -> &'static str {
        self.limits.structure
    }

    /// Checks that a part of so many bytes may be taken, and can be had now.
    ///
    /// # Errors
    /// [`OutOfMemory`].
    pub fn fits(&self, bytes: u128) -> Result<(), OutOfMemory> {
        self.limits.fits(bytes)
    }
}

impl<C> Deref for Settings<C> {
    type Target = C;

    fn deref(&self) -> &C {
        &self.config
    }
}

/// Settings of a structure and the parameters that they are read from: the constant `PARAMS` of the
/// type, and its [`Config`](crate::params::config::Config). The text above a field is the summary
/// of its parameter, which keeps its own where there is none; `=>` reads a word. Parameters that
/// others read stand last, after `and`.
///
/// ```
/// use accel_core::prelude::*;
///
/// accel_core::config! {
///     /// How a tree is built.
///     pub struct TreeConfig {
///         /// most primitives of a leaf
///         leaf: usize = ParamSpec::integer("leaf", "4", 1, 64),
///         /// cuts at medians, or by cost
/// is_by_cost: bool = ParamSpec::choice("cut", "cost", &["median", "cost"]) => |cut| cut == "cost",
/// } }
///
/// pub static INFO: StructureInfo = StructureInfo {
///     params: TreeConfig::PARAMS,
///     ..StructureInfo::new("my-tree", "a tree of my own")
/// };
/// let config = TreeConfig::of(&INFO.defaults().set("leaf", 8)?);
/// assert!(config.leaf == 8 && config.is_by_cost);
/// # Ok::<(), ParamError>(())
/// ```
#[macro_export]
macro_rules! config {
    (
        $(#[$meta:meta])*
        $visible:vis struct $name:ident {
            $($(#[doc = $summary:literal])* $own:vis $field:ident: $type:ty = $spec:expr $(=> $read:expr)?,)*
        }
        $(and $($(#[$condition:meta])* $other:expr),* $(,)?)?
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone)]
        $visible struct $name {
            $($own $field: $type,)*
        }

        impl $name {
            /// All parameters.
            $visible const PARAMS: &[$crate::params::ParamSpec] = &[
                $($spec.about(concat!($($summary),*)),)*
                $($($(#[$condition])* $other,)*)?
            ];
        }

        impl $crate::params::config::Config for $name {
            fn of(params: &$crate::params::Params) -> Self {
                Self { $($field: $crate::config!(@read params, $spec $(, $read)?),)* }
            }
        }
    };
    (@read $params:ident, $spec:expr) => {
        $params.parsed({ const NAME: &str = $spec.name; NAME })
    };
    (@read $params:ident, $spec:expr, $read:expr) => {{
        const NAME: &str = $spec.name;
        let read: fn(&str) -> _ = $read;
        read($params.text(NAME))
    }};
}
