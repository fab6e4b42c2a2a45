//! Settings of a structure: named, typed, with defaults and ranges.

#![warn(missing_docs)]

pub mod config;
pub mod specs;

use std::collections::BTreeMap;
use std::fmt;

use crate::grid::resolution::ResolutionRule;
use crate::memory::{Limits, MemoryLimit};

/// Valid values of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParamKind {
    /// A whole number in a closed range.
    Integer {
        /// Smallest valid value, inclusive.
        min: u64,
        /// Largest valid value, inclusive.
        max: u64,
    },
    /// A real number in a closed range.
    Real {
        /// Smallest valid value, inclusive.
        min: f64,
        /// Largest valid value, inclusive.
        max: f64,
    },
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A rule for the number of voxels, or voxels like 64x64x16.
    Resolution,
}

impl fmt::Display for ParamKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer { min, max } => write!(f, "a whole number from {min} to {max}"),
            Self::Real { min, max } => write!(f, "a number from {min} to {max}"),
            Self::Choice(words) => write!(f, "one of {}", words.join(", ")),
            Self::Resolution => {
                write!(f, "one of {} or voxels like 64x64x16", ResolutionRule::NAMES.join(", "))
            }
        }
    }
}

/// One parameter of a structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParamSpec {
    /// Name as typed: `density`.
    pub name: &'static str,
    /// Description in one line.
    pub summary: &'static str,
    /// Value when nothing is said.
    pub default: &'static str,
    /// Valid values.
    pub kind: ParamKind,
}

impl ParamSpec {
    /// A whole number from `min` to `max`, its summary to be given.
    pub const fn integer(name: &'static str, default: &'static str, min: u64, max: u64) -> Self {
        Self { name, summary: "", default, kind: ParamKind::Integer { min, max } }
    }

    /// A real number likewise.
    pub const fn real(name: &'static str, default: &'static str, min: f64, max: f64) -> Self {
        Self { name, summary: "", default, kind: ParamKind::Real { min, max } }
    }

    /// One of these words likewise.
    pub const fn choice(
        name: &'static str,
        default: &'static str,
        words: &'static [&'static str],
    ) -> Self {
        Self { name, summary: "", default, kind: ParamKind::Choice(words) }
    }

    /// The same with this summary, where it is one.
    #[must_use]
    pub const fn about(self, summary: &'static str) -> Self {
        if summary.is_empty() { self } else { Self { summary: summary.trim_ascii(), ..self } }
    }
}

/// A setting that cannot be used; names what is valid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of a variant says what its fields are")]
pub enum ParamError {
    /// No such parameter.
    #[error("{structure} has no parameter '{name}'; {}", valid_names(.valid))]
    Unknown { structure: &'static str, name: String, valid: Vec<&'static str> },
    /// The value does not fit.
    #[error("{structure}.{name} = '{value}': expected {expected}")]
    Invalid {
        structure: &'static str,
        name: &'static str,
        value: String,
        /// Description of the valid values.
        expected: String,
    },
}

fn valid_names(valid: &[&str]) -> String {
    if valid.is_empty() { "it has none".into() } else { format!("it has {}", valid.join(", ")) }
}

/// Validated settings as they are typed: every parameter of a structure has a value. A build is
/// given [`config::Settings`], which are read off these before.
///
/// ```
/// use accel_core::structures::uniform_grid::INFO;
///
/// let params = INFO.defaults().set("density", 4)?.set("traversal", "driving-axis")?;
/// assert_eq!(params.label(), "uniform-grid density=4 traversal=driving-axis");
/// let error = params.set("density", -1).unwrap_err();
/// assert!(error.to_string().starts_with("uniform-grid.density = '-1': expected a number from"));
/// # Ok::<(), accel_core::params::ParamError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Params {
    limits: Limits,
    /// Its own, and those that it has in common with others.
    specs: [&'static [ParamSpec]; 2],
    values: BTreeMap<&'static str, String>,
}

