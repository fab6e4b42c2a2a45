//! Invalid requests on the command line, or in a file with the same contents.

use accel_core::params::ParamError;

use crate::scenes::LoadError;
use crate::settings::choice;

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    #[error("{error}{hint}")]
    Param {
        error: ParamError,
        /// ` (did you mean ...?)` or empty.
        hint: String,
    },
    #[error("cannot read '{text}': expected {expected}")]
    Malformed { text: String, expected: &'static str },
    #[error("--set names {structure}, which this run does not measure; add it to -s")]
    OverrideWithoutRow { structure: &'static str },
    #[error("unknown {what} '{name}'{hint}; valid: {valid}")]
    UnknownName {
        what: &'static str,
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    #[error("{what}: {value}, expected a number from 1 to {most}")]
    OutOfRange { what: &'static str, value: u64, most: u64 },
    #[error("there are no structures to measure")]
    NoRows,
    /// What else makes no sense, in words.
    #[error("{0}")]
    Invalid(String),
    #[error(transparent)]
    Scene(#[from] LoadError),
}

impl PlanError {
    /// `what` of this name, which is not among the `valid` ones.
    pub fn unknown<'n>(
        what: &'static str,
        name: &str,
        valid: impl IntoIterator<Item = &'n str>,
    ) -> Self {
        let valid: Vec<&str> = valid.into_iter().collect();
        let hint = choice::hint(name, valid.iter().copied());
        Self::UnknownName { what, name: name.to_owned(), hint, valid: valid.join(", ") }
    }
}

/// What is asked for by name, each once and in the order of `all`; all when nothing is.
///
/// # Errors
/// [`PlanError::UnknownName`] for the first name that nothing has.
pub fn chosen<T: Clone>(
    what: &'static str,
    asked: &[String],
    all: &[T],
    name: impl Fn(&T) -> &str,
) -> Result<Vec<T>, PlanError> {
    if let Some(asked) = asked.iter().find(|asked| all.iter().all(|item| name(item) != **asked)) {
        return Err(PlanError::unknown(what, asked, all.iter().map(&name)));
    }
    let is_asked = |item: &&T| asked.is_empty() || asked.iter().any(|asked| asked == name(item));
    Ok(all.iter().filter(is_asked).cloned().collect())
}
