//! The rays that are replayed to every row, whole or thinned, with the answers expected of them.

use std::borrow::Cow;
use std::ops::Range;

use accel_core::occluders::NearestLight;
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar};
use glam::DVec3;
use rayon::prelude::*;
use renderer::{RayBatches, RayKind};

use crate::rays::exactness::{Exactness, is_apart};
use crate::rays::order::{RayOrder, batch_name};

/// Rays that one thread counts at a time and, where each goes alone, traces at a time when there are
/// several threads.
pub const CHUNK: usize = 4096;

#[derive(Debug, Clone)]
pub enum Answers<S: Scalar> {
    Hits(Vec<Hit<S>>),
    Blocked(Vec<bool>),
}

/// Stands where no hit was written: no ray has it.
fn unwritten<S: Scalar>() -> Hit<S> {
    Hit { t: S::from_f64(f64::NAN), id: 0 }
}

impl<S: Scalar> Answers<S> {
    /// Room for the answers of `n` rays. What nobody writes is nobody's answer: a hit that has no
    /// parameter; of occlusions, blocked and not in turns.
    pub fn new(kind: RayKind, n: usize) -> Self {
        if kind.is_occlusion() {
            Self::Blocked((0..n).map(|i| i.is_multiple_of(2)).collect())
        } else {
            Self::Hits(vec![unwritten(); n])
        }
    }

    /// Indices of the rays that were answered differently. Closest hits must agree in the id and
    /// in every bit of t: all structures use the same primitive tests and the same rule for ties.
    pub fn differing<'a>(&'a self, other: &'a Self) -> Box<dyn Iterator<Item = usize> + 'a> {
        match (self, other) {
            (Self::Hits(a), Self::Hits(b)) => {
                let differ = |(x, y): (&Hit<S>, &Hit<S>)| {
                    x.id != y.id || x.t.to_f64().to_bits() != y.t.to_f64().to_bits()
                };
                indices(a.iter().zip(b).map(differ))
            }
            (Self::Blocked(a), Self::Blocked(b)) => indices(a.iter().zip(b).map(|(x, y)| x != y)),
            (Self::Hits(a), Self::Blocked(_)) => Box::new(0..a.len()),
            (Self::Blocked(a), Self::Hits(_)) => Box::new(0..a.len()),
        }
    }

    /// The answer to ray `i`, in words.
    pub fn describe(&self, i: usize) -> String {
        match self {
            Self::Hits(hits) => match hits.get(i) {
                Some(hit) if hit.is_hit() => format!("primitive {} at t = {}", hit.id, hit.t),
                _ => "no hit".into(),
            },
            Self::Blocked(blocked) => match blocked.get(i) {
                Some(true) => "blocked".into(),
                _ => "not blocked".into(),
            },
        }
    }

    /// Makes every answer another one, so that what is not written again shows: hits become one
    /// that has no parameter, the others their opposites.
    pub fn clear(&mut self) {
        match self {
            Self::Hits(hits) => hits.fill(unwritten()),
            Self::Blocked(blocked) => blocked.iter_mut().for_each(|b| *b = !*b),
        }
    }

    /// Makes every answer one that is not expected, so that neither those of the row before nor
    /// those that nobody writes pass for right ones.
    pub fn poison(&mut self, expected: &Self) {
        if let (Self::Blocked(blocked), Self::Blocked(expected)) = (&mut *self, expected) {
            blocked.clone_from(expected);
        }
        self.clear();
    }

