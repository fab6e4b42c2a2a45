//! Rows that have another name now.
//!
//! Settings have `=` in them as the option has, so the text is cut where both halves name rows that
//! are there.

use std::fmt;

use crate::comparison::CompareError;
use measurement::record::{RowRecord, RunRecord};

/// A row, or all rows of a structure, and what it is called now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Renaming {
    old: Name,
    new: Name,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Name {
    Row { structure: String, settings: String },
    Structure(String),
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Row { structure, settings } if settings.is_empty() => f.write_str(structure),
            Self::Row { structure, settings } => write!(f, "{structure} {settings}"),
            Self::Structure(structure) => write!(f, "all rows of {structure}"),
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
    let cuts = text
        .match_indices('=')
        .filter_map(|(place, _)| Some((text.get(..place)?, text.get(place + 1..)?)));
    let mut found: Vec<Renaming> = Vec::new();
    for (before, after) in cuts.clone() {
        let row = |text: &str, runs: &[RunRecord]| runs.iter().find_map(|run| row(text, run));
        let structure =
            |text: &str, runs: &[RunRecord]| runs.iter().find_map(|run| structure(text, run));
        let old = std::slice::from_ref(old);
        let rows = row(before, old).zip(row(after, others));
        let all = || structure(before, old).zip(structure(after, others));
        // a structure without settings is all its rows
        let is_plain =
            |name: &Name| matches!(name, Name::Row { settings, .. } if settings.is_empty());
        let rows = rows.filter(|(old, new)| !(is_plain(old) && is_plain(new)));
        let either = rows.or_else(all);
        found.extend(either.map(|(old, new)| Renaming { old, new }));
    }
    let message = match (found.len(), cuts.count()) {
        (1, _) => return found.pop().ok_or_else(|| error(text, "nothing")),
        (0, 0) => "it has no '='",
        (0, _) => "no row of the first results or none of the others has this name",
        _ => "it is ambiguous",
    };
    Err(error(text, message))
}

/// The same of two programs, of which the newer knows the new name.
pub fn of_programs(text: &str, is_known: &dyn Fn(&str) -> bool) -> Result<Renaming, CompareError> {
    let name = |text: &str| {
        let label = text.trim().replace(':', " ");
        let (structure, settings) = label.split_once(' ').unwrap_or((&label, ""));
        Name::Row { structure: structure.to_owned(), settings: settings.to_owned() }
    };
    let all_of = |row: Name| match row {
        Name::Row { structure, .. } => Name::Structure(structure),
        structure => structure,
    };
    let mut found: Vec<Renaming> = Vec::new();
    for (place, _) in text.match_indices('=') {
        let halves = text.get(..place).zip(text.get(place + 1..));
        let Some((old, new)) = halves.filter(|(old, new)| !old.is_empty() && is_known(new)) else {
            continue;
        };
        let has_settings = |text: &str| text.trim().contains([' ', ':']);
        found.push(if has_settings(old) || has_settings(new) {
            Renaming { old: name(old), new: name(new) }
        } else {
            // a structure without settings is all its rows
            Renaming { old: all_of(name(old)), new: all_of(name(new)) }
        });
    }
    match (found.len(), found.pop()) {
        (1, Some(renamed)) => Ok(renamed),
        (0, _) => Err(error(text, "this program has no row of the new name")),
        _ => Err(error(text, "it is ambiguous")),
    }
}

fn error(text: &str, message: &str) -> CompareError {
    CompareError::Match { text: text.to_owned(), message: message.to_owned() }
}

fn rows(run: &RunRecord) -> impl Iterator<Item = &RowRecord> {
    run.scenes.iter().flat_map(|scene| &scene.rows)
}

/// The row that is written so: `hug density=4` or `hug:density=4`.
fn row(text: &str, run: &RunRecord) -> Option<Name> {
    let text = text.trim().replace(':', " ");
    let row = rows(run).find(|row| row.label() == text)?;
    Some(Name::Row { structure: row.structure.clone(), settings: row.settings.clone() })
}

fn structure(text: &str, run: &RunRecord) -> Option<Name> {
    let row = rows(run).find(|row| row.structure == text.trim())?;
    Some(Name::Structure(row.structure.clone()))
}

impl Renaming {
    /// From the new name to the old one.
    pub fn reversed(&self) -> Self {
        Self { old: self.new.clone(), new: self.old.clone() }
    }

    /// Gives the rows of a run their new name.
    pub fn apply(&self, run: &mut RunRecord) {
        for row in run.scenes.iter_mut().flat_map(|scene| &mut scene.rows) {
            let was = row.label();
            match (&self.old, &self.new) {
                (
                    Name::Row { structure, settings },
                    Name::Row { structure: name, settings: with },
                ) if row.structure == *structure && row.settings == *settings => {
                    (row.structure, row.settings) = (name.clone(), with.clone());
                }
                (Name::Structure(structure), Name::Structure(name))
                    if row.structure == *structure =>
                {
                    row.structure.clone_from(name);
                }
                _ => continue,
            }
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
