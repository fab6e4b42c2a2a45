//! The cases of the catalogue, by group.

use accel_core::primitives::PrimitiveError;

use super::cases;
use super::parts::Part;
use super::round::Round;
use measurement::plan::error::PlanError;
use measurement::settings::suggest;
use statistics::random::Random;

/// Draws a round of at most so many rays.
pub type Draw<S> = fn(&mut Random, usize) -> Result<Round<S>, PrimitiveError>;

/// Who is asked what.
#[derive(Debug)]
pub enum Ask {
    /// Structures, for hits.
    Rays {
        /// Rounds in single precision.
        single: Draw<f32>,
        /// Rounds in double precision.
        double: Draw<f64>,
        /// Structures with settings of the case's own, as labels; all that are asked for when
        /// there are none.
        rows: &'static [&'static str],
    },
    /// Parts of structures; each makes its trials.
    Parts(&'static [Part]),
}

/// One line of the catalogue.
#[derive(Debug)]
pub struct Case {
    /// `G1`.
    pub id: &'static str,
    /// What is hard about it.
    pub summary: &'static str,
    /// What says which answer is right.
    pub oracle: &'static str,
    /// Who is asked what.
    pub ask: Ask,
    /// One ray of so many asked for is drawn: for scenes that make rays dear.
    pub share: usize,
}

/// A case whose rounds `$draw` makes in both precisions, or that examines `parts`.
#[macro_export]
macro_rules! case {
    ($id:literal, $oracle:literal, parts $parts:expr, $summary:literal) => {
        $crate::verify::registry::Case {
            id: $id,
            summary: $summary,
            oracle: $oracle,
            ask: $crate::verify::registry::Ask::Parts($parts),
            share: 1,
        }
    };
    ($id:literal, $oracle:literal, $draw:path, $summary:literal) => {
        $crate::case!($id, $oracle, $draw, $summary, 1, &[])
    };
    ($id:literal, $oracle:literal, $draw:path, $summary:literal, $share:literal, $rows:expr) => {
        $crate::verify::registry::Case {
            id: $id,
            summary: $summary,
            oracle: $oracle,
            ask: $crate::verify::registry::Ask::Rays { single: $draw, double: $draw, rows: $rows },
            share: $share,
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

/// All parts that cases examine, each name once.
pub fn parts() -> impl Iterator<Item = &'static str> {
    let of = |case: &'static Case| match case.ask {
        Ask::Parts(parts) => parts,
        Ask::Rays { .. } => &[],
    };
    let mut seen = std::collections::BTreeSet::new();
    all().flat_map(move |(_, case)| of(case)).map(|p| p.name).filter(move |name| seen.insert(*name))
}

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
