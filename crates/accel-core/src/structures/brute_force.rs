//! Every primitive for every ray: the oracle, and the baseline of all baselines.

use std::ops::ControlFlow;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::config::Settings;
use crate::primitives::Primitives;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::region::{Frustum, FrustumTraversal};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats};

pub static INFO: StructureInfo = StructureInfo {
    sampled: true,
    ..StructureInfo::new("brute-force", "tests every primitive for every ray; the oracle in f64")
};

/// One list of all ids.
pub struct BruteForce<S> {
    ids: Vec<u32>,
    scalar: std::marker::PhantomData<S>,
}

impl FrustumTraversal for BruteForce<f64> {
    fn traverse_frustum(&self, _: &Frustum, cell: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>) {
        let _ = cell(&self.ids, f64::NEG_INFINITY);
    }
}

impl<S: Scalar> Structure<S> for BruteForce<S> {
    const DUPLICATES: bool = false;

    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        Ok(Self { ids: (0..prims.len() as u32).collect(), scalar: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, _: &Ray<S>, sink: &mut K) {
        sink.elementary_step(self.ids.is_empty());
        let _ = sink.test(&self.ids);
    }

    fn stats(&self) -> StructureStats {
        StructureStats {
            cells: 1,
            references: self.ids.len() as u64,
            bytes: self.ids.len() as u64 * 4,
            ..StructureStats::default()
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        each(Cell::elementary(Aabb::<S>::everything(), 0, &self.ids));
        Ok(())
    }
}
