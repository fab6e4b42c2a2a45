//! Numbers of rays of an image, by kind and by effect.

use super::effect::Effect;
use crate::rays::RayKind;

/// Rays of an image. Counted by wave, not by ray.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RayCounts {
    kinds: [u64; 5],
    effects: [u64; Effect::COUNT],
    /// Refracted rays that total internal reflection left untraced.
    pub total_internal_reflections: u64,
}

impl RayCounts {
    /// Rays of a kind.
    pub fn kind(&self, kind: RayKind) -> u64 {
        self.kinds[kind as usize]
    }

    /// Rays that belong to an effect; an eye ray belongs to each effect that it samples.
    pub fn effect(&self, effect: Effect) -> u64 {
        self.effects[effect as usize]
    }

    /// Rays of all kinds.
    pub fn total(&self) -> u64 {
        self.kinds.iter().sum()
    }

    /// `n` more rays of a kind.
    pub fn add_kind(&mut self, kind: RayKind, n: usize) {
        self.kinds[kind as usize] += n as u64;
    }

    /// `n` more rays of an effect.
    pub fn add_effect(&mut self, effect: Effect, n: usize) {
        self.effects[effect as usize] += n as u64;
    }
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        let add = |all: &mut [u64], more: &[u64]| {
            all.iter_mut().zip(more).for_each(|(a, b)| *a += b);
        };
        add(&mut self.kinds, &other.kinds);
        add(&mut self.effects, &other.effects);
        self.total_internal_reflections += other.total_internal_reflections;
    }
}
