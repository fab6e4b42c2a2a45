//! What on a machine disturbs measurements: one finding a line, with what it means and what to do.

pub mod memory;
pub mod noise;
pub mod system;

use serde::Serialize;

use crate::doctor::memory::Latency;
use crate::doctor::noise::Noise;
use crate::doctor::system::System;
use measurement::system::clock::Clock;

/// What is said of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Nothing to do.
    Good,
    /// Measurements suffer from it.
    Warning,
    /// The system does not tell.
    Unknown,
}

impl Level {
    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Warning => "warning",
            Self::Unknown => "unknown",
        }
    }
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub name: &'static str,
    /// What is said of it.
    pub level: Level,
    /// What was found, in words.
    pub value: String,
    /// What it means for measurements.
    pub meaning: &'static str,
    /// What to do; only of warnings.
    pub advice: Option<&'static str>,
}

/// Everything that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosis {
    /// Over repeated loops of the same work.
    pub noise: Noise,
    /// One for each thing looked at.
    pub findings: Vec<Finding>,
    /// What a load takes that waits for the one before, by the size of memory; where asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub memory: Vec<Latency>,
}

/// Looks at the system and times the loop, and loads among those sizes of memory.
pub fn diagnose(system: &System, clock: &dyn Clock, memory: &[usize]) -> Diagnosis {
    let noise = noise::measure(clock);
    let mut findings = system.findings();
    findings.push(noise.finding());
    Diagnosis { noise, findings, memory: memory::measure(memory, clock) }
}
