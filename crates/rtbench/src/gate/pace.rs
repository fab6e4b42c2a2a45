//! Number of processes that take turns, and when intermediate results are tested.

use std::time::Duration;

/// Rounds of a baseline and of a check where nothing is said. The rank test of 15 against 15 can
/// be significant among thousands of rows; that of the 5 of `run` cannot even be among ten.
pub const ROUNDS: u32 = 15;

/// Processes within a time budget, at the least: fewer could not be significant.
const FEWEST: u32 = 5;
/// Processes after which the laps so far are looked at, if more are to come.
const LOOKS: [u32; 6] = [5, 9, 15, 25, 40, 60];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TurnPlan {
    /// Processes of each program; none asks for the default.
    pub rounds: Option<u32>,
    /// Time for all of them, where no number is said.
    pub time_budget: Option<Duration>,
    /// Seed of the orders.
    pub seed: u64,
}

impl TurnPlan {
    /// Processes of each program at the most, as far as is known.
    pub fn expected(&self) -> u32 {
        self.rounds.unwrap_or(ROUNDS)
    }

    /// Returns whether that process, from 0, is started so long after the first.
    pub fn goes_on(&self, process: u32, elapsed: Duration) -> bool {
        match self.time_budget {
            Some(budget) => process < FEWEST || elapsed < budget,
            None => process < self.expected(),
        }
    }

    /// How often laps are looked at, the end included.
    pub fn max_looks(&self) -> u32 {
        let is_before = |look: &&u32| self.time_budget.is_some() || **look < self.expected();
        1 + LOOKS.iter().filter(is_before).count() as u32
    }
}

/// Returns whether laps are looked at before that process, from 0, is started.
pub fn is_look(process: u32) -> bool {
    LOOKS.contains(&process)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_at_the_results_are_counted() {
        let looks = |rounds, seconds| {
            let time_budget = Option::<u64>::map(seconds, Duration::from_secs);
            TurnPlan { rounds, time_budget, seed: 1 }.max_looks()
        };
        assert_eq!([looks(Some(2), None), looks(Some(9), None), looks(None, None)], [1, 2, 3]);
        assert_eq!(looks(None, Some(60)), 7);
    }
}
