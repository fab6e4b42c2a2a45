//! A built structure as an object: one dynamic call for a batch of rays, everything inside static.

use crate::counters::{Counters, NoCounters, WorkCounters};
use crate::mailbox::{AnyMailbox, MailboxSource, NoMailbox, Setting};
use crate::primitives::PrimSet;
use crate::ray::{Hit, Ray};
use crate::scalar::Scalar;
use crate::sink::{AnyHit, ClosestHit, HistoricalShadow};
use crate::structures::{Shape, Structure};

/// What a shadow ray of the counting pass does; the historical rule is explained in
/// `results/published/README.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadowRule {
    /// Stops at the first opaque hit; transmissive primitives are ignored.
    OpaqueBlocks,
    /// As Havran and Sixta counted: glass that was hit is remembered and not tested again.
    Historical,
}

/// Answers of one historical shadow ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShadowCount {
    /// An opaque primitive is in the way.
    pub blocked: bool,
    /// Distinct transmissive primitives hit before the walk ended.
    pub glass: u32,
}

/// A structure with the primitives it was built over.
///
/// Output slices must be as long as `rays`; longer inputs are cut to the shorter of both.
pub trait Tracer<S: Scalar>: Send + Sync {
    /// The closest hit of every ray.
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]);
    /// Whether every ray is blocked by an opaque primitive.
    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]);
    /// [`Tracer::closest_hits`], counting the work.
    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters;
    /// [`Tracer::occlusions`], counting the work.
    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters;
    /// What was built.
    fn shape(&self) -> Shape;
}

/// The one implementation of [`Tracer`].
pub struct Bound<'a, P, T> {
    prims: &'a P,
    structure: T,
    mailbox: Setting,
}

impl<'a, P, T> Bound<'a, P, T> {
    /// Joins a structure with the primitives it was built over.
    pub fn new(prims: &'a P, structure: T) -> Self {
        Self { prims, structure, mailbox: Setting::None }
    }

    /// The same with a mailbox.
    pub fn with_mailbox(self, mailbox: Setting) -> Self {
        Self { mailbox, ..self }
    }

    /// Closest hits with one kind of mailbox and counters; `done` is told what each ray took.
    #[inline(always)]
    fn closest<S: Scalar, C: Counters>(
        &self,
        rays: &[Ray<S>],
        hits: &mut [Hit<S>],
        mut mailboxes: impl MailboxSource,
        mut done: impl FnMut(C),
    ) where
        P: PrimSet<S>,
        T: Structure<S>,
    {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = Hit { t: ray.t_max, ..Hit::NONE };
            if ray.is_traceable() {
                let mailbox = mailboxes.next_ray();
                let mut sink = ClosestHit::<S, P, C, _>::with_mailbox(self.prims, ray, mailbox);
                self.structure.walk(ray, &mut sink);
                let (found, counters) = sink.finish();
                *hit = found;
                done(counters);
            }
        }
    }

    /// Whether each ray is blocked, likewise.
    #[inline(always)]
    fn blocked<S: Scalar, C: Counters>(
        &self,
        rays: &[Ray<S>],
        mut mailboxes: impl MailboxSource,
        mut done: impl FnMut(usize, bool, C),
    ) where
        P: PrimSet<S>,
        T: Structure<S>,
    {
        for (i, ray) in rays.iter().enumerate() {
            if ray.is_traceable() {
                let mailbox = mailboxes.next_ray();
                let mut sink = AnyHit::<S, P, C, _>::with_mailbox(self.prims, ray, mailbox);
                self.structure.walk(ray, &mut sink);
                let (blocked, counters) = sink.finish();
                done(i, blocked, counters);
            }
        }
    }
}

