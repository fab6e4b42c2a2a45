//! Settings of a run as a program in Rust gives them: typed, one after another.

use std::time::Duration;

use accel_core::params::Params;
use renderer::RayKind;

use crate::settings::{Precision, RunSettings};

/// Where a number is out of range, [`Plan::new`](crate::plan::Plan::new) says so.
impl RunSettings {
    /// Adds a scene, a set of scenes or a scene file: `teapot`, `balls:4`, `scenes/kitchen.json`.
    #[must_use]
    pub fn scene(mut self, name: impl Into<String>) -> Self {
        self.scenes.push(name.into());
        self
    }

    /// Adds a row: a structure, or an occluder, with its settings.
    #[must_use]
    pub fn row(mut self, params: &Params) -> Self {
        self.structures.push(params.label());
        self
    }

    /// Takes ratios to that row, which need not be added.
    #[must_use]
    pub fn reference(mut self, params: &Params) -> Self {
        self.measuring.reference = Some(params.label());
        self
    }

    /// Asks rays of these kinds alone.
    #[must_use]
    pub fn rays(mut self, kinds: impl IntoIterator<Item = RayKind>) -> Self {
        self.measuring.rays = kinds.into_iter().map(|kind| kind.name().to_owned()).collect();
        self
    }

    /// Small images and few rounds.
    #[must_use]
    pub fn quick(mut self) -> Self {
        self.measuring.quick = true;
        self
    }

    #[must_use]
    pub fn rounds(mut self, rounds: u32) -> Self {
        self.measuring.rounds = Some(rounds);
        self
    }

    /// Rounds until this time has passed, all scenes together.
    #[must_use]
    pub fn time_budget(mut self, total: Duration) -> Self {
        self.measuring.time_budget = Some(total);
        self
    }

    /// Width and height of the image, pixels.
    #[must_use]
    pub fn size(mut self, pixels: u32) -> Self {
        self.measuring.size = Some(pixels);
        self
    }

    /// Threads that build and trace.
    #[must_use]
    pub fn threads(mut self, threads: u16) -> Self {
        self.measuring.threads = threads;
        self
    }

    /// Arithmetic of primitives and rays.
    #[must_use]
    pub fn precision(mut self, precision: Precision) -> Self {
        self.measuring.precision = precision;
        self
    }

    /// Seed of schedules, samples and intervals.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.measuring.seed = seed;
        self
    }
}
