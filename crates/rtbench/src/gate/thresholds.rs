//! What counts as a regression.
//!
//! Why these defaults. Counters are exact and have no threshold. Instruction counts of one binary
//! repeat to within a few of a million, so 0.5% is far beyond chance, and less is seldom worth a
//! failed job. Times of unchanged code differ between two processes by several percent (where code and
//! memory happen to lie), and by more on shared machines: how much a copy of the program differs
//! by is measured each time, and is the threshold where it is more. A baseline is of one process on another
//! day: 5%. Turns are of several processes of each program, a moment apart: 2%. What is slower by less is
//! what instruction counts are for.

use serde::{Deserialize, Serialize};

/// Thresholds of a check.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename_all = "kebab-case")]
pub struct Thresholds {
    /// Instructions: the share by which there may be more.
    pub instructions: f64,
    /// Times: the share by which they may be longer.
    pub time: f64,
    /// The probability of one false alarm among all times of a check.
    pub significance: f64,
    /// Seconds; shorter times are not judged.
    pub shortest: f64,
    /// The share of a run in which some thread may wait for a processor. Beyond it ratios within
    /// the run say little: a long time is interrupted more often than a short one.
    pub busiest: f64,
}

/// The share of a longer time where programs are measured in turns.
pub const OF_TURNS: f64 = 0.02;

impl Default for Thresholds {
    fn default() -> Self {
        Self { instructions: 0.005, time: 0.05, significance: 0.05, shortest: 200e-6, busiest: 0.2 }
    }
}

/// A threshold out of range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name}: {value} is out of range; expected {expected}")]
pub struct ThresholdError {
    name: &'static str,
    value: f64,
    expected: &'static str,
}

impl Thresholds {
    /// These, where each is in its range.
    ///
    /// # Errors
    /// [`ThresholdError`] naming what is valid.
    pub fn checked(self) -> Result<Self, ThresholdError> {
        let share = "a share from 0 to 10";
        let is_share = |x: f64| (0.0..=10.0).contains(&x);
        let [not_negative, probability] = ["seconds, not negative", "between 0 and 1"];
        for (name, value, is_valid, expected) in [
            ("instructions", self.instructions, is_share(self.instructions), share),
            ("time", self.time, is_share(self.time), share),
            ("busiest", self.busiest, is_share(self.busiest), share),
            (
                "significance",
                self.significance,
                self.significance > 0.0 && self.significance < 1.0,
                probability,
            ),
            (
                "shortest",
                self.shortest,
                self.shortest.is_finite() && self.shortest >= 0.0,
                not_negative,
            ),
        ] {
            if !is_valid {
                return Err(ThresholdError { name, value, expected });
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_read_with_defaults_and_unknown_ones_are_errors() {
        let read = |text: &str| serde_json::from_str::<Thresholds>(text);
        let some = read(r#"{"time": 0.2}"#).unwrap();
        assert_eq!(some, Thresholds { time: 0.2, ..Thresholds::default() });
        assert!(read(r#"{"tiem": 0.2}"#).unwrap_err().to_string().contains("time"));
    }

    #[test]
    fn nonsense_is_refused() {
        for significance in [0.0, 1.0, f64::NAN] {
            let thresholds = Thresholds { significance, ..Thresholds::default() };
            let error = thresholds.checked().unwrap_err().to_string();
            assert!(error.contains("between 0 and 1"), "{error}");
        }
    }
}
