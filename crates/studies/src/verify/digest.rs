//! A number that stands for answers: the same for the same answers, whatever the number of threads,
//! and to be compared between builds for other instruction sets.

use accel_core::{Hit, Scalar};

/// The answers of one round, in order; or those of several, in any.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Digest(pub u64);

impl Digest {
    /// Digest of one round; its number distinguishes equal answers to other rays.
    pub fn of_round(self, number: u64) -> Self {
        Self(mixed(self.0 ^ mixed(number)))
    }

    /// Goes on with a closest hit. Zeros of both signs are the same parameter.
    pub fn hit<S: Scalar>(&mut self, hit: &Hit<S>) {
        let t = if hit.is_hit() { (hit.t.to_f64() + 0.0).to_bits() } else { 0 };
        self.word(t);
        self.word(u64::from(hit.id));
    }

    /// Goes on with an occlusion.
    pub fn blocked(&mut self, blocked: bool) {
        self.word(u64::from(blocked));
    }

    /// Goes on with any word.
    pub fn word(&mut self, word: u64) {
        self.0 = mixed(self.0.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ word);
    }

    /// Puts rounds together; their order does not matter.
    pub fn add(&mut self, other: Self) {
        self.0 = self.0.wrapping_add(other.0);
    }
}

/// The finalizer of SplitMix64.
fn mixed(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(hits: &[(f32, u32)]) -> Digest {
        let mut digest = Digest::default();
        hits.iter().for_each(|&(t, id)| digest.hit(&Hit { t, id }));
        digest
    }

    #[test]
    fn digests_depend_on_every_bit_but_not_on_the_order_of_rounds() {
        let hits = [(1.0, 3), (2.0, 4)];
        assert_eq!(of(&hits), of(&hits));
        let next = 2.0_f32.next_up();
        for other in [[(1.0, 3), (next, 4)], [(1.0, 3), (2.0, 5)], [(2.0, 4), (1.0, 3)]] {
            assert_ne!(of(&hits), of(&other), "{other:?}");
        }
        assert_eq!(of(&[(0.0, 1)]), of(&[(-0.0, 1)]));
        let mut sums = [Digest::default(); 3];
        for (sum, order) in sums.iter_mut().zip([[0, 1], [1, 0], [0, 0]]) {
            order.into_iter().for_each(|number| sum.add(of(&hits).of_round(number)));
        }
        assert!(sums[0] == sums[1] && sums[0] != sums[2]);
    }
}
