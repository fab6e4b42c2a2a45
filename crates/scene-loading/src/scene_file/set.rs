//! JSON scene sets (`scenes/sets/*.json`): named lists of scenes.

use std::path::Path;

use serde::Deserialize;
use serde_json::{Map, Value};

use crate::error::{FilePlace, LoadError};
use crate::scene_file::json::{check_name, from_json};

/// A set file. Keys that are not listed here are errors.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSet {
    /// Name on the command line; the same as the file's stem.
    pub name: String,
    /// One sentence: what the set is for.
    pub title: String,
    /// The scenes in order: generator specifications, names of scene files, and files relative to
    /// this one. Sets do not nest.
    pub scenes: Vec<String>,
    /// Options of a run of the set that are not the usual ones, by their long names. What they mean
    /// is the program's business.
    #[serde(default)]
    pub run: Map<String, Value>,
    /// The same of a quick run, before those of `run`.
    #[serde(default)]
    pub quick: Map<String, Value>,
    /// Thresholds of `rtbench check` for some rows and kinds of rays.
    #[serde(default)]
    pub check: Vec<SetThreshold>,
}

/// An entry of a set's `check`, as written.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SetThreshold {
    /// A structure or a row, as `-s` takes them; none for all rows.
    pub row: Option<String>,
    /// `build`, `trace` or a kind of rays; none for build and trace.
    pub of: Option<String>,
    pub time_threshold: Option<String>,
    pub instruction_threshold: Option<String>,
}

impl SceneSet {
    /// Parses a set file. `path` appears in errors; its stem must be the name.
    ///
    /// # Errors
    /// [`LoadError::Json`] with line and column; [`LoadError::Syntax`] for a wrong name or an
    /// empty list.
    pub fn parse(path: &Path, text: &str) -> Result<Self, LoadError> {
        let set: Self = from_json(path, text)?;
        check_name(path, &set.name)?;
        if set.scenes.is_empty() {
            return Err(LoadError::syntax(FilePlace::file(path), "[]", "at least one scene"));
        }
        Ok(set)
    }
}
