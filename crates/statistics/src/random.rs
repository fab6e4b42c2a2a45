//! The one source of randomness: SplitMix64, so that a seed means the same on every machine.

/// A seeded stream of pseudo-random numbers (Steele, Lea, Flood 2014).
#[derive(Debug, Clone)]
pub struct Random {
    state: u64,
}

impl Random {
    /// A stream for a seed and what it is used for: different uses get unrelated streams.
    pub fn new(seed: u64, purpose: &str) -> Self {
        // FNV-1a of the purpose, mixed with the seed.
        let hash = purpose.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| {
            (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3)
        });
        let mut random = Self { state: seed ^ hash };
        random.next_u64();
        random
    }

    /// The next 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`, or 0 when `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.next_u64()) * n as u128) >> 64) as usize
    }

    /// Fisher-Yates.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }

    /// `count` different indices below `n` in rising order; all of them when `count >= n`.
    pub fn sample(&mut self, n: usize, count: usize) -> Vec<usize> {
        if count >= n {
            return (0..n).collect();
        }
        // Floyd's algorithm.
        let mut chosen = std::collections::BTreeSet::new();
        for j in n - count..n {
            let i = self.below(j + 1);
            if !chosen.insert(i) {
                chosen.insert(j);
            }
        }
        chosen.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn same_seed_same_numbers() {
        let stream = |seed, purpose| {
            let mut r = Random::new(seed, purpose);
            [r.next_u64(), r.next_u64()]
        };
        assert_eq!(stream(7, "a"), stream(7, "a"));
        assert_ne!(stream(7, "a"), stream(8, "a"));
        assert_ne!(stream(7, "a"), stream(7, "b"));
    }

    #[test]
    fn samples_are_distinct_sorted_and_in_range() {
        let mut r = Random::new(1, "sample");
        for (n, count) in [(0, 5), (1, 1), (10, 3), (10, 10), (10, 20), (1000, 512)] {
            let s = r.sample(n, count);
            assert_eq!(s.len(), n.min(count));
            assert!(s.windows(2).all(|w| w[0] < w[1]) && s.iter().all(|&i| i < n));
        }
    }

    #[test]
    fn below_covers_its_range() {
        let mut r = Random::new(1, "below");
        let mut seen = [0; 5];
        for _ in 0..5000 {
            seen[r.below(5)] += 1;
        }
        assert!(seen.iter().all(|&n| n > 800), "{seen:?}");
        assert_eq!(r.below(0), 0);
    }
}
