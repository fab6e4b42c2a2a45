//! The order in which a row is asked its rays: as the image has them, line by line, or shuffled.
//!
//! Neighbours in an image take much the same way, so that what one ray brought into the caches serves
//! the next. Shuffled, the same rays have nothing of it: the worst case of what a renderer asks after
//! many bounces. The shuffle is seeded, so that every row and every run has the same one.
//!
//! In records the rays of a kind go by its name; those in shuffled order by `NAME-shuffled`.

use std::borrow::Cow;
use std::collections::BTreeMap;

use accel_core::structures::Buildable;
use clap::ValueEnum;
use renderer::RayKind;

use crate::batches::{Batch, BatchSet};
use crate::random::Random;
use crate::record::SceneRecord;

/// What follows the kind in the names of shuffled rays.
const SUFFIX: &str = "-shuffled";

/// One order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RayOrder {
    /// As the image has them.
    #[default]
    Scanline,
    /// At random.
    Shuffled,
}

/// The orders of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum Orders {
    /// As the image has them, line by line
    #[default]
    Scanline,
    /// At random, seeded
    Shuffled,
    /// One after the other
    Both,
}

impl Orders {
    /// As typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scanline => "scanline",
            Self::Shuffled => "shuffled",
            Self::Both => "both",
        }
    }

    /// Them, in the order of the tables.
    pub fn orders(self) -> &'static [RayOrder] {
        match self {
            Self::Scanline => &[RayOrder::Scanline],
            Self::Shuffled => &[RayOrder::Shuffled],
            Self::Both => &[RayOrder::Scanline, RayOrder::Shuffled],
        }
    }
}

/// What records call the rays of a kind in an order.
pub fn batch_name(kind: &str, order: RayOrder) -> String {
    match order {
        RayOrder::Scanline => kind.to_owned(),
        RayOrder::Shuffled => format!("{kind}{SUFFIX}"),
    }
}

/// The kind of the rays that records call so.
pub fn kind_of(name: &str) -> &str {
    name.strip_suffix(SUFFIX).unwrap_or(name)
}

/// Rays by name, without those that are there in another order, too.
pub fn distinct(rays: &BTreeMap<String, u64>) -> impl Iterator<Item = (&str, u64)> {
    let is_first = |name: &str| kind_of(name) == name || !rays.contains_key(kind_of(name));
    rays.iter().map(|(name, n)| (name.as_str(), *n)).filter(move |(name, _)| is_first(name))
}

impl SceneRecord {
    /// Rays of all kinds, each once.
    pub fn distinct_rays(&self) -> u64 {
        distinct(&self.rays).map(|(_, n)| n).sum()
    }
}

impl<'a, S: Buildable> BatchSet<'a, S> {
    /// The same rays in those orders; the shuffle of a kind is that of the seed and the scene.
    #[must_use]
    pub fn in_orders(self, orders: Orders, seed: u64, scene: &str) -> Self {
        if orders == Orders::Scanline {
            return self;
        }
        let shuffled: Vec<Batch<'a, S>> =
            self.batches.iter().map(|batch| shuffled(batch, seed, scene)).collect();
        let kept = if orders == Orders::Both { self.batches } else { Vec::new() };
        Self { stride: self.stride, batches: kept.into_iter().chain(shuffled).collect() }
    }

    /// The batches without those that another has the same rays of in another order.
    pub fn distinct(&self) -> BatchSet<'_, S> {
        let is_first = |batch: &Batch<'_, S>| {
            let same = self.batches.iter().find(|b| b.kind == batch.kind);
            same.is_none_or(|first| first.order == batch.order)
        };
        let kept = self.batches.iter().filter(|batch| is_first(batch));
        BatchSet { stride: self.stride, batches: kept.map(Batch::borrowed).collect() }
    }
}

