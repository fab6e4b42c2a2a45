//! All answers of a tracer to the rays of a round, asked in every way there is: together, counted,
//! alone, and among nearly parallel ones, with which a structure may share work. A digest stands for
//! them.

use std::fmt;

use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::{Hit, MISS, Ray, Scalar, Vec3, Vector};
use glam::DVec3;
use renderer::Geometry;
use statistics::random::Random;

use crate::verify::draw::{point, unit};
use crate::verify::every_hit::hits_among;

/// One ray in so many is asked in the other ways as well.
const REPEATED: usize = 8;

/// The answers to all rays, asked in all ways.
#[derive(Debug, Clone)]
pub(super) struct Answers<S: Buildable> {
    pub(super) closest: Vec<Hit<S>>,
    pub(super) blocked: Vec<bool>,
    again: Vec<Repeated<S>>,
}

/// The answers to every [`REPEATED`]th ray, asked once more in another way.
#[derive(Debug, Clone)]
pub(super) struct Repeated<S: Scalar> {
    pub(super) how: &'static str,
    pub(super) closest: Vec<Hit<S>>,
    /// Empty where occlusions are not asked so.
    pub(super) blocked: Vec<bool>,
}

impl<S: Buildable> Answers<S> {
    pub(super) fn of(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> Self {
        let (closest, blocked) = together(tracer, rays);
        let some: Vec<Ray<S>> = rays.iter().copied().step_by(REPEATED).collect();
        let mut counted = vec![unwritten(); some.len()];
        let preset = |hit: &Hit<S>| !hit.is_hit();
        let mut counted_blocked: Vec<bool> = closest.iter().step_by(REPEATED).map(preset).collect();
        tracer.count_closest_hits(&some, &mut counted);
        tracer.count_occlusions(&some, &mut counted_blocked);
        let mut again =
            vec![Repeated { how: "when counting", closest: counted, blocked: counted_blocked }];
        // where batches are asked ray by ray, these ways are the same
        if tracer.batches().are_together() {
            let closest = some.chunks(1).flat_map(|one| self::closest(tracer, one)).collect();
            again.push(Repeated { how: "when asked alone", closest, blocked: Vec::new() });
            let batch = CoherentBatch::of(&some);
            again.push(batch.asked(tracer, "in a coherent batch"));
            again.push(batch.mixed().asked(tracer, "in the same batch, mixed"));
        }
        Self { closest, blocked, again }
    }

    /// By brute force over the primitives near each ray alone.
    pub(super) fn near(model: &Geometry<S>, rays: &[Ray<S>], near: &[Vec<u32>]) -> Self {
        let nearest = |(ray, ids): (&Ray<S>, &Vec<u32>)| {
            hits_among(model, ray, ids.iter().copied()).first().copied().unwrap_or(Hit::NONE)
        };
        let closest: Vec<Hit<S>> = rays.iter().zip(near).map(nearest).collect();
        // all primitives of such rounds are opaque
        let blocked: Vec<bool> = closest.iter().map(Hit::is_hit).collect();
        Self { closest, blocked, again: Vec::new() }
    }

    /// The answers to a ray that is asked again.
    pub(super) fn again(&self, ray: usize) -> impl Iterator<Item = (&Repeated<S>, usize)> {
        let is_repeated = ray.is_multiple_of(REPEATED);
        self.again.iter().filter(move |_| is_repeated).map(move |again| (again, ray / REPEATED))
    }

    /// The closest hits of a ray, however it was asked.
    pub(super) fn hits_of(&self, ray: usize) -> impl Iterator<Item = Hit<S>> {
        let again = self.again(ray).filter_map(|(again, i)| again.closest.get(i));
        self.closest.get(ray).into_iter().chain(again).copied()
    }

    /// Occlusion answers for it, likewise.
    pub(super) fn occlusions_of(&self, ray: usize) -> impl Iterator<Item = bool> {
        let again = self.again(ray).filter_map(|(again, i)| again.blocked.get(i));
        self.blocked.get(ray).into_iter().chain(again).copied()
    }

    pub(super) fn digest(&self) -> Digest {
        let mut digest = Digest::default();
        self.closest.iter().for_each(|hit| digest.hit(hit));
        self.blocked.iter().for_each(|blocked| digest.blocked(*blocked));
        digest
    }
}

/// Closest hits and occlusions. Buffers are preset to wrong answers (blocked where nothing is hit,
/// and vice versa), so that unwritten answers are wrong.
fn together<S: Scalar>(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> (Vec<Hit<S>>, Vec<bool>) {
    let hits = closest(tracer, rays);
    let mut blocked: Vec<bool> = hits.iter().map(|hit| !hit.is_hit()).collect();
    tracer.occlusions(rays, &mut blocked);
    (hits, blocked)
}

pub(super) fn closest<S: Scalar>(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> Vec<Hit<S>> {
    let mut hits = vec![unwritten(); rays.len()];
    tracer.closest_hits(rays, &mut hits);
    hits
}

/// Stands where no hit was written: of no primitive, at no parameter, and so no answer.
fn unwritten<S: Scalar>() -> Hit<S> {
    Hit { t: S::from_f64(f64::NAN), id: MISS - 1 }
}

/// Rays of a group; as many share their way at most.
const GROUP: usize = 8;

/// Rays of eights, each with one of those that are asked about.
struct CoherentBatch<S: Scalar> {
    rays: Vec<Ray<S>>,
    /// Positions of the judged rays, in their order.
    places: Vec<usize>,
}

impl<S: Scalar> CoherentBatch<S> {
    /// Each of these rays in a group of its own.
    fn of(rays: &[Ray<S>]) -> Self {
        let mut random = Random::new(rays.len() as u64, "company");
        let mut batch = Self { rays: Vec::new(), places: Vec::new() };
        for (i, ray) in rays.iter().enumerate() {
            let place = random.below(GROUP);
            batch.places.push(i * GROUP + place);
            // from a few ulps to a tenth
            let apart = 2f64.powf(-24.0 + 20.0 * unit(&mut random));
            batch.rays.extend(
                (0..GROUP).map(
                    |other| if other == place { *ray } else { beside(&mut random, ray, apart) },
                ),
            );
        }
        batch
    }

    /// Answers to the judged rays, asked within the batch.
    fn asked(&self, tracer: &dyn Tracer<S>, how: &'static str) -> Repeated<S> {
        let (hits, blocked) = together(tracer, &self.rays);
        Repeated {
            how,
            closest: self.places.iter().map(|&place| hits[place]).collect(),
            blocked: self.places.iter().map(|&place| blocked[place]).collect(),
        }
    }

    /// The same rays, those of a group as far apart as can be: where there are many, a structure
    /// may put them into an order of its own.
    fn mixed(&self) -> Self {
        let groups = self.rays.len() / GROUP;
        let rays = (0..self.rays.len()).map(|i| self.rays[i % groups * GROUP + i / groups]);
        let place = |&place: &usize| place % GROUP * groups + place / GROUP;
        Self { rays: rays.collect(), places: self.places.iter().map(place).collect() }
    }
}

/// A ray whose coordinates are each off by no more than this part of them: it runs into the same
/// octant.
fn beside<S: Scalar>(random: &mut Random, ray: &Ray<S>, apart: f64) -> Ray<S> {
    let mut off = |v: Vec3<S>| {
        let factor = DVec3::ONE + point(random) * apart;
        Vec3::<S>::from_dvec3(v.to_dvec3() * factor)
    };
    Ray { origin: off(ray.origin), direction: off(ray.direction), ..*ray }
}

/// The answers of one round, in order; or those of several, in any.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Digest(pub u64);

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl Digest {
    /// Digest of one round; its number distinguishes equal answers to other rays.
    pub fn of_round(self, number: u64) -> Self {
        Self(mixed(self.0 ^ mixed(number)))
    }

    /// Goes on with a closest hit. Zeros of both signs are the same parameter.
    pub fn hit<S: Scalar>(&mut self, hit: &Hit<S>) {
        let t = if hit.is_hit() { (hit.t.to_f64() + 0.0).to_bits() } else { 0 };
        self.word(t);
        self.word(u64::from(hit.id));
    }

    pub fn blocked(&mut self, blocked: bool) {
        self.word(u64::from(blocked));
    }

    pub fn word(&mut self, word: u64) {
        self.0 = mixed(self.0.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ word);
    }

    /// Puts rounds together; their order does not matter.
    pub fn add(&mut self, other: Self) {
        self.0 = self.0.wrapping_add(other.0);
    }
}

/// The finalizer of SplitMix64.
fn mixed(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_group_rays_by_octant() {
        let mut random = Random::new(3, "company");
        let rays: Vec<Ray<f32>> = (0..400)
            .map(|_| Ray::new(point(&mut random).as_vec3(), point(&mut random).as_vec3()))
            .collect();
        let batch = CoherentBatch::of(&rays);
        assert_eq!(batch.rays.len(), GROUP * rays.len());
        let mut lanes = [0; GROUP];
        let groups = batch.rays.chunks_exact(GROUP);
        for (i, ((ray, place), group)) in rays.iter().zip(&batch.places).zip(groups).enumerate() {
            assert_eq!((place / GROUP, batch.rays[*place]), (i, *ray));
            lanes[place % GROUP] += 1;
            let like = |other: &&Ray<f32>| {
                other.direction.signum() == ray.direction.signum()
                    && other.direction.distance(ray.direction) <= 0.07 * ray.direction.length()
            };
            assert_eq!(group.iter().filter(like).count(), GROUP);
            assert!(group.iter().any(|other| other != ray));
        }
        assert!(lanes.iter().all(|&n| n > 20), "{lanes:?}");
    }

    fn of(hits: &[(f32, u32)]) -> Digest {
        let mut digest = Digest::default();
        hits.iter().for_each(|&(t, id)| digest.hit(&Hit { t, id }));
        digest
    }

    #[test]
    fn digests_depend_on_every_bit_but_not_on_the_order_of_rounds() {
        let hits = [(1.0, 3), (2.0, 4)];
        assert_eq!(of(&hits), of(&hits));
        let next = 2.0_f32.next_up();
        for other in [[(1.0, 3), (next, 4)], [(1.0, 3), (2.0, 5)], [(2.0, 4), (1.0, 3)]] {
            assert_ne!(of(&hits), of(&other), "{other:?}");
        }
        assert_eq!(of(&[(0.0, 1)]), of(&[(-0.0, 1)]));
        let mut sums = [Digest::default(); 3];
        for (sum, order) in sums.iter_mut().zip([[0, 1], [1, 0], [0, 0]]) {
            order.into_iter().for_each(|number| sum.add(of(&hits).of_round(number)));
        }
        assert!(sums[0] == sums[1] && sums[0] != sums[2]);
    }
}
