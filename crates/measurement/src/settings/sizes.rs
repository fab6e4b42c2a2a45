//! The sizes asked for, as typed: `1e3..1e7` or `1k,20k,1M`.

use serde::{Deserialize, Serialize};

use crate::settings::quantity;

/// What is valid.
const EXPECTED: &str = "expected FROM..TO, like 1e3..1e7, or counts with commas: 1k,20k,1M";

/// Numbers of primitives; in files as typed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Sizes {
    /// From one to another, both included.
    Range {
        /// Least.
        from: u64,
        /// Most.
        to: u64,
    },
    /// These, in ascending order, each once.
    List(Vec<u64>),
}

impl Sizes {
    /// Parses them for clap.
    ///
    /// # Errors
    /// A message that says what is valid.
    pub fn parse(text: &str) -> Result<Self, String> {
        let count = |text: &str| {
            let count = quantity::parse(text.trim()).filter(|n| *n > 0);
            count.ok_or_else(|| format!("'{text}' is no count above 0; {EXPECTED}"))
        };
        if let Some((from, to)) = text.split_once("..") {
            let (from, to) = (count(from)?, count(to)?);
            if from >= to {
                return Err(format!("{from} is not below {to}; {EXPECTED}"));
            }
            return Ok(Self::Range { from, to });
        }
        let mut list = text.split(',').map(count).collect::<Result<Vec<u64>, _>>()?;
        list.sort_unstable();
        list.dedup();
        Ok(Self::List(list))
    }
}

impl TryFrom<String> for Sizes {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Self::parse(&text)
    }
}

impl From<Sizes> for String {
    fn from(sizes: Sizes) -> Self {
        match sizes {
            Sizes::Range { from, to } => format!("{from}..{to}"),
            Sizes::List(list) => list.iter().map(u64::to_string).collect::<Vec<_>>().join(","),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_written_as_they_can_be_typed() {
        for (text, written) in [("1k..100k", "1000..100000"), ("10M,1k,1e3", "1000,10000000")] {
            let sizes = Sizes::parse(text).unwrap();
            assert_eq!(String::from(sizes.clone()), written);
            assert_eq!(Sizes::parse(written), Ok(sizes));
        }
    }

    #[test]
    fn what_is_no_size_is_an_error_that_says_what_is() {
        for bad in ["", "..", "1e3..", "1e6..1e3", "5..5", "0,1", "-1", "1.5", "1k;2k", "x..1e3"] {
            let error = Sizes::parse(bad).unwrap_err();
            assert!(error.contains("1e3..1e7"), "{bad}: {error}");
        }
    }
}
