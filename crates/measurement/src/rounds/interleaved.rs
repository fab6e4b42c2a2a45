//! The loop of all timing: rounds, each of which visits every row once in a seeded order of its own
//! (see [`crate::rounds::schedule`]). What drifts while it runs falls on all rows alike.

use crate::system::clock::Clock;
use statistics::random::Random;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Visit {
    /// Round, from 0.
    pub round: usize,
    /// Position within the round, from 0.
    pub position: usize,
    pub row: usize,
}

/// Visits all rows, round by round from `first` on, as long as `goes_on` says so of the round to
/// come. Orders are those of the seed and of what is measured.
pub fn interleaved(
    first: usize,
    rows: usize,
    seed: u64,
    what: &str,
    mut goes_on: impl FnMut(usize) -> bool,
    mut visit: impl FnMut(Visit),
) {
    let mut round = first;
    while goes_on(round) {
        for (position, row) in round_order(seed, what, round, rows).into_iter().enumerate() {
            visit(Visit { round, position, row });
        }
        round += 1;
    }
}

/// Seconds of pieces of work, each in every round, as long as `goes_on` says so. Every piece is run
/// once before, untimed: the first run finds neither memory nor caches.
pub fn timed(
    works: &mut [Box<dyn FnMut() + '_>],
    seed: u64,
    what: &str,
    clock: &dyn Clock,
    goes_on: impl FnMut(usize) -> bool,
) -> Vec<Vec<f64>> {
    works.iter_mut().for_each(|work| work());
    let mut seconds = vec![Vec::new(); works.len()];
    interleaved(0, works.len(), seed, what, goes_on, |Visit { row, .. }| {
        if let (Some(work), Some(seconds)) = (works.get_mut(row), seconds.get_mut(row)) {
            let start = clock.now();
            work();
            seconds.push(clock.seconds_since(start));
        }
    });
    seconds
}

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
    use crate::system::clock::SteppingClock;
    use std::cell::RefCell;
    use std::time::Duration;

    #[test]
    fn every_round_visits_every_row_once_in_its_own_order() {
        let mut visits = Vec::new();
        interleaved(0, 5, 7, "tetra", |round| round < 3, |visit| visits.push(visit));
        assert_eq!(visits.len(), 15);
        let of = |round| {
            let rows = visits.iter().filter(|v| v.round == round).map(|v| v.row);
            rows.collect::<Vec<_>>()
        };
        assert_eq!(of(1), round_order(7, "tetra", 1, 5));
        assert_ne!(of(1), of(2));
        assert!(visits.chunks(5).all(|c| c.iter().map(|v| v.position).eq(0..5)));
    }

    #[test]
    fn timed_work_is_run_once_more_to_warm_up() {
        let clock = SteppingClock::new(Duration::from_millis(5));
        let runs = RefCell::new([0, 0]);
        let mut works: Vec<Box<dyn FnMut() + '_>> =
            vec![Box::new(|| runs.borrow_mut()[0] += 1), Box::new(|| runs.borrow_mut()[1] += 1)];
        let seconds = timed(&mut works, 1, "x", &clock, |round| round < 3);
        drop(works);
        assert_eq!(seconds, vec![vec![0.005; 3]; 2]);
        assert_eq!(*runs.borrow(), [4, 4]);
    }

    #[test]
    fn a_seed_fixes_the_schedule() {
        assert_eq!(round_order(1, "balls", 0, 21), round_order(1, "balls", 0, 21));
        assert_ne!(round_order(1, "balls", 0, 21), round_order(2, "balls", 0, 21));
        assert_ne!(round_order(1, "balls", 0, 21), round_order(1, "balls", 1, 21));
        assert_ne!(round_order(1, "balls", 0, 21), round_order(1, "gears", 0, 21));
    }

    #[test]
    fn each_of_two_rows_precedes_the_other_equally_often() {
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