    /// Bytes that are equal if and only if no answer differs: id and bits of `t`, or blocked.
    pub fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Hits(hits) => {
                let of = |hit: &Hit<S>| {
                    let t = hit.t.to_f64().to_bits().to_le_bytes();
                    t.into_iter().chain(hit.id.to_le_bytes())
                };
                hits.iter().flat_map(of).collect()
            }
            Self::Blocked(blocked) => blocked.iter().map(|&b| u8::from(b)).collect(),
        }
    }

    /// The answers at those places, in that order.
    pub fn picked(&self, places: impl Iterator<Item = usize>) -> Self {
        match self {
            Self::Hits(hits) => Self::Hits(places.filter_map(|i| hits.get(i).copied()).collect()),
            Self::Blocked(all) => {
                Self::Blocked(places.filter_map(|i| all.get(i).copied()).collect())
            }
        }
    }

    /// Replaces the answer to ray `i` by that one.
    pub fn set(&mut self, i: usize, one: &Self) {
        match (self, one) {
            (Self::Hits(hits), Self::Hits(one)) => {
                hits.iter_mut().skip(i).zip(one).for_each(|(hit, one)| *hit = *one);
            }
            (Self::Blocked(all), Self::Blocked(one)) => {
                all.iter_mut().skip(i).zip(one).for_each(|(blocked, one)| *blocked = *one);
            }
            _ => {}
        }
    }

    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        match self {
            Self::Hits(hits) => hits.len(),
            Self::Blocked(blocked) => blocked.len(),
        }
    }
}

fn indices<'a>(differ: impl Iterator<Item = bool> + 'a) -> Box<dyn Iterator<Item = usize> + 'a> {
    Box::new(differ.enumerate().filter_map(|(i, d)| d.then_some(i)))
}

/// Rays of one kind and the answers expected.
#[derive(Debug, Clone)]
pub struct Batch<'a, S: Scalar> {
    pub kind: RayKind,
    pub order: RayOrder,
    pub rays: Cow<'a, [Ray<S>]>,
    /// The light that each shadow ray runs to; empty for other kinds.
    pub lights: Vec<u32>,
    pub expected: Answers<S>,
}

impl<S: Buildable> Batch<'_, S> {
    pub fn name(&self) -> String {
        batch_name(self.kind.name(), self.order)
    }

    /// Room for the answers, none of which is the one expected.
    pub fn unexpected(&self) -> Answers<S> {
        let mut answers = Answers::new(self.kind, self.rays.len());
        answers.poison(&self.expected);
        answers
    }

    /// Indices of the rays that were answered otherwise than expected, as far as answers must
    /// agree. To the last bit nearly all answers of another primitive test would be wrong.
    pub fn wrong<'b>(
        &'b self,
        answers: &'b Answers<S>,
        exactness: Exactness,
    ) -> Box<dyn Iterator<Item = usize> + 'b> {
        match (answers, &self.expected) {
            (Answers::Hits(own), Answers::Hits(expected)) if exactness.has_own_test() => {
                let pairs = own.iter().zip(expected).zip(self.rays.iter());
                indices(pairs.map(move |((own, expected), ray)| {
                    is_apart(own, expected, ray)
                        || exactness == Exactness::OwnTest && own.id != expected.id
                }))
            }
            (answers, expected) => answers.differing(expected),
        }
    }

    /// Returns whether the answer to ray `i` is another than the one expected by more than
    /// rounding, or than the name of a primitive.
    pub fn is_apart(&self, answers: &Answers<S>, i: usize) -> bool {
        match (answers, &self.expected) {
            (Answers::Hits(own), Answers::Hits(expected)) => {
                match (own.get(i), expected.get(i), self.rays.get(i)) {
                    (Some(own), Some(expected), Some(ray)) => is_apart(own, expected, ray),
                    _ => true,
                }
            }
            _ => true,
        }
    }

    /// The same rays, not copied.
    pub fn borrowed(&self) -> Batch<'_, S> {
        self.window(0..self.rays.len())
    }

    /// The rays at those places, not copied.
    pub fn window(&self, places: Range<usize>) -> Batch<'_, S> {
        let rays = self.rays.get(places.clone()).unwrap_or_default();
        self.of_places(rays.into(), places)
    }

    pub fn thinned(&self, stride: usize) -> Batch<'_, S> {
        match stride {
            1 => self.borrowed(),
            _ => self.picked((0..self.rays.len()).step_by(stride)),
        }
    }

    /// The rays at those places, in that order.
    pub fn picked<'b>(&self, places: impl Iterator<Item = usize> + Clone) -> Batch<'b, S> {
        let rays = places.clone().filter_map(|i| self.rays.get(i).copied()).collect();
        self.of_places(rays, places)
    }

    fn of_places<'b>(
        &self,
        rays: Cow<'b, [Ray<S>]>,
        places: impl Iterator<Item = usize> + Clone,
    ) -> Batch<'b, S> {
        let lights = places.clone().filter_map(|i| self.lights.get(i).copied()).collect();
        let expected = self.expected.picked(places);
        Batch { kind: self.kind, order: self.order, rays, lights, expected }
    }
}

