//! The timed pass of queries that are not compiled into the traversal: most sets that move, f64 of
//! most structures. It reaches the structure through one dynamic call per ray and traverses with
//! the one [`RelayedSink`], so that it is compiled once for each kind of primitive, not for each
//! structure.

use super::nearby::each_near;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::primitives::PrimSet;
use crate::query::counters::NoCounters;
use crate::query::kernel::{BlockSink, ListBlocks};
use crate::query::mailbox::{MailboxSource, NoMailbox, Setting};
use crate::query::sink::{Answer, Query, RelayedSink, Sink};

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
    /// Answers each ray, with the mailbox of the settings if there is one.
    pub fn all<A: Answer<S>>(&self, rays: &[Ray<S>], answers: &mut [A], mailbox: Option<&Setting>) {
        match mailbox {
            None => self.one_by_one(rays, answers, NoMailbox),
            Some(mailbox) => mailbox.with(|mailbox| self.one_by_one(rays, answers, mailbox)),
        }
    }

    fn one_by_one<A: Answer<S>, B: MailboxSource>(
        &self,
        rays: &[Ray<S>],
        answers: &mut [A],
        mut mailboxes: B,
    ) {
        each_near(self.reach, rays, answers, |ray| {
            let mailbox = mailboxes.next_ray();
            let query = Query::<S, P, NoCounters, A, _>::with_mailbox(self.prims, ray, mailbox);
            self.traversed(ray, query).answer
        });
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
