//! Numbers sorted by some of their bits in linear time.

pub(crate) const DIGIT_BITS: u32 = 12;

/// The numbers in the order of their bits from `lowest` on, two digits of them; where these are
/// alike, as they lie.
pub(crate) fn by_two_digits(numbers: Vec<u64>, lowest: u32) -> Vec<u64> {
    by_digit(by_digit(numbers, lowest), lowest + DIGIT_BITS)
}

fn by_digit(numbers: Vec<u64>, lowest: u32) -> Vec<u64> {
    let digit = |number: u64| (number >> lowest) as usize & ((1 << DIGIT_BITS) - 1);
    let mut places = [0u32; 1 << DIGIT_BITS];
    numbers.iter().for_each(|&number| places[digit(number)] += 1);
    let mut sum = 0;
    for place in &mut places {
        sum += std::mem::replace(place, sum);
    }
    let mut sorted = vec![0; numbers.len()];
    for number in numbers {
        let place = &mut places[digit(number)];
        sorted[*place as usize] = number;
        *place += 1;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_sorted_by_these_bits_alone() {
        let numbers: Vec<u64> =
            (0..20_000).map(|i: u64| i.wrapping_mul(0x9e37_79b9_97f4_a7c1)).collect();
        for lowest in [0, 7, 40] {
            let mut expected = numbers.clone();
            expected.sort_by_key(|number| number >> lowest & 0xff_ffff);
            assert!(by_two_digits(numbers.clone(), lowest) == expected, "{lowest}");
        }
        assert!(by_two_digits(Vec::new(), 0).is_empty());
    }
}
