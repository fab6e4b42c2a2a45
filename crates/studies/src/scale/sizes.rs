//! The numbers of primitives that sizes are asked for with.

use crate::sweep::values::Range;
use measurement::settings::sizes::Sizes;

/// Each of them, ascending: of a range `per_decade` for each factor of ten, or as near to that as
/// equal ratios between its ends allow.
pub fn targets(sizes: &Sizes, per_decade: u32) -> Vec<u64> {
    match sizes {
        Sizes::List(list) => list.clone(),
        Sizes::Range { from, to } => {
            let (from, to) = (*from as f64, *to as f64);
            let steps = ((to / from).log10() * f64::from(per_decade)).round().max(1.0);
            let range = Range { from, to, steps: steps as usize + 1, is_linear: false };
            range.whole_numbers().iter().filter_map(|n| n.parse().ok()).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_lists() {
        let targets = |text, per_decade| targets(&Sizes::parse(text).unwrap(), per_decade);
        assert_eq!(targets("1e3..1e6", 1), [1000, 10_000, 100_000, 1_000_000]);
        assert_eq!(targets("1k..100k", 2), [1000, 3162, 10_000, 31_623, 100_000]);
        assert_eq!(targets("1000..2k", 1), [1000, 2000], "both ends at least");
        assert_eq!(targets("10M,1k,1e3", 1), [1000, 10_000_000]);
        assert_eq!(targets("64", 5), [64]);
    }
}
