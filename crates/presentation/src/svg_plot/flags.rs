//! Labels in a row that keep clear of each other.

/// Places near the wanted ones (which ascend), each `gap` from the next, between `low` and `high`;
/// where there is no room for that, at equal distances.
pub fn spread(wanted: &[f64], gap: f64, low: f64, high: f64) -> Vec<f64> {
    let between = wanted.len().saturating_sub(1).max(1) as f64;
    let gap = gap.min((high - low) / between);
    let rightwards = |places: &[f64], start: f64| -> Vec<f64> {
        let next = |least: &mut f64, &x: &f64| {
            let place = x.max(*least);
            *least = place + gap;
            Some(place)
        };
        places.iter().scan(start, next).collect()
    };
    let leftwards = |places: &[f64], end: f64| -> Vec<f64> {
        let next = |most: &mut f64, &x: &f64| {
            let place = x.min(*most);
            *most = place - gap;
            Some(place)
        };
        let mut out: Vec<f64> = places.iter().rev().scan(end, next).collect();
        out.reverse();
        out
    };
    // Pushed to the right and to the left, the mean of both keeps the gaps and the middle.
    let right = rightwards(wanted, f64::NEG_INFINITY);
    let left = leftwards(wanted, f64::INFINITY);
    let middle: Vec<f64> = right.iter().zip(left).map(|(r, l)| (r + l) / 2.0).collect();
    leftwards(&rightwards(&middle, low), high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_with_room_stay_and_others_move_apart() {
        assert_eq!(spread(&[10.0, 50.0], 20.0, 0.0, 100.0), [10.0, 50.0]);
        assert_eq!(spread(&[40.0, 40.0, 40.0], 10.0, 0.0, 100.0), [30.0, 40.0, 50.0]);
        assert_eq!(spread(&[0.0, 0.0], 10.0, 0.0, 100.0), [0.0, 10.0]);
        assert_eq!(spread(&[100.0, 100.0], 10.0, 0.0, 100.0), [90.0, 100.0]);
        assert!(spread(&[], 10.0, 0.0, 1.0).is_empty());
    }

    #[test]
    fn without_room_labels_are_at_equal_distances() {
        assert_eq!(spread(&[5.0; 5], 100.0, 0.0, 40.0), [0.0, 10.0, 20.0, 30.0, 40.0]);
    }
}
