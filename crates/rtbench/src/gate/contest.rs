//! Programs measured in turns: an old one, a new one, and a copy of the new one's file.
//!
//! Each turn is a process of each, so that what drifts while the job runs falls on all of them, and where
//! code and memory happen to lie is drawn anew in each process instead of once for all rounds. The
//! orders of two turns are one another's reverse: of any two programs each is first equally often. What
//! the copy differs by is the floor: no smaller difference is claimed.

use std::collections::BTreeMap;
use std::time::Duration;

use serde::Serialize;

use measurement::record::FloorRecord;
use measurement::rounds::schedule::round_order;
use measurement::system::clock::Clock;
use measurement::system::progress::Progress;
use statistics::estimate::median;

/// Rounds of a baseline and of a check where nothing is said. The rank test of 15 against 15 can
/// be significant among thousands of rows; that of the 5 of `run` cannot even be among ten.
pub const ROUNDS: u32 = 15;

/// Turns within a time budget, at the least: fewer could not be significant.
const FEWEST: u32 = 9;

/// Which of the three programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    /// The older.
    Old,
    /// The newer.
    New,
    /// A copy of the newer.
    Copy,
}

/// In the order of [`PairedTimes::times`].
const CONTENDERS: [Contender; 3] = [Contender::Old, Contender::New, Contender::Copy];

/// A time that a process gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    /// What was timed.
    pub key: Key,
    /// How long it took.
    pub seconds: f64,
}

/// What is timed.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Key {
    /// Scene; empty where there is none.
    pub scene: String,
    /// Structure and settings, or the name of a line.
    pub row: String,
    /// `build`, `trace`, or `time` of a line.
    pub quantity: &'static str,
}

/// A row with its scene, where it has one.
pub fn place(scene: &str, row: &str) -> String {
    match scene.is_empty() {
        true => row.to_owned(),
        false => format!("{scene}: {row}"),
    }
}

/// The times of all turns.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairedTimes {
    /// What was timed.
    #[serde(flatten)]
    pub key: Key,
    /// Seconds of the old program, the new one, and the new one's copy, a turn each.
    pub times: Vec<[f64; 3]>,
}

/// How many turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// Turns; none asks for the default.
    pub rounds: Option<u32>,
    /// Time for all of them, where no number is said.
    pub time_budget: Option<Duration>,
    /// Seed of the orders.
    pub seed: u64,
}

impl Pace {
    /// Turns that will be made, as far as is known.
    pub fn expected(&self) -> u32 {
        self.rounds.unwrap_or(ROUNDS)
    }

    fn goes_on(&self, round: u32, elapsed: Duration) -> bool {
        match self.time_budget {
            Some(budget) => round < FEWEST || elapsed < budget,
            None => round < self.expected(),
        }
    }

    /// Asks all three programs in turns; what one of them does not time in a turn is left out of it.
    ///
    /// # Errors
    /// Those of `ask`.
    pub fn take_turns<E>(
        &self,
        clock: &dyn Clock,
        progress: &Progress,
        mut ask: impl FnMut(Contender) -> Result<Vec<Timed>, E>,
    ) -> Result<Vec<PairedTimes>, E> {
        let mut all: Vec<PairedTimes> = Vec::new();
        let start = clock.now();
        let mut round = 0;
        while self.goes_on(round, clock.now().saturating_sub(start)) {
            progress.message(format!("turn {}", round + 1));
            let mut seen: BTreeMap<Key, [Option<f64>; 3]> = BTreeMap::new();
            for place in round_order(self.seed, "turns", round as usize, CONTENDERS.len()) {
                let Some(contender) = CONTENDERS.get(place) else { continue };
                for Timed { key, seconds } in ask(*contender)? {
                    if let Some(own) = seen.entry(key).or_default().get_mut(place) {
                        *own = Some(seconds);
                    }
                }
            }
            for (key, times) in seen {
                let [Some(old), Some(new), Some(copy)] = times else { continue };
                let times = [old, new, copy];
                match all.iter_mut().find(|known| known.key == key) {
                    Some(known) => known.times.push(times),
                    None => all.push(PairedTimes { key, times: vec![times] }),
                }
            }
            round += 1;
            progress.step(clock.now());
        }
        Ok(all)
    }
}

/// How far the copy was from the new program: medians of their quotients within each turn.
pub fn floor(pairs: &[PairedTimes]) -> Option<FloorRecord> {
    FloorRecord::of(pairs.iter().filter_map(|paired| {
        let Key { scene, row, quantity } = &paired.key;
        let quotients: Vec<f64> = paired.times.iter().map(|[_, new, copy]| copy / new).collect();
        Some((format!("{}, {quantity}", place(scene, row)), median(&quotients)?))
    }))
}

#[cfg(test)]
mod tests {
    use measurement::system::clock::SteppingClock;

    use super::*;

    fn turns(rounds: u32) -> (Vec<Contender>, Vec<PairedTimes>) {
        let mut asked = Vec::new();
        let pace = Pace { rounds: Some(rounds), time_budget: None, seed: 3 };
        let clock = SteppingClock::new(Duration::from_millis(1));
        let times = pace.take_turns(&clock, &Progress::hidden(), |contender| {
            asked.push(contender);
            let key = Key { scene: String::new(), row: "a".into(), quantity: "time" };
            let lost = Key { row: "only old".into(), ..key.clone() };
            let seconds = [2.0, 1.0, 1.1][contender as usize];
            let mut times = vec![Timed { key, seconds }];
            times.extend((contender == Contender::Old).then_some(Timed { key: lost, seconds }));
            Ok::<_, ()>(times)
        });
        (asked, times.unwrap())
    }

    #[test]
    fn of_two_programs_each_is_first_equally_often() {
        let (asked, times) = turns(8);
        assert_eq!(asked.len(), 24);
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            let first = asked.chunks(3).filter(|turn| {
                let place = |c| turn.iter().position(|t| *t == CONTENDERS[c]);
                place(a) < place(b)
            });
            assert_eq!(first.count(), 4);
        }
        assert_eq!(times.len(), 1, "what one program lacks is left out");
        assert_eq!(times[0].times, vec![[2.0, 1.0, 1.1]; 8]);
    }

    #[test]
    fn the_planted_difference_of_the_copy_is_the_floor() {
        let floor = floor(&turns(3).1).unwrap();
        assert!((floor.floor - 0.1).abs() < 1e-9 && floor.row == "a, time", "{floor:?}");
    }
}
