//! What was built, and the work it does for rays.

use accel_core::query::counters::WorkCounters;
use serde::{Deserialize, Serialize};

/// What was built, in the symbols of Havran and Sixta (1999).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct StatsRecord {
    /// N_IN: hierarchical cells.
    pub n_in: u64,
    /// N_V: elementary cells.
    pub n_v: u64,
    /// N_EV: empty elementary cells.
    pub n_ev: u64,
    /// N_OIV: references in elementary cells.
    pub n_oiv: u64,
    /// Voxels per axis.
    pub resolution: Option<[u32; 3]>,
    /// Bytes of the structure.
    pub memory_bytes: u64,
    /// Structures that build on demand: cells that no ray of the counting pass had divided.
    #[serde(default)]
    pub pending_cells: Option<u64>,
}

/// Work of all counted rays together.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct WorkRecord {
    /// Rays counted over.
    pub rays: u64,
    /// N_IT: intersection tests.
    pub intersection_tests: u64,
    /// N_TS: traversal steps.
    pub traversal_steps: u64,
    /// N_ETS: elementary steps.
    pub elementary_steps: u64,
    /// N_EETS: empty elementary steps.
    pub empty_elementary_steps: u64,
    /// Tests that a mailbox spared.
    #[serde(default)]
    pub tests_saved: u64,
}

impl WorkRecord {
    /// Of so many rays.
    pub fn of(rays: usize, work: &WorkCounters) -> Self {
        Self {
            rays: rays as u64,
            intersection_tests: work.intersection_tests,
            traversal_steps: work.traversal_steps,
            elementary_steps: work.elementary_steps,
            empty_elementary_steps: work.empty_elementary_steps,
            tests_saved: work.tests_saved,
        }
    }

    /// The part of all tests that a mailbox spared; none where it spared none.
    pub fn saved_part(&self) -> Option<f64> {
        let all = self.tests_saved + self.intersection_tests;
        (self.tests_saved > 0).then(|| self.tests_saved as f64 / all as f64)
    }

    /// N_IT, N_TS, N_ETS, N_EETS per ray.
    pub fn per_ray(&self) -> [f64; 4] {
        let rays = self.rays.max(1) as f64;
        [
            self.intersection_tests,
            self.traversal_steps,
            self.elementary_steps,
            self.empty_elementary_steps,
        ]
        .map(|n| n as f64 / rays)
    }
}
