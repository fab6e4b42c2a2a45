//! The numbers of primitives that sizes are asked for with: `1e3..1e7` or `1k,20k,1M`.

use crate::sweep::values::Range;
use measurement::settings::quantity;

const EXPECTED: &str = "expected FROM..TO, like 1e3..1e7, or counts with commas: 1k,20k,1M";

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Sizes {
    /// From one to another, both included.
    Range { from: u64, to: u64 },
    /// These, in ascending order, each once.
    List(Vec<u64>),
}

impl Sizes {
    pub fn parse(text: &str) -> Result<Self, String> {
        let count = |text: &str| {
            let count = quantity::parse(text.trim()).filter(|n| *n > 0);
            count.ok_or_else(|| format!("'{text}' is not a count above 0; {EXPECTED}"))
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

    /// Each of them, ascending: of a range one for each factor of ten, or as near to that as equal
    /// ratios between its ends allow.
    pub fn targets(&self) -> Vec<u64> {
        match self {
            Self::List(list) => list.clone(),
            Self::Range { from, to } => {
                let (from, to) = (*from as f64, *to as f64);
                let steps = (to / from).log10().round().max(1.0);
                let range = Range { from, to, steps: steps as usize + 1 };
                range.whole_numbers().iter().filter_map(|n| n.parse().ok()).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_lists() {
        let targets = |text| Sizes::parse(text).unwrap().targets();
        assert_eq!(targets("1e3..1e6"), [1000, 10_000, 100_000, 1_000_000]);
        assert_eq!(targets("1k..50k"), [1000, 7071, 50_000], "equal ratios");
        assert_eq!(targets("1000..2k"), [1000, 2000], "both ends at least");
        assert_eq!(targets("10M,1k,1e3"), [1000, 10_000_000]);
        assert_eq!(targets("64"), [64]);
    }

    #[test]
    fn invalid_sizes_are_errors_that_show_valid_ones() {
        for bad in ["", "..", "1e3..", "1e6..1e3", "5..5", "0,1", "-1", "1.5", "1k;2k", "x..1e3"] {
            let error = Sizes::parse(bad).unwrap_err();
            assert!(error.contains("1e3..1e7"), "{bad}: {error}");
        }
    }
}
