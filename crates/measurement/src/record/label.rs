//! Names of rows.

/// Structure and settings as printed.
pub fn label(structure: &str, settings: &str) -> String {
    format!("{structure} {settings}").trim_end().to_owned()
}

/// The same with a word where it answers batches.
pub fn with_query(label: String, answers_batches: bool) -> String {
    if answers_batches { format!("{label} (batch)") } else { label }
}
