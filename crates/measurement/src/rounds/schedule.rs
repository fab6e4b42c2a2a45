//! In which order rows are visited: every round visits every row once, in an order of its own.
//!
//! Whatever drifts while a benchmark runs (clock frequency, other programs) then falls on all rows
//! alike instead of on those that happen to come last. Every odd round goes through the rows in the
//! reverse of the order before it: of any two rows each comes before the other in every second
//! round, so that what a row leaves behind in caches falls on all others equally often.

use statistics::random::Random;

/// The order of one round over `rows` rows of a scene.
pub fn round_order(seed: u64, scene: &str, round: usize, rows: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rows).collect();
    let even = round - round % 2;
    Random::new(seed, &format!("schedule/{scene}/{even}")).shuffle(&mut order);
    if round % 2 == 1 {
        order.reverse();
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_fixes_the_schedule() {
        assert_eq!(round_order(1, "balls", 0, 21), round_order(1, "balls", 0, 21));
        assert_ne!(round_order(1, "balls", 0, 21), round_order(2, "balls", 0, 21));
        assert_ne!(round_order(1, "balls", 0, 21), round_order(1, "balls", 1, 21));
        assert_ne!(round_order(1, "balls", 0, 21), round_order(1, "gears", 0, 21));
    }

    #[test]
    fn of_two_rows_each_is_before_the_other_equally_often() {
        let place = |order: &[usize], row| order.iter().position(|r| *r == row);
        for (a, b) in [(0, 1), (3, 20), (7, 6)] {
            let before = (0..10).filter(|&round| {
                let order = round_order(5, "tetra", round, 21);
                place(&order, a) < place(&order, b)
            });
            assert_eq!(before.count(), 5);
        }
    }

    #[test]
    fn a_round_visits_each_row_once() {
        for rows in [0, 1, 2, 21] {
            let mut order = round_order(3, "tree", 4, rows);
            order.sort_unstable();
            assert_eq!(order, (0..rows).collect::<Vec<_>>());
        }
    }
}
