//! The timed pass of queries that are not compiled into the traversal: most sets that move, f64 of
//! most structures. It reaches the structure through one dynamic call per ray and traverses with
//! the one [`RelayedSink`], so that it is compiled once for each kind of primitive, not for each
//! structure.

use super::nearby::{closest, near};
use crate::geometry::ray::{Hit, Ray};
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::counters::NoCounters;
use crate::query::kernel::{BlockSink, ListBlocks};
use crate::query::mailbox::{MailboxSource, NoMailbox, Setting};
use crate::query::sink::{AnyHit, ClosestHit, RelayedSink, Sink};

/// A structure's traversal with the primitives it was built over.
pub(super) struct TimingTracer<'a, S: Scalar, P> {
    pub prims: &'a P,
    /// How far origins may be; see [`crate::geometry::far_ray`].
    pub reach: S,
    pub traversal: &'a dyn Fn(&Ray<S>, RelayedSink<'_, S>),
    /// The blocks of its lists, where it has some.
    pub blocks: &'a dyn Fn(&Ray<S>) -> Option<&'a ListBlocks<S>>,
}

impl<S: Scalar, P: PrimSet<S>> TimingTracer<'_, S, P> {
    /// [`TimingTracer::closest_hits`] with the mailbox of the settings, if there is one.
    pub fn all_closest(&self, rays: &[Ray<S>], hits: &mut [Hit<S>], mailbox: Option<&Setting>) {
        match mailbox {
            None => self.closest_hits(rays, hits, NoMailbox),
            Some(mailbox) => mailbox.with(|mailbox| self.closest_hits(rays, hits, mailbox)),
        }
    }

    /// [`TimingTracer::occlusions`] with the mailbox of the settings, if there is one.
    pub fn all_occlusions(&self, rays: &[Ray<S>], blocked: &mut [bool], mailbox: Option<&Setting>) {
        match mailbox {
            None => self.occlusions(rays, blocked, NoMailbox),
            Some(mailbox) => mailbox.with(|mailbox| self.occlusions(rays, blocked, mailbox)),
        }
    }

    /// The closest hit of every ray.
    fn closest_hits<B: MailboxSource>(&self, rays: &[Ray<S>], hits: &mut [Hit<S>], mailboxes: B) {
        closest::<S, B>(self.reach, rays, hits, mailboxes, |ray, mailbox| {
            let query = ClosestHit::<S, P, NoCounters, _>::with_mailbox(self.prims, ray, mailbox);
            self.traversed(ray, query).finish().0
        });
    }

    /// Writes for each ray whether it is blocked.
    fn occlusions<B: MailboxSource>(
        &self,
        rays: &[Ray<S>],
        blocked: &mut [bool],
        mut mailboxes: B,
    ) {
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = near(self.reach, ray, false, |ray, _| {
                let mailbox = mailboxes.next_ray();
                let query = AnyHit::<S, P, NoCounters, _>::with_mailbox(self.prims, ray, mailbox);
                self.traversed(ray, query).finish().0
            });
        }
    }

    /// The query after the traversal.
    #[inline(always)]
    fn traversed<K: Sink<S>>(&self, ray: &Ray<S>, mut query: K) -> K {
        match (self.blocks)(ray) {
            Some(blocks) => {
                let mut sink = BlockSink::new(blocks, &mut query);
                (self.traversal)(ray, RelayedSink::new(&mut sink));
            }
            None => (self.traversal)(ray, RelayedSink::new(&mut query)),
        }
        query
    }
}
