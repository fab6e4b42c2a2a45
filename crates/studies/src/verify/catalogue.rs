//! The cases of the catalogue, by group.

use super::cases;
use super::registry::{Case, Group};
use measurement::plan::error::PlanError;
use measurement::settings::choice;

pub static GROUPS: &[&Group] = &[
    &cases::ray::GROUP,
    &cases::geometry::GROUP,
    &cases::grid::GROUP,
    &cases::traversal::GROUP,
    &cases::secondary::GROUP,
    &cases::reported::GROUP,
];

/// A case and its group.
pub type CatalogueEntry = (&'static Group, &'static Case);

/// All cases in the order of the catalogue.
pub fn all() -> impl Iterator<Item = CatalogueEntry> {
    GROUPS.iter().flat_map(|&g| g.cases.iter().map(move |c| (g, c)))
}

/// The cases and groups of these names; all when there are none.
///
/// # Errors
/// [`PlanError::UnknownCase`] naming what is valid.
pub fn select(names: &[String]) -> Result<Vec<CatalogueEntry>, PlanError> {
    let is_named = |name: &str, (group, case): &CatalogueEntry| {
        name.eq_ignore_ascii_case(group.name) || name.eq_ignore_ascii_case(case.id)
    };
    if let Some(name) = names.iter().find(|name| !all().any(|listed| is_named(name, &listed))) {
        return Err(unknown(name));
    }
    let is_wanted = |listed: &CatalogueEntry| {
        names.is_empty() || names.iter().any(|name| is_named(name, listed))
    };
    Ok(all().filter(is_wanted).collect())
}

/// The case of that id.
///
/// # Errors
/// [`PlanError::UnknownCase`].
pub fn find(id: &str) -> Result<CatalogueEntry, PlanError> {
    all().find(|(_, case)| case.id.eq_ignore_ascii_case(id)).ok_or_else(|| unknown(id))
}

fn unknown(name: &str) -> PlanError {
    let valid: Vec<&str> = GROUPS.iter().map(|g| g.name).chain(all().map(|(_, c)| c.id)).collect();
    PlanError::UnknownCase {
        hint: choice::hint(name, valid.iter().copied()),
        name: name.to_owned(),
        valid: valid.join(", "),
    }
}
