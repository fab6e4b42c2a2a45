//! Numbers of cones and rays of an image.

use accel_core::query::region::Candidates;

#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    pub(super) cones: u64,
    pub(super) subdivided: u64,
    pub(super) shadow_cones: u64,
    pub(super) rays: u64,
    pub(super) shadow_rays: u64,
}

impl Counts {
    pub fn rows(self) -> Vec<(&'static str, u64)> {
        vec![
            ("cones", self.cones),
            ("shadow cones", self.shadow_cones),
            ("cones cut into four", self.subdivided),
            ("rays", self.rays),
            ("shadow rays", self.shadow_rays),
        ]
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.cones += other.cones;
        self.subdivided += other.subdivided;
        self.shadow_cones += other.shadow_cones;
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
    }
}

/// Scratch memory of a tracing thread.
#[derive(Default)]
pub struct Scratch {
    /// Memory of the candidate queries, and their cost.
    pub candidates: Candidates,
    pub counts: Counts,
}
