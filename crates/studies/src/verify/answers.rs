//! All answers of a tracer to the rays of a round, asked in every way there is: together, counted,
//! alone, and among nearly parallel ones, with which a structure may share work.

use accel_core::primitives::PrimSet;
use accel_core::query::tracer::{ShadowCount, ShadowRule, Tracer};
use accel_core::{Hit, MISS, Ray, Scalar, Vec3, Vector};
use glam::DVec3;

use super::digest::Digest;
use super::draw::{point, unit};
use super::model::Model;
use super::round::NearbyPrimitives;
use statistics::random::Random;

/// One ray in so many is asked by the counting queries as well: they traverse as the others do, and
/// are there to be counted.
pub(super) const COUNTED: usize = 8;

/// The answers to all rays, asked in all ways.
#[derive(Debug, Clone)]
pub(super) struct Answers<S: Scalar> {
    pub(super) closest: Vec<Hit<S>>,
    /// Hits of every [`COUNTED`]th ray.
    pub(super) counted: Vec<Hit<S>>,
    pub(super) blocked: Vec<bool>,
    pub(super) counted_blocked: Vec<bool>,
    /// The closest hits of the same rays, each asked alone; nothing where batches are asked so
    /// anyway.
    pub(super) alone: Vec<Hit<S>>,
    /// The same rays, each among others that run nearly as it does: next to it, then far from it in
    /// the batch.
    pub(super) in_batch: [Vec<(Hit<S>, bool)>; 2],
}

impl<S: Scalar> Answers<S> {
    /// Buffers are preset to wrong answers (blocked where nothing is hit, and vice versa), so that
    /// unwritten answers are wrong.
    pub(super) fn of(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> Self {
        let closest = closest(tracer, rays);
        let mut blocked: Vec<bool> = closest.iter().map(|hit| !hit.is_hit()).collect();
        let preset = |blocked: &bool| ShadowCount { blocked: *blocked, glass: 0 };
        let mut shadows: Vec<_> = blocked.iter().step_by(COUNTED).map(preset).collect();
        tracer.occlusions(rays, &mut blocked);
        let some: Vec<Ray<S>> = rays.iter().copied().step_by(COUNTED).collect();
        let mut counted = vec![unwritten(); some.len()];
        tracer.count_closest_hits(&some, &mut counted);
        tracer.count_occlusions(&some, ShadowRule::OpaqueBlocks, &mut shadows);
        let counted_blocked = shadows.iter().map(|s| s.blocked).collect();
        let (mut alone, mut in_batch) = (Vec::new(), [Vec::new(), Vec::new()]);
        if tracer.batches().are_together() {
            alone = some.chunks(1).flat_map(|one| self::closest(tracer, one)).collect();
            let batch = CoherentBatch::of(&some);
            in_batch = [&batch, &batch.mixed()].map(|batch| Self::in_batch(tracer, batch));
        }
        Self { closest, counted, blocked, counted_blocked, alone, in_batch }
    }

    /// Answers to the rays within the coherent batch.
    fn in_batch(tracer: &dyn Tracer<S>, batch: &CoherentBatch<S>) -> Vec<(Hit<S>, bool)> {
        let hits = closest(tracer, &batch.rays);
        let mut blocked: Vec<bool> = hits.iter().map(|hit| !hit.is_hit()).collect();
        tracer.occlusions(&batch.rays, &mut blocked);
        batch.places.iter().filter_map(|&i| Some((*hits.get(i)?, *blocked.get(i)?))).collect()
    }

    /// By brute force over the primitives near each ray alone.
    pub(super) fn near(model: &Model<S>, rays: &[Ray<S>], near: &NearbyPrimitives) -> Self {
        let nearest = |ray: &Ray<S>, ids: &[u32]| match model {
            Model::Triangles(set) => nearest(set, ray, ids),
            Model::Mixed(set) => nearest(set, ray, ids),
        };
        let ids = near.of.iter().map(|&i| near.lists.get(i).map_or(&[][..], Vec::as_slice));
        let closest: Vec<Hit<S>> = rays.iter().zip(ids).map(|(r, i)| nearest(r, i)).collect();
        // all primitives of such rounds are opaque
        let blocked: Vec<bool> = closest.iter().map(Hit::is_hit).collect();
        Self {
            counted: closest.iter().copied().step_by(COUNTED).collect(),
            counted_blocked: blocked.iter().copied().step_by(COUNTED).collect(),
            alone: Vec::new(),
            in_batch: [Vec::new(), Vec::new()],
            closest,
            blocked,
        }
    }

    /// The closest hits of a ray, however it was asked.
    pub(super) fn hits_of(&self, ray: usize) -> impl Iterator<Item = Hit<S>> {
        let some = ray.is_multiple_of(COUNTED).then_some(ray / COUNTED);
        let of = |hits: &[Hit<S>], i: usize| hits.get(i).copied();
        let batched = |place: usize| some.and_then(|i| Some(self.in_batch[place].get(i)?.0));
        let asked = [
            of(&self.closest, ray),
            some.and_then(|i| of(&self.counted, i)),
            some.and_then(|i| of(&self.alone, i)),
            batched(0),
            batched(1),
        ];
        asked.into_iter().flatten()
    }

    /// Occlusion answers for it, likewise.
    pub(super) fn occlusions_of(&self, ray: usize) -> impl Iterator<Item = bool> {
        let some = ray.is_multiple_of(COUNTED).then_some(ray / COUNTED);
        let asked = [
            self.blocked.get(ray).copied(),
            some.and_then(|i| self.counted_blocked.get(i).copied()),
            some.and_then(|i| Some(self.in_batch[0].get(i)?.1)),
            some.and_then(|i| Some(self.in_batch[1].get(i)?.1)),
        ];
        asked.into_iter().flatten()
    }

    pub(super) fn digest(&self) -> Digest {
        let mut digest = Digest::default();
        self.closest.iter().for_each(|hit| digest.hit(hit));
        self.blocked.iter().for_each(|blocked| digest.blocked(*blocked));
        digest
    }
}

/// The closest hit among these primitives; of equal ones that of the lowest id.
fn nearest<S: Scalar>(prims: &impl PrimSet<S>, ray: &Ray<S>, ids: &[u32]) -> Hit<S> {
    let setup = prims.setup(ray);
    let mut best = Hit { t: ray.t_max, ..Hit::NONE };
    for &id in ids {
        if let Some(t) = prims.intersect(id, ray, &setup, best.t)
            && (t < best.t || id < best.id)
        {
            best = Hit { t, id };
        }
    }
    best
}

/// The closest hits alone.
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
}
