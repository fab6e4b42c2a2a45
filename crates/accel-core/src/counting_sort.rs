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
    let mut ends = map(numbers.chunks(size), &counted);
    turn_parts_into_ends(&mut ends);
    let sorted: Vec<AtomicU64> = bytemuck::zeroed_vec(numbers.len());
    map(numbers.chunks(size).zip(&mut ends), &|(numbers, ends)| {
        for &number in numbers.iter().rev() {
            let end = &mut ends[digit(number)];
            *end -= 1;
            sorted[*end as usize].store(number, Relaxed);
        }
    });
    sorted.into_iter().map(AtomicU64::into_inner).collect()
}

/// Turns the counts of each part into where its numbers end in the one array: cell after cell (or
/// digit), in each cell part after part.
pub(crate) fn turn_parts_into_ends<C: AsMut<[u32]>>(counts: &mut [C]) {
    // as many stretches of cells as parts, each with the counts of all parts
    let cells = counts.first_mut().map_or(0, |counts| counts.as_mut().len());
    let length = cells.div_ceil(counts.len().max(1)).max(1);
    let mut stretches: Vec<Vec<&mut [u32]>> = (0..cells.div_ceil(length)).map(|_| vec![]).collect();
    for part in counts {
        for (stretch, counts) in stretches.iter_mut().zip(part.as_mut().chunks_mut(length)) {
            stretch.push(counts);
        }
    }
    let sums: Vec<u32> =
        map(&stretches, &|parts| parts.iter().map(|counts| counts.iter().sum::<u32>()).sum());
    let before = sums.iter().scan(0, |sum, n| {
        let before = *sum;
        *sum += n;
        Some(before)
    });
    let before: Vec<u32> = before.collect();
    map(stretches.into_iter().zip(before), &|(mut parts, mut sum)| {
        let length = parts.first().map_or(0, |counts| counts.len());
        for cell in 0..length {
            for counts in &mut parts {
                sum += counts[cell];
                counts[cell] = sum;
            }
        }
    });
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
