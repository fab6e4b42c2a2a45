//! A structure with the hulls of its primitives: what a shaft meets, each primitive once.

use std::ops::ControlFlow;

use crate::primitives::{Ball, PrimSet};
use crate::query::region::{Shaft, ShaftWalk};
use crate::structure::Shape;

/// A built structure that can be asked by shafts.
pub trait Gatherer: Send + Sync {
    /// Collects the primitives whose hulls meet the shaft. After each cell, `arrived` is called
    /// with the ids that it added to `gathered` and with a depth ([`Shaft::depth`]) that no
    /// primitive found later begins before, except within cells already visited; it may break the
    /// search off. Every id comes once; whatever meets the shaft in a visited cell is among them.
    fn gather_in_order(
        &self,
        shaft: &Shaft,
        gathered: &mut Gathered,
        arrived: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    );

    /// What was built.
    fn shape(&self) -> Shape;

    /// Collects all primitives whose hulls meet the shaft.
    fn gather(&self, shaft: &Shaft, gathered: &mut Gathered) {
        self.gather_in_order(shaft, gathered, &mut |_, _| ControlFlow::Continue(()));
    }
}

/// What queries cost, counted always: it is small beside what beams and cones do with the answer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Work {
    /// Queries.
    pub shafts: u64,
    /// Cells visited.
    pub cells: u64,
    /// Ids in those cells.
    pub references: u64,
    /// Tests of a hull against a shaft: each id once a query.
    pub tests: u64,
    /// Primitives found.
    pub found: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.shafts += other.shafts;
        self.cells += other.cells;
        self.references += other.references;
        self.tests += other.tests;
        self.found += other.found;
    }
}

/// The answer to a query, and the memory that queries share. One for each thread.
#[derive(Debug, Clone, Default)]
pub struct Gathered {
    /// Ids, in the order of the cells.
    pub ids: Vec<u32>,
    /// What all queries so far have cost.
    pub work: Work,
    /// Number of the last query that saw an id.
    stamps: Vec<u32>,
    query: u32,
}

impl Gathered {
    fn begin(&mut self, primitives: usize) {
        self.ids.clear();
        self.work.shafts += 1;
        self.query = self.query.wrapping_add(1);
        if self.stamps.len() != primitives || self.query == 0 {
            self.stamps.clear();
            self.stamps.resize(primitives, 0);
            self.query = 1;
        }
    }
}

/// The one implementation of [`Gatherer`].
pub(crate) struct BoundGatherer<T> {
    structure: T,
    balls: Vec<Ball>,
    /// `balls[first[id]..first[id + 1]]` are the hull of a primitive.
    first: Vec<u32>,
}

impl<T: ShaftWalk> BoundGatherer<T> {
    pub(crate) fn new<P: PrimSet<f64>>(prims: &P, structure: T) -> Self {
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

impl<T: ShaftWalk> Gatherer for BoundGatherer<T> {
    fn gather_in_order(
        &self,
        shaft: &Shaft,
        gathered: &mut Gathered,
        arrived: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    ) {
        gathered.begin(self.first.len() - 1);
        let Gathered { ids, work, stamps, query } = gathered;
        self.structure.walk_shaft(shaft, &mut |cell, depth| {
            let before = ids.len();
            work.cells += 1;
            work.references += cell.len() as u64;
            for &id in cell {
                let stamp = &mut stamps[id as usize];
                if *stamp == *query {
                    continue;
                }
                *stamp = *query;
                work.tests += 1;
                let hull = self.first[id as usize] as usize..self.first[id as usize + 1] as usize;
                if shaft.meets_balls(&self.balls[hull]) {
                    ids.push(id);
                }
            }
            work.found += (ids.len() - before) as u64;
            arrived(&ids[before..], depth)
        });
    }

    fn shape(&self) -> Shape {
        let hulls = size_of_val(self.balls.as_slice()) + size_of_val(self.first.as_slice());
        let shape = self.structure.shape();
        Shape { bytes: shape.bytes + hulls as u64, ..shape }
    }
}