/// Rays of all kinds of a run: every `stride`-th of the scene's.
#[derive(Debug, Clone)]
pub struct BatchSet<'a, S: Scalar> {
    /// 1 for all rays.
    pub stride: usize,
    /// One batch a kind and order, kinds without rays left out.
    pub batches: Vec<Batch<'a, S>>,
}

impl<'a, S: Buildable> BatchSet<'a, S> {
    /// All rays that were answered, as the image has them, in a scene with lights at those places.
    pub fn new(
        rays: &'a RayBatches<S>,
        answers: Vec<(RayKind, Answers<S>)>,
        lights: &[DVec3],
    ) -> Self {
        let nearest = NearestLight::new(lights);
        let batch = |(kind, expected): (RayKind, _)| {
            let rays = rays.rays(kind);
            let to_lights = if kind.is_occlusion() { rays } else { &[] };
            let lights = nearest.of_each(to_lights);
            Batch { kind, order: RayOrder::Scanline, rays: rays.into(), lights, expected }
        };
        Self { stride: 1, batches: answers.into_iter().map(batch).collect() }
    }

    /// Every `stride`-th ray of each kind.
    pub fn thinned(&self, stride: usize) -> BatchSet<'_, S> {
        BatchSet { stride, batches: self.batches.iter().map(|b| b.thinned(stride)).collect() }
    }

    pub fn restricted(&self, keep: impl Fn(RayKind) -> bool) -> BatchSet<'_, S> {
        let kept = self.batches.iter().filter(|b| keep(b.kind));
        BatchSet { stride: self.stride, batches: kept.map(Batch::borrowed).collect() }
    }

    pub fn total(&self) -> usize {
        self.batches.iter().map(|b| b.rays.len()).sum()
    }

    pub fn longest(&self) -> usize {
        self.batches.iter().map(|b| b.rays.len()).max().unwrap_or(0)
    }

    pub fn answers(&self) -> Vec<Answers<S>> {
        self.batches.iter().map(|b| Answers::new(b.kind, b.rays.len())).collect()
    }
}

/// The answers of `tracer` to all rays of the kinds, kinds without rays left out. Runs in the
/// current rayon pool.
pub fn answer<S: Buildable>(
    rays: &RayBatches<S>,
    kinds: &[RayKind],
    tracer: &dyn Tracer<S>,
) -> Vec<(RayKind, Answers<S>)> {
    let with_rays = kinds.iter().filter(|kind| !rays.rays(**kind).is_empty());
    let answered = with_rays.map(|&kind| {
        let rays = rays.rays(kind);
        let mut answers = Answers::new(kind, rays.len());
        trace_chunked(tracer, rays, &mut answers);
        (kind, answers)
    });
    answered.collect()
}

pub fn trace<S: Scalar>(tracer: &dyn Tracer<S>, rays: &[Ray<S>], answers: &mut Answers<S>) {
    match answers {
        Answers::Hits(hits) => tracer.closest_hits(rays, hits),
        Answers::Blocked(blocked) => tracer.occlusions(rays, blocked),
    }
}