impl Params {
    /// The defaults, overridden by `settings` (later ones win).
    ///
    /// # Errors
    /// [`ParamError`] for an unknown name or a value out of range.
    pub fn new<'s>(
        structure: &'static str,
        specs: &'static [ParamSpec],
        settings: impl IntoIterator<Item = (&'s str, &'s str)>,
    ) -> Result<Self, ParamError> {
        Self::defaults(structure, specs, &[]).set_all(settings)
    }

    /// The defaults of a structure's own parameters, and of those that it has in common with
    /// others.
    pub fn defaults(
        structure: &'static str,
        own: &'static [ParamSpec],
        common: &'static [ParamSpec],
    ) -> Self {
        let values = own.iter().chain(common).map(|s| (s.name, s.default.to_owned())).collect();
        let limits = Limits { structure, memory: MemoryLimit::NONE };
        Self { limits, specs: [own, common], values }
    }

    /// The same with a parameter at this value: a number, a word, or what the command line would
    /// say.
    ///
    /// # Errors
    /// [`ParamError`] for an unknown name or a value out of range.
    pub fn set(mut self, name: &str, value: impl ToString) -> Result<Self, ParamError> {
        let value = value.to_string();
        let Some(spec) = self.specs().find(|s| s.name == name) else {
            let valid = self.specs().map(|s| s.name).collect();
            let (structure, name) = (self.structure(), name.into());
            return Err(ParamError::Unknown { structure, name, valid });
        };
        if !is_valid(spec.kind, &value) {
            let expected = spec.kind.to_string();
            let (structure, name) = (self.structure(), spec.name);
            return Err(ParamError::Invalid { structure, name, value, expected });
        }
        self.values.insert(spec.name, value);
        Ok(self)
    }

    /// The same with all these settings, later ones before earlier ones.
    ///
    /// # Errors
    /// As [`Params::set`].
    pub fn set_all<'s>(
        self,
        settings: impl IntoIterator<Item = (&'s str, &'s str)>,
    ) -> Result<Self, ParamError> {
        settings.into_iter().try_fold(self, |params, (name, value)| params.set(name, value))
    }

    /// The same with values that were validated as those of another structure.
    pub(crate) fn taken<'s>(
        mut self,
        values: impl IntoIterator<Item = (&'static str, &'s str)>,
    ) -> Self {
        self.values.extend(values.into_iter().map(|(name, value)| (name, value.to_owned())));
        self
    }

    fn specs(&self) -> impl Iterator<Item = &'static ParamSpec> + use<> {
        self.specs.into_iter().flatten()
    }

    /// The same for a structure that may take so much memory.
    #[must_use]
    pub fn within(self, memory: MemoryLimit) -> Self {
        Self { limits: Limits { memory, ..self.limits }, ..self }
    }

    /// Memory limit of the structure.
    pub fn memory(&self) -> MemoryLimit {
        self.limits.memory
    }

    /// The structure these belong to.
    pub fn structure(&self) -> &'static str {
        self.limits.structure
    }

    /// A value as text.
    ///
    /// # Panics
    /// When the structure did not declare `name`: a mistake in its source, not in any input.
    pub fn text(&self, name: &str) -> &str {
        self.values.get(name).unwrap_or_else(|| {
            panic!("structure {} reads undeclared parameter {name}", self.structure())
        })
    }

    /// A value as text, or `None` when the structure did not declare `name`.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.values.get(name).map(String::as_str)
    }

    /// A real number. Panics as [`Params::text`], or when declared as another kind.
    pub fn real(&self, name: &str) -> f64 {
        self.parsed(name)
    }

    /// A whole number. Panics as [`Params::real`].
    pub fn integer(&self, name: &str) -> u64 {
        self.parsed(name)
    }

    /// A resolution rule. Panics as [`Params::real`].
    pub fn resolution(&self, name: &str) -> ResolutionRule {
        self.parsed(name)
    }

    /// A value, read from its text. Panics as [`Params::real`].
    pub fn parsed<T: std::str::FromStr>(&self, name: &str) -> T {
        let text = self.text(name);
        text.parse().unwrap_or_else(|_| {
            panic!("structure {} declared {name} as another kind: {text}", self.structure())
        })
    }

    /// The settings that differ from the defaults, as (name, value).
    pub fn changed(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.specs()
            .map(|s| (s, self.text(s.name)))
            .filter(|(s, v)| *v != s.default)
            .map(|(s, v)| (s.name, v))
    }

    /// The structure and what differs from its defaults: `uniform-grid density=4`.
    pub fn label(&self) -> String {
        format!("{} {self}", self.structure()).trim_end().to_owned()
    }
}

impl fmt::Display for Params {
    /// Prints settings that differ from the defaults, as `density=4 resolution=woo`; may be empty.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (name, value)) in self.changed().enumerate() {
            write!(f, "{}{name}={value}", if i == 0 { "" } else { " " })?;
        }
        Ok(())
    }
}

fn is_valid(kind: ParamKind, value: &str) -> bool {
    match kind {
        ParamKind::Integer { min, max } => {
            value.parse::<u64>().is_ok_and(|v| (min..=max).contains(&v))
        }
        ParamKind::Real { min, max } => value.parse::<f64>().is_ok_and(|v| v >= min && v <= max),
        ParamKind::Choice(words) => words.contains(&value),
        ParamKind::Resolution => value.parse::<ResolutionRule>().is_ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static SPECS: &[ParamSpec] = &[
        ParamSpec::real("density", "2", 0.01, 100.0),
        ParamSpec::choice("order", "file", &["file", "reverse"]),
    ];

    #[test]
    fn defaults_overrides_and_text() {
        let p = Params::new("x", SPECS, []).unwrap();
        assert_eq!((p.real("density"), p.text("order"), p.to_string().as_str()), (2.0, "file", ""));
        let p = Params::new("x", SPECS, [("density", "4"), ("order", "reverse")]).unwrap();
        assert_eq!(p.to_string(), "density=4 order=reverse");
    }

    #[test]
    fn errors_name_what_is_valid() {
        let e = Params::new("x", SPECS, [("depth", "1")]).unwrap_err();
        assert_eq!(e.to_string(), "x has no parameter 'depth'; it has density, order");
        for bad in ["0", "1e9", "NaN", "inf", "four", ""] {
            let e = Params::new("x", SPECS, [("density", bad)]).unwrap_err();
            assert!(e.to_string().contains("expected a number from 0.01 to 100"), "{e}");
        }
        assert!(Params::new("x", SPECS, [("order", "up")]).is_err());
    }
}
