//! Structures with settings: the rows of the tables.

use accel_core::params::{ParamError, ParamSpec, Params};
use accel_core::registry::{Entry, RegistryItem};
use accel_core::structures::Traceable;
use accel_core::variants::chosen_tests;

use crate::plan::error::PlanError;
use crate::settings::choice;

pub struct Row<'r, L: RegistryItem = Traceable> {
    pub entry: &'r Entry<L>,
    pub params: Params,
}

impl<L: RegistryItem> Clone for Row<'_, L> {
    fn clone(&self) -> Self {
        Self { entry: self.entry, params: self.params.clone() }
    }
}

impl<L: RegistryItem> std::fmt::Debug for Row<'_, L> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.label())
    }
}

impl<L: RegistryItem> PartialEq for Row<'_, L> {
    fn eq(&self, other: &Self) -> bool {
        self.params == other.params
    }
}

impl<'r, L: RegistryItem> Row<'r, L> {
    pub fn structure(&self) -> &'static str {
        self.entry.info.name
    }

    /// Settings that differ from the defaults; empty for the defaults.
    pub fn settings(&self) -> String {
        self.params.to_string()
    }

    pub fn label(&self) -> String {
        self.params.label()
    }

    /// The defect that these settings keep on purpose, if any.
    pub fn known_defect(&self) -> Option<&'static str> {
        (self.entry.info.known_defect)(&self.params)
            .or_else(|| chosen_tests::known_defect(&self.params))
    }

    /// Only measured on a sample of the rays.
    pub fn is_sampled(&self) -> bool {
        self.entry.info.sampled
    }

    pub fn defaults(entry: &'r Entry<L>) -> Result<Self, PlanError> {
        Self::with(entry, &[], &[])
    }

    /// The structure with these settings, later ones before earlier ones.
    pub fn of(entry: &'r Entry<L>, settings: &[(&str, &str)]) -> Result<Self, PlanError> {
        Self::with(entry, &[], settings)
    }

    fn with(
        entry: &'r Entry<L>,
        overrides: &[Override<'r, '_, L>],
        settings: &[(&str, &str)],
    ) -> Result<Self, PlanError> {
        let own = overrides.iter().filter(|o| std::ptr::eq(o.entry, entry));
        let all = own.map(|o| (o.name, o.value)).chain(settings.iter().copied());
        let params = entry.params(all).map_err(|e| param_error(e, entry))?;
        Ok(Self { entry, params })
    }

    /// Reads `uniform-grid:resolution=woo:density=1`; spaces serve as colons, so that labels of
    /// tables can be given back.
    pub fn parse(registry: &'r [Entry<L>], text: &str) -> Result<Self, PlanError> {
        Self::parse_over(registry, text, &[])
    }

    fn parse_over(
        registry: &'r [Entry<L>],
        text: &str,
        overrides: &[Override<'r, '_, L>],
    ) -> Result<Self, PlanError> {
        let (entry, settings) = parse_settings(registry, text)?;
        Self::with(entry, overrides, &settings)
    }
}

/// Settings as typed: names and values.
pub type Assignments<'t> = Vec<(&'t str, &'t str)>;

/// Reads `uniform-grid:resolution=woo:density=1`; the settings are not validated.
pub fn parse_settings<'r, 't, L: RegistryItem>(
    registry: &'r [Entry<L>],
    text: &'t str,
) -> Result<(&'r Entry<L>, Assignments<'t>), PlanError> {
    let mut parts = text.split([':', ' ']).filter(|p| !p.is_empty());
    let entry = find(registry, parts.next().unwrap_or_default())?;
    let settings = parts.map(|p| assignment(p, text)).collect::<Result<Vec<_>, _>>()?;
    Ok((entry, settings))
}

struct Override<'r, 't, L: RegistryItem> {
    entry: &'r Entry<L>,
    name: &'t str,
    value: &'t str,
}

/// The rows that `-s` and `--set` ask for, without duplicates. `-s` entries come first in
/// precedence, then `--set`, then defaults; a structure that `--set` names is measured at the
/// settings asked for only, not at its variants.
pub fn select<'r, L: RegistryItem>(
    registry: &'r [Entry<L>],
    structures: &[String],
    overrides: &[String],
) -> Result<Vec<Row<'r, L>>, PlanError> {
    let overrides = overrides
        .iter()
        .map(|text| parse_override(registry, text))
        .collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    let mut push = |row: Row<'r, L>| {
        if !rows.contains(&row) {
            rows.push(row);
        }
    };
    let all = ["all".to_owned()];
    for text in if structures.is_empty() { &all } else { structures } {
        if text != "all" {
            push(Row::parse_over(registry, text, &overrides)?);
            continue;
        }
        for entry in registry {
            if overrides.iter().any(|o| std::ptr::eq(o.entry, entry)) {
                push(Row::with(entry, &overrides, &[])?);
                continue;
            }
            for variant in entry.info.variants {
                let settings = variant
                    .split_whitespace()
                    .map(|p| assignment(p, variant))
                    .collect::<Result<Vec<_>, _>>()?;
                push(Row::with(entry, &[], &settings)?);
            }
        }
    }
    for o in &overrides {
        if !rows.iter().any(|row| std::ptr::eq(row.entry, o.entry)) {
            return Err(PlanError::OverrideWithoutRow { structure: o.entry.info.name });
        }
    }
    Ok(rows)
}

