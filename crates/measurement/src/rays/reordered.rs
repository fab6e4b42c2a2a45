//! Rays asked in another order than the image has them.

use accel_core::registry::Buildable;
use renderer::RayKind;

use crate::rays::batches::{Batch, BatchSet};
use crate::rays::order::{Orders, RayOrder};
use statistics::random::Random;

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
    let picked = batch.picked(places.iter().map(|&place| place as usize));
    Batch { order: RayOrder::Shuffled, ..picked }
}

fn purpose(seed: u64, scene: &str, kind: RayKind) -> Random {
    Random::new(seed, &format!("order/{scene}/{}", kind.name()))
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;
    use std::collections::BTreeMap;

    use accel_core::{Hit, Ray, Vec3, Vector};
    use glam::DVec3;

    use super::*;
    use crate::rays::batches::Answers;
    use crate::rays::order::distinct;

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
    fn distinct_batches_count_each_ray_once() {
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