impl<S: Scalar, P: PrimSet<S>, T: Structure<S>> Tracer<S> for Bound<'_, P, T> {
    fn closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) {
        if !T::DUPLICATES || matches!(self.mailbox, Setting::None) {
            return self.closest(rays, hits, NoMailbox, |_: NoCounters| {});
        }
        self.mailbox.with(|mailbox| match mailbox {
            AnyMailbox::None => {}
            AnyMailbox::Stamps(stamps) => self.closest(rays, hits, stamps, |_: NoCounters| {}),
            AnyMailbox::Slots(slots) => self.closest(rays, hits, slots, |_: NoCounters| {}),
        });
    }

    fn occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool]) {
        let n = rays.len().min(blocked.len());
        let (rays, blocked) = (&rays[..n], &mut blocked[..n]);
        blocked.fill(false);
        let mut done = |i: usize, is_blocked, _: NoCounters| blocked[i] = is_blocked;
        if !T::DUPLICATES || matches!(self.mailbox, Setting::None) {
            return self.blocked(rays, NoMailbox, done);
        }
        self.mailbox.with(|mailbox| match mailbox {
            AnyMailbox::None => {}
            AnyMailbox::Stamps(stamps) => self.blocked(rays, stamps, &mut done),
            AnyMailbox::Slots(slots) => self.blocked(rays, slots, &mut done),
        });
    }

    fn count_closest_hits(&self, rays: &[Ray<S>], hits: &mut [Hit<S>]) -> WorkCounters {
        let mut total = WorkCounters::default();
        self.mailbox.with(|mailbox| self.closest(rays, hits, mailbox, |c| total += c));
        total
    }

    fn count_occlusions(
        &self,
        rays: &[Ray<S>],
        rule: ShadowRule,
        answers: &mut [ShadowCount],
    ) -> WorkCounters {
        let mut total = WorkCounters::default();
        let n = rays.len().min(answers.len());
        let (rays, answers) = (&rays[..n], &mut answers[..n]);
        answers.fill(ShadowCount { blocked: false, glass: 0 });
        match rule {
            ShadowRule::OpaqueBlocks => self.mailbox.with(|mailbox| {
                self.blocked(rays, mailbox, |i, blocked, counters| {
                    answers[i].blocked = blocked;
                    total += counters;
                });
            }),
            ShadowRule::Historical => {
                for (ray, answer) in rays.iter().zip(answers).filter(|(r, _)| r.is_traceable()) {
                    let mut sink = HistoricalShadow::<S, P, WorkCounters>::new(self.prims, ray);
                    self.structure.walk(ray, &mut sink);
                    let (blocked, glass, counters) = sink.finish();
                    *answer = ShadowCount { blocked, glass: glass as u32 };
                    total += counters;
                }
            }
        }
        total
    }

    fn shape(&self) -> Shape {
        let shape = self.structure.shape();
        Shape { bytes: shape.bytes + self.mailbox.bytes(), ..shape }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mailbox::{Slots, Stamps};
    use crate::params::Params;
    use crate::structures::test_scenes::{built, hard_scenes, mixed_scene, rays, work};
    use crate::structures::uniform_grid::{INFO, UniformGrid};
    use crate::structures::{find, uniform_grid};

    #[test]
    fn ray_numbers_may_wrap() {
        // HARD_CASES Gr8: 8-bit numbers, more than 1,000 rays, down to one slot
        let set = mixed_scene::<f64>(200, 21, [1.0; 3]);
        let rays = rays(&set, 1500, 22);
        let params = Params::new("uniform-grid", INFO.params, [("density", "8")]).unwrap();
        let grid = UniformGrid::build(&set, &params).unwrap();
        let bound = Bound::new(&set, grid);
        let mut expected = vec![Hit::NONE; rays.len()];
        bound.closest_hits(&rays, &mut expected);
        let mut saved = Vec::new();
        let mut check =
            |name: &str, mailbox: &mut dyn FnMut(&mut [Hit<f64>], &mut WorkCounters)| {
                let (mut hits, mut total) = (vec![Hit::NONE; rays.len()], WorkCounters::default());
                mailbox(&mut hits, &mut total);
                assert_eq!(hits, expected, "{name}");
                saved.push(total.tests_saved);
            };
        let mut stamps = Stamps::<u8>::dense(200);
        check("dense", &mut |h, c| bound.closest(&rays, h, &mut stamps, |x| *c += x));
        let mut stamps = Stamps::<u8>::in_records(200, 40);
        check("records", &mut |h, c| bound.closest(&rays, h, &mut stamps, |x| *c += x));
        let mut stamps = Stamps::<u32>::dense(200);
        check("u32", &mut |h, c| bound.closest(&rays, h, &mut stamps, |x| *c += x));
        let mut slots = Slots::<u8>::new(1 << 12);
        check("many slots", &mut |h, c| bound.closest(&rays, h, &mut slots, |x| *c += x));
        let mut slots = Slots::<u8>::new(1);
        check("one slot", &mut |h, c| bound.closest(&rays, h, &mut slots, |x| *c += x));
        assert!(saved[0] > 0 && saved[..4].iter().all(|&s| s == saved[0]), "{saved:?}");
        assert!(saved[4] < saved[0], "{saved:?}");
    }

    #[test]
    fn mailboxes_change_no_answer_and_account_for_every_test() {
        let entry = find(uniform_grid::INFO.name).unwrap();
        for (scene, set) in hard_scenes::<f32>() {
            let rays = rays(&set, if scene == "duplicates" { 60 } else { 1500 }, 23);
            let (hits, blocked, closest, _) = work(built(entry, &set, "density=8").as_ref(), &rays);
            assert_eq!(closest.tests_saved, 0);
            for mailbox in ["primitive", "array", "hash", "hash mailbox-slots=1"] {
                let settings = format!("density=8 mailbox={mailbox}");
                let got = work(built(entry, &set, &settings).as_ref(), &rays);
                assert!(got.0 == hits && got.1 == blocked, "{settings} {scene}");
                let tests = got.2.intersection_tests + got.2.tests_saved;
                assert_eq!(tests, closest.intersection_tests, "{settings} {scene}");
                assert_eq!(got.2.traversal_steps, closest.traversal_steps);
                if scene == "cube" && !mailbox.contains('=') {
                    assert!(got.2.tests_saved > 0, "{settings}");
                }
            }
        }
    }

    #[test]
    fn threads_share_a_mailbox_without_harm() {
        let set = mixed_scene::<f32>(200, 24, [1.0; 3]);
        let rays = rays(&set, 600, 25);
        let entry = find(uniform_grid::INFO.name).unwrap();
        let mut expected = vec![Hit::NONE; rays.len()];
        built(entry, &set, "density=8").closest_hits(&rays, &mut expected);
        for mailbox in ["primitive", "array", "hash"] {
            let tracer = built(entry, &set, &format!("density=8 mailbox={mailbox}"));
            std::thread::scope(|scope| {
                for _ in 0..4 {
                    scope.spawn(|| {
                        for part in [7, 100, 600] {
                            for (r, e) in rays.chunks(part).zip(expected.chunks(part)) {
                                let mut hits = vec![Hit::NONE; r.len()];
                                tracer.closest_hits(r, &mut hits);
                                assert_eq!(hits, e, "{mailbox}");
                            }
                        }
                    });
                }
            });
        }
    }
}
