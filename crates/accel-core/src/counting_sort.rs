//! Numbers sorted by some of their bits in linear time.

use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use crate::parallel::map;

pub(crate) const DIGIT_BITS: u32 = 12;

/// The numbers in the order of their bits from `lowest` on, two digits of them; where these are
/// alike, as they lie. So many parts of them are counted and moved at once.
pub(crate) fn by_two_digits(numbers: Vec<u64>, lowest: u32, parts: usize) -> Vec<u64> {
    by_digit(by_digit(numbers, lowest, parts), lowest + DIGIT_BITS, parts)
}

fn by_digit(numbers: Vec<u64>, lowest: u32, parts: usize) -> Vec<u64> {
    let digit = |number: u64| (number >> lowest) as usize & ((1 << DIGIT_BITS) - 1);
    let counted = |numbers: &[u64]| {
        let mut counts = [0u32; 1 << DIGIT_BITS];
        numbers.iter().for_each(|&number| counts[digit(number)] += 1);
        counts
    };
    let size = numbers.len().div_ceil(parts).max(1);
    let mut places = map(numbers.chunks(size), &counted);
    // of each digit those of the first part come first
    let mut sum = 0;
    for digit in 0..1 << DIGIT_BITS {
        for places in &mut places {
            sum += std::mem::replace(&mut places[digit], sum);
        }
    }
    let sorted: Vec<AtomicU64> = bytemuck::zeroed_vec(numbers.len());
    map(numbers.chunks(size).zip(&mut places), &|(numbers, places)| {
        for &number in numbers {
            let place = &mut places[digit(number)];
            sorted[*place as usize].store(number, Relaxed);
            *place += 1;
        }
    });
    sorted.into_iter().map(AtomicU64::into_inner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_sorted_by_these_bits_alone() {
        let numbers: Vec<u64> =
            (0..20_000).map(|i: u64| i.wrapping_mul(0x9e37_79b9_97f4_a7c1)).collect();
        for (lowest, parts) in [(0, 1), (7, 3), (40, 8), (40, 20_001)] {
            let mut expected = numbers.clone();
            expected.sort_by_key(|number| number >> lowest & 0xff_ffff);
            assert!(by_two_digits(numbers.clone(), lowest, parts) == expected, "{lowest} {parts}");
        }
        assert!(by_two_digits(Vec::new(), 0, 2).is_empty());
    }
}