fn shuffled<'a, S: Buildable>(batch: &Batch<'_, S>, seed: u64, scene: &str) -> Batch<'a, S> {
    let mut places: Vec<u32> = (0..batch.rays.len() as u32).collect();
    purpose(seed, scene, batch.kind).shuffle(&mut places);
    let places = || places.iter().map(|&place| place as usize);
    Batch {
        kind: batch.kind,
        order: RayOrder::Shuffled,
        rays: Cow::Owned(places().filter_map(|i| batch.rays.get(i).copied()).collect()),
        lights: places().filter_map(|i| batch.lights.get(i).copied()).collect(),
        expected: batch.expected.picked(places()),
    }
}

fn purpose(seed: u64, scene: &str, kind: RayKind) -> Random {
    Random::new(seed, &format!("order/{scene}/{}", kind.name()))
}

#[cfg(test)]
mod tests {
    use accel_core::{Hit, Ray, Vec3, Vector};
    use glam::DVec3;

    use super::*;
    use crate::batches::Answers;

    fn set(n: usize) -> BatchSet<'static, f32> {
        let ray =
            |i: usize| Ray::new(Vec3::<f32>::from_dvec3(DVec3::X * i as f64), Vec3::<f32>::ZERO);
        let hits = (0..n).map(|i| Hit { t: i as f32, id: i as u32 }).collect();
        let batch = |kind, expected, lights| Batch {
            kind,
            order: RayOrder::Scanline,
            rays: Cow::Owned((0..n).map(ray).collect()),
            lights,
            expected,
        };
        let blocked = Answers::Blocked((0..n).map(|i| i % 3 == 0).collect());
        let lights = (0..n as u32).collect();
        BatchSet {
            stride: 1,
            batches: vec![
                batch(RayKind::Primary, Answers::Hits(hits), Vec::new()),
                batch(RayKind::Shadow, blocked, lights),
            ],
        }
    }

    fn places(batch: &Batch<'_, f32>) -> Vec<usize> {
        batch.rays.iter().map(|ray| ray.origin.to_dvec3().x as usize).collect()
    }

    #[test]
    fn shuffled_rays_keep_their_answers_and_their_lights() {
        let all = set(100).in_orders(Orders::Both, 7, "tetra");
        let names: Vec<String> = all.batches.iter().map(Batch::name).collect();
        assert_eq!(names, ["primary", "shadow", "primary-shuffled", "shadow-shuffled"]);
        for batch in &all.batches[2..] {
            let order = places(batch);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..100).collect::<Vec<_>>(), "each ray once");
            assert_ne!(order, sorted, "in another order");
            match &batch.expected {
                Answers::Hits(hits) => {
                    assert!(hits.iter().zip(&order).all(|(h, &i)| h.id == i as u32))
                }
                Answers::Blocked(blocked) => {
                    assert!(blocked.iter().zip(&order).all(|(&b, &i)| b == (i % 3 == 0)));
                    assert!(batch.lights.iter().zip(&order).all(|(&l, &i)| l == i as u32));
                }
            }
        }
        assert_ne!(places(&all.batches[2]), places(&all.batches[3]), "each kind has its own");
    }

    #[test]
    fn the_shuffle_is_that_of_the_seed_and_the_scene() {
        let of = |seed, scene| places(&set(50).in_orders(Orders::Shuffled, seed, scene).batches[0]);
        assert_eq!(of(1, "tetra"), of(1, "tetra"));
        assert_ne!(of(1, "tetra"), of(2, "tetra"));
        assert_ne!(of(1, "tetra"), of(1, "balls"));
        let untouched = set(50).in_orders(Orders::Scanline, 1, "tetra");
        assert_eq!(places(&untouched.batches[0]), (0..50).collect::<Vec<_>>());
    }

    #[test]
    fn each_ray_is_distinct_once() {
        for (orders, names) in [
            (Orders::Both, ["primary", "shadow"]),
            (Orders::Shuffled, ["primary-shuffled", "shadow-shuffled"]),
        ] {
            let all = set(10).in_orders(orders, 1, "tetra");
            let left = all.distinct();
            assert!(left.batches.iter().map(Batch::name).eq(names.map(str::to_owned)));
            let rays: BTreeMap<String, u64> =
                all.batches.iter().map(|b| (b.name(), b.rays.len() as u64)).collect();
            assert_eq!(distinct(&rays).map(|(_, n)| n).sum::<u64>(), 20);
        }
    }
}
