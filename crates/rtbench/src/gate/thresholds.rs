//! Thresholds of regressions.
//!
//! Why these defaults. Counters are exact and have no threshold. Instruction counts of one binary
//! repeat to within a few of a million, so 0.5% is far beyond chance, and less is seldom worth a
//! failed job. Times of unchanged code differ between two processes by several percent (where code
//! and memory happen to lie), and by more on shared machines: how much a copy of the program
//! differs by is measured each time, and is the threshold where it is more. A baseline is of one
//! process on another day: 5%. Turns are of several processes of each program, a moment apart: 2%.
//! What is slower by less is what instruction counts are for.

use std::fmt;

use serde::Serialize;

use measurement::record::metrics::{METRICS, Reading};
use measurement::settings::choice;

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
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
    /// Those that some rows and kinds of rays have instead; of several that fit the last.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<RowThreshold>,
}

/// Thresholds of some rows, of some times or of both.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RowThreshold {
    /// A structure with all its rows, or the label of one row; none for all.
    pub row: Option<String>,
    /// `build`, `trace` or a kind of rays; none for build and trace.
    pub of: Option<&'static str>,
    /// The share by which times may be longer.
    pub time: Option<f64>,
    /// The share by which instructions may be more.
    pub instructions: Option<f64>,
}

/// Times that are judged of every row.
const OF_ALL: [&str; 2] = ["build", "trace"];

/// Names of the times that can have a threshold.
fn quantities() -> impl Iterator<Item = &'static str> {
    let kinds = METRICS.iter().filter_map(|metric| match metric.reading {
        Reading::RatioOf(kind) => Some(kind),
        _ => None,
    });
    OF_ALL.into_iter().chain(kinds)
}

pub fn quantity_named(name: &str) -> Result<&'static str, String> {
    quantities().find(|known| *known == name).ok_or_else(|| {
        let hint = choice::hint(name, quantities());
        let valid: Vec<&str> = quantities().collect();
        format!("of: unknown '{name}'{hint}; valid: {}", valid.join(", "))
    })
}

impl fmt::Display for RowThreshold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.row.as_deref().unwrap_or("all rows"))?;
        self.of.map_or(Ok(()), |of| write!(f, ", {of}"))?;
        let shares = [("time", self.time), ("instructions", self.instructions)];
        let given = shares.into_iter().filter_map(|(name, share)| Some((name, share?)));
        for ((name, share), before) in given.zip([": ", ", "]) {
            write!(f, "{before}{name} {}%", (share * 1e4).round() / 100.0)?;
        }
        Ok(())
    }
}

impl RowThreshold {
    pub fn kind(&self) -> Option<&'static str> {
        self.of.filter(|of| !OF_ALL.contains(of))
    }

    fn is_of_row(&self, label: &str) -> bool {
        let structure = label.split(' ').next();
        self.row.as_deref().is_none_or(|row| row == label || Some(row) == structure)
    }

    fn is_of(&self, label: &str, quantity: &str) -> bool {
        let is_of_quantity = match self.of {
            Some(of) => of == quantity,
            None => OF_ALL.contains(&quantity),
        };
        is_of_quantity && self.is_of_row(label)
    }
}

/// The share of a longer time where programs are measured in turns.
pub const OF_TURNS: f64 = 0.02;

impl Default for Thresholds {
    fn default() -> Self {
        Self {
            instructions: 0.005,
            time: 0.05,
            significance: 0.05,
            shortest: 200e-6,
            busiest: 0.2,
            rows: Vec::new(),
        }
    }
}

impl Thresholds {
    /// The share by which a time of a row may be longer.
    pub fn time_of(&self, label: &str, quantity: &str) -> f64 {
        self.last_of(label, quantity, |own| own.time).unwrap_or(self.time)
    }

    /// The share by which instructions of a row's build or traversal may be more.
    pub fn instructions_of(&self, label: &str, quantity: &str) -> f64 {
        self.last_of(label, quantity, |own| own.instructions).unwrap_or(self.instructions)
    }

    fn last_of(
        &self,
        label: &str,
        quantity: &str,
        share: fn(&RowThreshold) -> Option<f64>,
    ) -> Option<f64> {
        self.rows.iter().rev().filter(|own| own.is_of(label, quantity)).find_map(share)
    }

    /// Kinds of rays that are judged apart, since a threshold for the row names them.
    pub fn kinds_of(&self, label: &str) -> Vec<&'static str> {
        let own = self.rows.iter().filter(|own| own.is_of_row(label));
        let mut kinds: Vec<&'static str> = own.filter_map(RowThreshold::kind).collect();
        kinds.sort_unstable();
        kinds.dedup();
        kinds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_matching_threshold_applies() {
        let of = |row: Option<&str>, of, time| RowThreshold {
            row: row.map(str::to_owned),
            of,
            time: Some(time),
            instructions: None,
        };
        let rows = vec![
            of(None, Some("shadow"), 0.2),
            of(Some("grid"), None, 0.1),
            of(Some("grid density=4"), Some("trace"), 0.3),
        ];
        let thresholds = Thresholds { rows, ..Thresholds::default() };
        let time = |row, what| thresholds.time_of(row, what);
        assert_eq!([time("bvh", "trace"), time("bvh", "shadow")], [0.05, 0.2]);
        assert_eq!([time("grid", "trace"), time("grid", "build")], [0.1, 0.1]);
        assert_eq!([time("grid density=4", "trace"), time("grid density=4", "build")], [0.3, 0.1]);
        // a kind of rays is another quantity than those that an entry without one is of
        assert_eq!(time("grid", "shadow"), 0.2);
        assert_eq!(time("gridlock", "build"), 0.05);
        assert_eq!(thresholds.kinds_of("grid"), ["shadow"]);
        let error = quantity_named("shdow").unwrap_err();
        assert!(error.contains("'shdow' (did you mean 'shadow'?); valid: build, trace"), "{error}");
    }
}