/// The error for `--set` of a structure that no row is of, or of none at all.
pub fn override_without_row<L: RegistryItem>(
    registry: &[Entry<L>],
    overrides: &[String],
) -> PlanError {
    let Some(text) = overrides.first() else { return PlanError::NoRows };
    match parse_override(registry, text) {
        Ok(o) => PlanError::OverrideWithoutRow { structure: o.entry.info.name },
        Err(error) => error,
    }
}

fn parse_override<'r, 't, L: RegistryItem>(
    registry: &'r [Entry<L>],
    text: &'t str,
) -> Result<Override<'r, 't, L>, PlanError> {
    let malformed = || PlanError::Malformed {
        text: text.to_owned(),
        expected: "STRUCTURE.PARAM=VALUE, like uniform-grid.density=4",
    };
    let (path, value) = text.split_once('=').ok_or_else(malformed)?;
    let (structure, name) = path.split_once('.').ok_or_else(malformed)?;
    let over = Override { entry: find(registry, structure)?, name, value };
    // Says at once what is wrong, even when -s overrides the value again.
    Row::with(over.entry, &[], &[(name, value)])?;
    Ok(over)
}

fn assignment<'t>(part: &'t str, whole: &str) -> Result<(&'t str, &'t str), PlanError> {
    part.split_once('=').ok_or_else(|| PlanError::Malformed {
        text: whole.to_owned(),
        expected: "STRUCTURE:PARAM=VALUE:..., like uniform-grid:resolution=woo:density=1",
    })
}

pub fn find<'r, L: RegistryItem>(
    registry: &'r [Entry<L>],
    name: &str,
) -> Result<&'r Entry<L>, PlanError> {
    let unknown = || PlanError::unknown("structure", name, registry.iter().map(|e| e.info.name));
    registry.iter().find(|e| e.info.name == name).ok_or_else(unknown)
}

pub fn find_param<L: RegistryItem>(
    entry: &Entry<L>,
    name: &str,
) -> Result<&'static ParamSpec, PlanError> {
    let mut params = entry.info.params.iter().chain(L::COMMON);
    params.clone().find(|p| p.name == name).ok_or_else(|| {
        let valid = params.by_ref().map(|p| p.name).collect();
        let structure = entry.info.name;
        param_error(ParamError::Unknown { structure, name: name.to_owned(), valid }, entry)
    })
}

fn param_error<L: RegistryItem>(error: ParamError, entry: &Entry<L>) -> PlanError {
    let params = || entry.info.params.iter().chain(L::COMMON);
    let hint = match &error {
        ParamError::Unknown { name, .. } => choice::hint(name, params().map(|p| p.name)),
        ParamError::Invalid { .. } => String::new(),
    };
    PlanError::Param { error, hint }
}

#[cfg(test)]
mod tests {
    use accel_core::structures::REGISTRY;

    use super::*;

    fn labels(structures: &[&str], overrides: &[&str]) -> Result<Vec<String>, String> {
        let owned = |v: &[&str]| v.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
        select(REGISTRY, &owned(structures), &owned(overrides))
            .map(|rows| rows.iter().map(Row::label).collect())
            .map_err(|e| e.to_string())
    }

    #[test]
    fn all_variants_are_the_default() {
        let variants: usize = REGISTRY.iter().map(|e| e.info.variants.len()).sum();
        assert_eq!(labels(&[], &[]).unwrap().len(), variants);
        assert_eq!(labels(&["all", "uniform-grid"], &[]), labels(&[], &[]));
    }

    #[test]
    fn settings_are_parsed_and_duplicates_dropped() {
        let spec = "uniform-grid:resolution=woo:density=1";
        let expected = vec!["uniform-grid resolution=woo density=1".to_owned()];
        assert_eq!(labels(&[spec], &[]).unwrap(), expected);
        assert_eq!(labels(&[spec, &expected[0]], &[]).unwrap(), expected);
        assert_eq!(labels(&["uniform-grid:density=2"], &[]).unwrap(), ["uniform-grid"]);
    }

    #[test]
    fn overrides_make_one_row_of_a_structure() {
        let rows = labels(&[], &["uniform-grid.density=4"]).unwrap();
        let grids: Vec<_> = rows.iter().filter(|r| r.starts_with("uniform-grid")).collect();
        assert_eq!(grids, ["uniform-grid density=4"]);
        assert_eq!(
            labels(&["uniform-grid:resolution=woo"], &["uniform-grid.density=4"]).unwrap(),
            ["uniform-grid resolution=woo density=4"]
        );
    }

    #[test]
    fn errors_suggest() {
        let e = labels(&["unifrom-grid"], &[]).unwrap_err();
        assert!(e.contains("did you mean 'uniform-grid'?") && e.contains("obvhs-bvh2"), "{e}");
        let e = labels(&["uniform-grid:densty=1"], &[]).unwrap_err();
        assert!(e.contains("did you mean 'density'?") && e.contains("max-cells"), "{e}");
        let e = labels(&["uniform-grid:density"], &[]).unwrap_err();
        assert!(e.contains("uniform-grid:resolution=woo"), "{e}");
        let e = labels(&["brute-force"], &["uniform-grid.density=4"]).unwrap_err();
        assert!(e.contains("uniform-grid"), "{e}");
        for bad in ["density=4", "uniform-grid.density", "uniform-grid.density=x", "x.y=1", ""] {
            assert!(labels(&[], &[bad]).is_err(), "{bad}");
        }
        assert!(labels(&[""], &[]).is_err());
    }
}
