//! The cases of the catalogue, by group.

use accel_core::primitives::PrimitiveError;

use super::cases;
use super::round::Round;
use crate::plan::PlanError;
use crate::random::Random;
use crate::suggest;

/// Draws a round.
pub type Draw<S> = fn(&mut Random) -> Result<Round<S>, PrimitiveError>;

/// One line of the catalogue.
#[derive(Debug)]
pub struct Case {
    /// `G1`.
    pub id: &'static str,
    /// What is hard about it.
    pub summary: &'static str,
    /// What says which answer is right.
    pub oracle: &'static str,
    /// Rounds in single precision.
    pub single: Draw<f32>,
    /// Rounds in double precision.
    pub double: Draw<f64>,
}

/// A case whose rounds `$draw` makes in both precisions.
#[macro_export]
macro_rules! case {
    ($id:literal, $oracle:literal, $draw:path, $summary:literal) => {
        $crate::verify::registry::Case {
            id: $id,
            summary: $summary,
            oracle: $oracle,
            single: $draw,
            double: $draw,
        }
    };
}

/// Cases of a kind.
#[derive(Debug)]
pub struct Group {
    /// `geometry`.
    pub name: &'static str,
    /// Its cases.
    pub cases: &'static [Case],
}

/// All groups.
pub static GROUPS: &[&Group] = &[
    &cases::ray::GROUP,
    &cases::geometry::GROUP,
    &cases::grid::GROUP,
    &cases::traversal::GROUP,
    &cases::secondary::GROUP,
];

/// A case and its group.
pub type Listed = (&'static Group, &'static Case);

/// All cases in the order of the catalogue.
pub fn all() -> impl Iterator<Item = Listed> {
    GROUPS.iter().flat_map(|&g| g.cases.iter().map(move |c| (g, c)))
}

/// The cases and groups of these names; all when there are none.
///
/// # Errors
/// [`PlanError::UnknownCase`] naming what is valid.
pub fn select(names: &[String]) -> Result<Vec<Listed>, PlanError> {
    let is_named = |name: &str, (group, case): &Listed| {
        name.eq_ignore_ascii_case(group.name) || name.eq_ignore_ascii_case(case.id)
    };
    if let Some(name) = names.iter().find(|name| !all().any(|listed| is_named(name, &listed))) {
        return Err(unknown(name));
    }
    let is_wanted =
        |listed: &Listed| names.is_empty() || names.iter().any(|name| is_named(name, listed));
    Ok(all().filter(is_wanted).collect())
}

/// The case of that id.
///
/// # Errors
/// [`PlanError::UnknownCase`].
pub fn find(id: &str) -> Result<Listed, PlanError> {
    all().find(|(_, case)| case.id.eq_ignore_ascii_case(id)).ok_or_else(|| unknown(id))
}

fn unknown(name: &str) -> PlanError {
    let valid: Vec<&str> = GROUPS.iter().map(|g| g.name).chain(all().map(|(_, c)| c.id)).collect();
    PlanError::UnknownCase {
        hint: suggest::hint(name, valid.iter().copied()),
        name: name.to_owned(),
        valid: valid.join(", "),
    }
}
