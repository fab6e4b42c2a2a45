//! `rtbench.toml`: sets of scenes, defaults of `run`, thresholds of `check`.
//!
//! ```toml
//! [sets]
//! nightly = ["spd", "scenes/hall.obj"]      # names, sets, and files beside this one
//!
//! [run]                                     # options of `run` by their long names
//! scenes = ["nightly"]
//! rounds = "15"
//! export-csv = "out.csv"
//!
//! [check]                                   # thresholds: see `gate::thresholds`
//! time = 0.15
//! ```
//!
//! The file of `--config`, or the nearest `rtbench.toml` in the folder of the process or above.
//! What it says can always be said otherwise on the command line. Whatever is not known in it is an
//! error that names the line.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::{Spanned, Value};

use crate::gate::thresholds::Thresholds;
use measurement::plan::error::PlanError;
use measurement::settings::suggest;

/// The file's name.
pub const NAME: &str = "rtbench.toml";

/// The most bytes of it that are read.
const MAX_BYTES: u64 = 1 << 20;

/// Why a configuration cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The system refused.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// It is too large to be one.
    #[error("{}: more than {MAX_BYTES} bytes, too large for a configuration", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// Something in it is not valid.
    #[error("{}: line {line}: {message}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong, and what is valid.
        message: String,
    },
    /// The options of a set of scenes are not valid.
    #[error("scenes/sets/{set}.json: run: {message}")]
    InSet {
        /// The set.
        set: String,
        /// What is wrong, and what is valid.
        message: String,
    },
    /// It names something that is not there.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// A table, its keys and values with their places.
pub(super) type Table = BTreeMap<Spanned<String>, Spanned<Value>>;

/// The tables of the file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Tables {
    #[serde(default)]
    pub(super) sets: BTreeMap<Spanned<String>, Spanned<Vec<String>>>,
    #[serde(default)]
    pub(super) run: Table,
    #[serde(default)]
    check: Thresholds,
}

/// A configuration that was read.
#[derive(Debug)]
pub struct Config {
    pub(super) path: PathBuf,
    text: String,
    pub(super) tables: Tables,
}

impl Config {
    /// The file named, or the nearest one from `folder` upwards; none where there is none.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn find(named: Option<&Path>, folder: Option<&Path>) -> Result<Option<Self>, ConfigError> {
        let above = || folder?.ancestors().map(|f| f.join(NAME)).find(|path| path.is_file());
        match named.map(Path::to_owned).or_else(above) {
            Some(path) => Self::read(&path).map(Some),
            None => Ok(None),
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let fail = |source| ConfigError::Io { path: path.to_owned(), source };
        let found = fs::metadata(path).map_err(fail)?;
        if !found.is_file() {
            return Err(fail(io::Error::other("not a regular file")));
        }
        if found.len() > MAX_BYTES {
            return Err(ConfigError::TooLarge { path: path.to_owned() });
        }
        let text = fs::read_to_string(path).map_err(fail)?;
        let tables = parse(path, &text)?;
        let config = Self { path: path.to_owned(), text, tables };
        config.validate_run()?;
        Ok(config)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The table `[check]`; the defaults where there is none.
    pub fn thresholds(&self) -> Thresholds {
        self.tables.check
    }

    /// An error at a place of the file.
    pub(super) fn invalid(&self, place: Range<usize>, message: impl Into<String>) -> ConfigError {
        let (path, line) = (self.path.clone(), line_of(&self.text, place.start));
        ConfigError::Invalid { path, line, message: message.into() }
    }
}

/// Reads a type from the text of a file.
fn parse<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, ConfigError> {
    toml::from_str(text).map_err(|e| {
        let line = line_of(text, e.span().map_or(0, |span| span.start));
        ConfigError::Invalid { path: path.to_owned(), line, message: explained(e.message()) }
    })
}

/// The line of a byte, counted from 1.
fn line_of(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|b| *b == b'\n').count()
}

/// A message of the library; of unknown keys with a hint.
fn explained(message: &str) -> String {
    let mut names = message.split('`').skip(1).step_by(2);
    match names.next() {
        Some(typed) if message.starts_with("unknown field") => {
            format!("{message}{}", suggest::hint(typed, names))
        }
        _ => message.to_owned(),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::config) fn read(text: &str) -> Result<Config, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(NAME);
        fs::write(&path, text).unwrap();
        Config::read(&path).map_err(|e| e.to_string())
    }

    #[test]
    fn what_is_not_known_is_an_error_that_names_the_line() {
        for (text, said) in [
            ("[run]\nrounds = 5\n\n[chekc]\n", "line 4: unknown field `chekc`"),
            ("[chekc]\n", "(did you mean 'check'?)"),
            ("[run]\nrunds = 5\n", "line 2: unknown option 'runds' (did you mean 'rounds'?)"),
            ("[run]\nrounds = 0\n", "line 2: "),
            ("[run]\nrounds = 1979-05-27\n", "line 2: "),
            ("[run]\nquick = \"yes\"\n", "line 2: quick: expected true or false"),
            ("[run]\nresume = \"x\"\n", "line 2: unknown option 'resume'"),
            ("[sets]\n\na = \"tetra\"\n", "line 3: "),
            ("[sets]\na = []\n", "line 2: the set 'a' has no scenes"),
            ("[sets", "line 1: "),
            ("[run]\nrounds = 5\nrounds = 6\n", "line 3: duplicate key"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(NAME) && error.contains(said), "{text}: {error}");
        }
    }

    #[test]
    fn the_nearest_file_above_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("a/b");
        fs::create_dir_all(&below).unwrap();
        fs::write(folder.path().join(NAME), "[run]\nseed = 7\n").unwrap();
        let found = Config::find(None, Some(&below)).unwrap().unwrap();
        assert_eq!(found.path(), folder.path().join(NAME));
        fs::write(folder.path().join("a").join(NAME), "").unwrap();
        let found = Config::find(None, Some(&below)).unwrap().unwrap();
        assert_eq!(found.path(), folder.path().join("a").join(NAME));
        assert!(Config::find(None, None).unwrap().is_none());
        let missing = Config::find(Some(Path::new("/nowhere/x.toml")), None).unwrap_err();
        assert!(missing.to_string().starts_with("cannot read /nowhere/x.toml"), "{missing}");
    }

    #[test]
    fn thresholds_are_read() {
        let config = read("[sets]\na = [\"tetra\"]\n[check]\ntime = 0.05\n").unwrap();
        assert_eq!(config.thresholds(), Thresholds { time: 0.05, ..Thresholds::default() });
        assert_eq!(read("").unwrap().thresholds(), Thresholds::default());
        let error = read("\n[check]\ntmie = 1\n").unwrap_err();
        assert!(error.contains("line 3: unknown field `tmie`"), "{error}");
        assert!(error.contains("(did you mean 'time'?)"), "{error}");
    }
}
