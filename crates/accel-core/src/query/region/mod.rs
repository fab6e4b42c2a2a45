//! The region query: which primitives may a beam or a cone meet?
//!
//! Beside the question of a ray, which [`crate::query::tracer::Tracer`] answers, some structures
//! answer that of a [`Frustum`]: they visit the cells that it meets, near ones first. In f64 only:
//! what traces frusta computes areas, not crossings.
//!
//! Structures that do so implement [`FrustumTraversal`] and have a line in
//! [`crate::structures::frustum_queries::REGISTRY`].

mod frustum;

pub use frustum::{AxisFrustum, Frustum};

use std::ops::ControlFlow;

use crate::primitives::{Ball, Primitives};
use crate::query::counters::add_fields;
use crate::query::mailbox::{Mailbox, MailboxSource, Stamps};
use crate::structure::{Structure, StructureStats};

/// A built structure that can be asked by frusta.
pub trait FrustumQueries: Send + Sync {
    /// Collects the primitives whose hulls meet the frustum. After each cell, `arrived` is called
    /// with the ids that it added to `candidates` and with a depth ([`Frustum::depth`]) that no
    /// primitive found later begins before, except within cells already visited; it may break the
    /// search off. Every id comes once; whatever meets the frustum in a visited cell is among them.
    fn query_in_order(
        &self,
        frustum: &Frustum,
        candidates: &mut Candidates,
        arrived: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    );

    fn stats(&self) -> StructureStats;

    /// Collects all primitives whose hulls meet the frustum.
    fn query(&self, frustum: &Frustum, candidates: &mut Candidates) {
        self.query_in_order(frustum, candidates, &mut |_, _| ControlFlow::Continue(()));
    }
}

/// Cost of queries; always counted, since beams and cones do far more work with the answer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FrustumWork {
    pub queries: u64,
    pub cells: u64,
    /// Ids in those cells.
    pub references: u64,
    /// Tests of a hull against a frustum: each id once per query.
    pub tests: u64,
    pub found: u64,
}

add_fields!(FrustumWork: queries, cells, references, tests, found);

/// The answer to a query, and the memory that queries share. One for each thread.
#[derive(Debug, Clone, Default)]
pub struct Candidates {
    /// Ids, in the order of the cells.
    pub ids: Vec<u32>,
    /// Total work of all queries so far.
    pub work: FrustumWork,
    /// The ids that a query has seen.
    seen: Stamps,
}

/// Answers [`FrustumQueries`] by the traversal of a structure.
pub(crate) struct BoundFrustumQueries<T> {
    structure: T,
    balls: Vec<Ball>,
    /// `balls[first[id]..first[id + 1]]` are the hull of a primitive.
    first: Vec<u32>,
}

impl<T: FrustumTraversal> BoundFrustumQueries<T> {
    pub(crate) fn new(prims: &dyn Primitives<f64>, structure: T) -> Self {
        let mut balls = Vec::with_capacity(3 * prims.len());
        let mut first = Vec::with_capacity(prims.len() + 1);
        first.push(0);
        for id in 0..prims.len() as u32 {
            prims.hull(id, &mut balls);
            first.push(balls.len() as u32);
        }
        Self { structure, balls, first }
    }
}

impl<T: FrustumTraversal> FrustumQueries for BoundFrustumQueries<T> {
    fn query_in_order(
        &self,
        frustum: &Frustum,
        candidates: &mut Candidates,
        arrived: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    ) {
        let Candidates { ids, work, seen } = candidates;
        ids.clear();
        work.queries += 1;
        seen.hold(self.first.len() - 1);
        let mut seen = seen.next_ray();
        self.structure.traverse_frustum(frustum, &mut |cell, depth| {
            let before = ids.len();
            work.cells += 1;
            work.references += cell.len() as u64;
            for &id in cell {
                if !seen.is_new(id) {
                    continue;
                }
                work.tests += 1;
                let hull = self.first[id as usize] as usize..self.first[id as usize + 1] as usize;
                if frustum.meets_balls(&self.balls[hull]) {
                    ids.push(id);
                }
            }
            work.found += (ids.len() - before) as u64;
            arrived(&ids[before..], depth)
        });
    }

    fn stats(&self) -> StructureStats {
        let hulls = size_of_val(self.balls.as_slice()) + size_of_val(self.first.as_slice());
        let stats = self.structure.stats();
        StructureStats { bytes: stats.bytes + hulls as u64, ..stats }
    }
}

/// A structure that can be traversed by a frustum.
pub trait FrustumTraversal: Structure<f64> {
    /// Calls `cell` with the ids of every cell that the frustum meets, some of them more than once,
    /// and with a depth ([`Frustum::depth`]) that neither this cell nor any later one begins
    /// before. Ends when `cell` breaks.
    fn traverse_frustum(
        &self,
        frustum: &Frustum,
        cell: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    );
}
