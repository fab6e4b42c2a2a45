//! Settings with few values, each named once for the command line, files and records.

/// A setting that has one of a few values.
pub trait Choice: Copy + PartialEq + 'static {
    /// Each value, as typed, and what it means.
    const ALL: &'static [(Self, &'static str, &'static str)];

    /// The value that is typed so.
    fn typed(text: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, name, _)| *name == text).map(|(value, ..)| *value)
    }

    /// As typed.
    fn as_typed(self) -> &'static str {
        Self::ALL.iter().find(|(value, ..)| *value == self).map_or("", |(_, name, _)| name)
    }
}
