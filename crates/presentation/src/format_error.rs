//! Results that no format takes.

/// Results could not be turned into text.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("cannot write the results as {format}: {message}")]
pub struct FormatError {
    pub format: &'static str,
    /// What the library said.
    pub message: String,
}
