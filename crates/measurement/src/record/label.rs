//! What rows are called.

/// Structure and settings as printed.
pub fn label(structure: &str, settings: &str) -> String {
    format!("{structure} {settings}").trim_end().to_owned()
}
