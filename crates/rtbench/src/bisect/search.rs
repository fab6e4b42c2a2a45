//! Halving what lies between a good commit and a bad one, around those that say nothing.

use crate::bisect::judge::Verdict;

/// Where the first bad one is. Places count from the good one, which is 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// The last one known to be good.
    pub good: usize,
    /// The first one known to be bad.
    pub bad: usize,
    /// Those between them, which were skipped: any of them, or the bad one, may be the first.
    pub skipped: Vec<usize>,
}

/// Asks as few as it can of those between the good one, 0, and the bad one, `bad`.
///
/// # Errors
/// Those of `judge`.
pub fn search<E>(
    bad: usize,
    mut judge: impl FnMut(usize) -> Result<Verdict, E>,
) -> Result<Found, E> {
    let mut found = Found { good: 0, bad, skipped: Vec::new() };
    loop {
        let middle = found.good.midpoint(found.bad);
        let open = (found.good + 1..found.bad).filter(|place| !found.skipped.contains(place));
        let Some(next) = open.min_by_key(|place| place.abs_diff(middle)) else {
            found.skipped.retain(|place| (found.good..found.bad).contains(place));
            found.skipped.sort_unstable();
            return Ok(found);
        };
        match judge(next)? {
            Verdict::Good => found.good = next,
            Verdict::Bad => found.bad = next,
            Verdict::Skip => found.skipped.push(next),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(bad: usize, first: usize, skipped: &[usize]) -> (Found, usize) {
        let mut asked = Vec::new();
        let found = search::<()>(bad, |place| {
            assert!(!asked.contains(&place), "asked once");
            asked.push(place);
            Ok(match place {
                _ if skipped.contains(&place) => Verdict::Skip,
                _ if place < first => Verdict::Good,
                _ => Verdict::Bad,
            })
        });
        (found.unwrap(), asked.len())
    }

    #[test]
    fn every_planted_place_is_found_with_few_questions() {
        for bad in 1..40 {
            for first in 1..=bad {
                let (found, asked) = found(bad, first, &[]);
                assert_eq!((found.good, found.bad, found.skipped.len()), (first - 1, first, 0));
                assert!(asked <= bad.ilog2() as usize + 1, "{bad} {first}: {asked}");
            }
        }
    }

    #[test]
    fn what_is_skipped_leaves_candidates() {
        let (found, _) = found(10, 6, &[5, 2]);
        assert_eq!(found, Found { good: 4, bad: 6, skipped: vec![5] });
        let (all, _) = super::tests::found(4, 3, &[1, 2, 3]);
        assert_eq!(all, Found { good: 0, bad: 4, skipped: vec![1, 2, 3] });
    }

    #[test]
    fn errors_end_it() {
        assert_eq!(search(10, |_| Err("no")), Err("no"));
    }
}
