//! Settings with few values, each named once for the command line, files and records.

/// A setting that has one of a few values.
pub trait Choice: Copy + PartialEq + 'static {
    /// Each value, as typed, and what it means.
    const ALL: &'static [(Self, &'static str, &'static str)];

    /// The value that is typed so.
    fn typed(text: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, name, _)| *name == text).map(|(value, ..)| *value)
    }

    fn as_typed(self) -> &'static str {
        Self::ALL.iter().find(|(value, ..)| *value == self).map_or("", |(_, name, _)| name)
    }
}

/// Such a setting in files, as typed.
pub mod as_typed {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use crate::settings::choice::Choice;

    /// Writes it.
    ///
    /// # Errors
    /// Those of the format.
    pub fn serialize<C: Choice, S: Serializer>(value: &C, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(value.as_typed())
    }

    /// Reads it.
    ///
    /// # Errors
    /// Those of the format; values that there are not.
    pub fn deserialize<'de, C: Choice, D: Deserializer<'de>>(from: D) -> Result<C, D::Error> {
        let text = String::deserialize(from)?;
        C::typed(&text).ok_or_else(|| D::Error::custom(format!("'{text}' is no value of it")))
    }
}
