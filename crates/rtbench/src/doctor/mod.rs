//! What may disturb measurements on a machine: one finding per line, with what it means and what to do.

pub mod finding;
pub mod noise;
pub mod system;

use serde::Serialize;

use crate::doctor::finding::Finding;
use crate::doctor::noise::Noise;
use crate::doctor::system::System;
use measurement::system::clock::Clock;

/// Everything that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosis {
    /// Over repeated loops of the same work.
    pub noise: Noise,
    /// One for each thing looked at.
    pub findings: Vec<Finding>,
}

/// Looks at the system and times the loop.
pub fn diagnose(system: &System, clock: &dyn Clock) -> Diagnosis {
    let noise = noise::measure(clock);
    let mut findings = system.findings();
    findings.push(noise.finding());
    Diagnosis { noise, findings }
}
