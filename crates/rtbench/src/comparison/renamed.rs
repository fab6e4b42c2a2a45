//! Rows that have another name now.
//!
//! Settings have `=` in them as the option has, so the text is cut where both halves name rows that
//! are there.

use std::fmt;

use crate::comparison::CompareError;
use measurement::record::{RowRecord, RunRecord, label};

/// A row, or all rows of a structure, and what it is called now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Renaming {
    old: Name,
    new: Name,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Name {
    structure: String,
    /// Those of one row; none stands for all rows of the structure.
    settings: Option<String>,
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.settings {
            Some(settings) => f.write_str(&label(&self.structure, settings)),
            None => write!(f, "all rows of {}", self.structure),
        }
    }
}

impl fmt::Display for Renaming {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "matched: {} with {}", self.old, self.new)
    }
}

/// Parses a text about the first run and the others.
pub fn matched(
    text: &str,
    old: &RunRecord,
    others: &[RunRecord],
) -> Result<Renaming, CompareError> {
    let old = std::slice::from_ref(old);
    let found = halves(text).filter_map(|(before, after)| {
        let named = |is_row| name_in(before, old, is_row).zip(name_in(after, others, is_row));
        // a structure without settings is all its rows
        let has_settings = |name: &Name| name.settings.as_ref().is_some_and(|s| !s.is_empty());
        let row = named(true).filter(|(old, new)| has_settings(old) || has_settings(new));
        let (old, new) = row.or_else(|| named(false))?;
        Some(Renaming { old, new })
    });
    let none = match text.contains('=') {
        true => "no row of the first results or none of the others has this name",
        false => "it has no '='",
    };
    only_one(text, found.collect(), none)
}

/// The same of two programs, of which the newer knows the new name.
pub fn of_programs(text: &str, is_known: &dyn Fn(&str) -> bool) -> Result<Renaming, CompareError> {
    let name = |text: &str, is_row: bool| {
        let label = text.trim().replace(':', " ");
        let (structure, settings) = label.split_once(' ').unwrap_or((&label, ""));
        Name { structure: structure.to_owned(), settings: is_row.then(|| settings.to_owned()) }
    };
    let known = halves(text).filter(|(old, new)| !old.is_empty() && is_known(new));
    let found = known.map(|(old, new)| {
        // a structure without settings is all its rows
        let is_row = [old, new].iter().any(|text| text.trim().contains([' ', ':']));
        Renaming { old: name(old, is_row), new: name(new, is_row) }
    });
    only_one(text, found.collect(), "this program has no row of the new name")
}

/// What is before and behind each `=`.
fn halves(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.match_indices('=').filter_map(|(at, _)| text.get(..at).zip(text.get(at + 1..)))
}

fn only_one(text: &str, mut found: Vec<Renaming>, none: &str) -> Result<Renaming, CompareError> {
    let message = match (found.pop(), found.len()) {
        (Some(only), 0) => return Ok(only),
        (None, _) => none,
        _ => "it is ambiguous",
    };
    Err(CompareError::Match { text: text.to_owned(), message: message.to_owned() })
}

fn rows(run: &RunRecord) -> impl Iterator<Item = &RowRecord> {
    run.scenes.iter().flat_map(|scene| &scene.rows)
}

/// The structure, or the row that is written so: `hug density=4` or `hug:density=4`.
fn name_in(text: &str, runs: &[RunRecord], is_row: bool) -> Option<Name> {
    let text = text.trim().replace(':', " ");
    let is_named =
        |row: &&RowRecord| text == if is_row { row.label() } else { row.structure.clone() };
    let row = runs.iter().flat_map(rows).find(is_named)?;
    Some(Name { structure: row.structure.clone(), settings: is_row.then(|| row.settings.clone()) })
}

impl Renaming {
    /// From the new name to the old one.
    pub fn reversed(&self) -> Self {
        Self { old: self.new.clone(), new: self.old.clone() }
    }

    /// Gives the rows of a run their new name.
    pub fn apply(&self, run: &mut RunRecord) {
        let Name { structure, settings } = &self.old;
        let is_meant = |row: &&mut RowRecord| {
            row.structure == *structure && settings.as_ref().is_none_or(|own| row.settings == *own)
        };
        for row in run.scenes.iter_mut().flat_map(|scene| &mut scene.rows).filter(is_meant) {
            let was = row.label();
            row.structure.clone_from(&self.new.structure);
            row.settings = self.new.settings.clone().unwrap_or_else(|| row.settings.clone());
            // the reference of the run, too
            if run.settings.reference == was {
                run.settings.reference = row.label();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::made_up::run;

    fn of(rows: &[&str]) -> RunRecord {
        let rows: Vec<(&str, &[f64])> = rows.iter().map(|row| (*row, &[1.0][..])).collect();
        run(&[("tetra", &rows)])
    }

    fn labels(run: &RunRecord) -> Vec<String> {
        rows(run).map(RowRecord::label).collect()
    }

    #[test]
    fn rows_and_structures_are_matched() {
        let new = [of(&["bvh", "hug density=4 rule=a", "grids", "grids density=2"])];
        let old = of(&["bvh", "hug density=4", "grid", "grid density=2"]);
        for (text, expected) in [
            (
                "hug density=4=hug density=4 rule=a",
                ["bvh", "hug density=4 rule=a", "grid", "grid density=2"],
            ),
            (
                "hug:density=4=hug:density=4:rule=a",
                ["bvh", "hug density=4 rule=a", "grid", "grid density=2"],
            ),
            ("grid=grids", ["bvh", "hug density=4", "grids", "grids density=2"]),
            ("grid density=2=grids", ["bvh", "hug density=4", "grid", "grids"]),
        ] {
            let mut run = old.clone();
            matched(text, &old, &new).unwrap().apply(&mut run);
            assert_eq!(labels(&run), expected, "{text}");
        }
        let mut run = old.clone();
        let new = [of(&["bvh2"])];
        matched("bvh=bvh2", &old, &new).unwrap().apply(&mut run);
        assert_eq!((run.settings.reference.as_str(), labels(&run)[0].as_str()), ("bvh2", "bvh2"));
    }

    #[test]
    fn renamings_that_match_no_row_are_refused() {
        let run = of(&["a", "a b=a", "b=a"]);
        let others = std::slice::from_ref(&run);
        for (text, said) in [
            ("a", "has no '='"),
            ("a=c", "no row of the first results"),
            ("c=a", "no row of the first results"),
            ("", "has no '='"),
        ] {
            let error = matched(text, &run, others).unwrap_err().to_string();
            assert!(error.contains(said) && error.contains("expected OLD=NEW"), "{error}");
        }
        assert!(matched("a b=a=a", &run, others).is_ok());
    }
}
