//! Settings with few values, each named once for the command line, files and records; the nearest
//! name to one that is not there.

/// A setting that has one of a few values.
pub trait Choice: Copy + PartialEq + 'static {
    /// Each value, as typed, and what it means.
    const ALL: &'static [(Self, &'static str, &'static str)];

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

    pub fn serialize<C: Choice, S: Serializer>(value: &C, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(value.as_typed())
    }

    pub fn deserialize<'de, C: Choice, D: Deserializer<'de>>(from: D) -> Result<C, D::Error> {
        let text = String::deserialize(from)?;
        C::typed(&text).ok_or_else(|| D::Error::custom(format!("'{text}' is not a valid value")))
    }
}

/// The valid name nearest to what was typed, when one is near enough to be meant.
pub fn nearest<'n>(typed: &str, valid: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let typed = typed.to_lowercase();
    valid
        .into_iter()
        .map(|name| {
            let prefix = typed.len() >= 3 && (name.starts_with(&typed) || name.contains(&typed));
            // Jaro does not see that two letters of a short name changed places; of lengths (in
            // bytes) that differ by more than a letter, one slip makes nothing
            let slip = typed.len() >= 3
                && typed.len().abs_diff(name.len()) <= 4
                && strsim::damerau_levenshtein(&typed, name) == 1;
            let score = strsim::jaro_winkler(&typed, name).max(if slip { 0.9 } else { 0.0 });
            (if prefix { score.max(0.95) } else { score }, name)
        })
        .filter(|(score, _)| *score >= 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// The same as a part of a message: ` (did you mean 'x'?)` or nothing.
pub fn hint<'n>(typed: &str, valid: impl IntoIterator<Item = &'n str>) -> String {
    nearest(typed, valid).map(|name| format!(" (did you mean '{name}'?)")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 3] = ["uniform-grid", "obvhs-bvh2", "obvhs-cwbvh"];

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        assert_eq!(nearest("unifrom-grid", NAMES), Some("uniform-grid"));
        assert_eq!(nearest("grid", NAMES), Some("uniform-grid"));
        assert_eq!(nearest("OBVHS-bvh", NAMES), Some("obvhs-bvh2"));
        assert_eq!(nearest("zzz", NAMES), None);
        assert_eq!(nearest("rnu", ["run", "render"]), Some("run"));
        assert_eq!(nearest("ru", ["fur"]), None);
        assert_eq!(hint("uniform", NAMES), " (did you mean 'uniform-grid'?)");
        assert_eq!(hint("", NAMES), "");
    }
}