/// Traces a batch in chunks over the current rayon pool. Where rays go together a chunk is an eighth
/// of a thread's share: the more rays, the more of them run alike.
pub fn trace_chunked<S: Scalar>(tracer: &dyn Tracer<S>, rays: &[Ray<S>], answers: &mut Answers<S>) {
    let eighth = rays.len().div_ceil(8 * rayon::current_num_threads()).next_multiple_of(CHUNK);
    let chunk = if tracer.batches().are_together() { eighth.max(CHUNK) } else { CHUNK };
    match answers {
        Answers::Hits(hits) => rays
            .par_chunks(chunk)
            .zip(hits.par_chunks_mut(chunk))
            .for_each(|(rays, hits)| tracer.closest_hits(rays, hits)),
        Answers::Blocked(blocked) => rays
            .par_chunks(chunk)
            .zip(blocked.par_chunks_mut(chunk))
            .for_each(|(rays, blocked)| tracer.occlusions(rays, blocked)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_differ_in_id_and_in_bits_of_t() {
        let hits = |v: &[(f32, u32)]| {
            Answers::Hits(v.iter().map(|&(t, id)| Hit { t, id }).collect::<Vec<_>>())
        };
        let a = hits(&[(1.0, 0), (1.0, 1), (2.0, 2)]);
        let b = hits(&[(1.0, 0), (1.0, 2), (2.0_f32.next_up(), 2)]);
        assert_eq!(a.differing(&b).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(a.bytes(), a.clone().bytes());
        assert_ne!(a.bytes(), b.bytes());
        assert_eq!(a.bytes()[..12], b.bytes()[..12]);
        let p: Answers<f32> = Answers::Blocked(vec![true, false]);
        let q = Answers::Blocked(vec![true, true]);
        assert_eq!(p.differing(&q).collect::<Vec<_>>(), [1]);
    }

    #[test]
    fn rounding_of_a_foreign_triangle_test_is_not_wrong() {
        let hit = |t: f32, id| Hit { t, id };
        let expected = vec![hit(1.0, 0), hit(2.0, 1), hit(3.0, 2), Hit::NONE, hit(5.0, 4)];
        let ray = Ray::new([1.0f32, 0.0, 0.0].into(), [0.0, 0.0, 2.0].into());
        let batch = Batch {
            kind: RayKind::Primary,
            order: RayOrder::Scanline,
            rays: vec![ray; 5].into(),
            lights: Vec::new(),
            expected: Answers::Hits(expected.clone()),
        };
        let wrong = |answers: &[Hit<f32>], by_library: bool| {
            let by_library = if by_library { Exactness::Library } else { Exactness::Bits };
            let answers = Answers::Hits(answers.to_vec());
            batch.wrong(&answers, by_library).collect::<Vec<_>>()
        };
        assert!(wrong(&expected, true).is_empty() && wrong(&expected, false).is_empty());
        // the last bits, and a neighbour at the same place
        let mut near = expected.clone();
        near[0].t = 1.00001;
        near[1] = hit(2.0f32.next_up(), 7);
        assert_eq!((wrong(&near, true), wrong(&near, false)), (vec![], vec![0, 1]));
        // planted faults: a hole, an invented hit, one behind, one that nobody wrote
        let bad = [hit(1.001, 0), Hit::NONE, hit(3.0, 2), hit(9.0, 3), unwritten()];
        assert_eq!(wrong(&bad, true), [0, 1, 3, 4]);
    }

    #[test]
    fn poisoned_answers_differ_from_every_answer() {
        let hits = vec![Hit::NONE, Hit { t: -1.0, id: 0 }, Hit { t: 1.0, id: 3 }];
        let a: Answers<f32> = Answers::Hits(hits);
        let mut b = a.clone();
        b.poison(&a);
        assert_eq!(a.differing(&b).count(), 3);
        let a: Answers<f32> = Answers::Blocked(vec![true, false, true]);
        let mut b = a.clone();
        b.poison(&a);
        assert_eq!(a.differing(&b).count(), 3);
        // two passes in which nobody writes differ
        a.clone_into(&mut b);
        b.clear();
        assert_eq!(a.differing(&b).count(), 3);
    }
}
