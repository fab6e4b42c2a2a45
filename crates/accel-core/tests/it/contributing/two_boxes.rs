//! Two boxes: the primitives, halved along the longest axis of the scene, each half in its box.
//!
//! Paper: none; the smallest structure that is worth traversing, as an example.
//! Deviations: none.

use accel_core::Aabb;
use accel_core::historical::bounds_rule::{BoundsOf, BoundsRule};
use accel_core::params::ParamSpec;
use accel_core::params::config::Settings;
use accel_core::primitives::Primitives;
use accel_core::query::cells::{Cell, CellVisitor, NoCells};
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats, no_defect};
use accel_core::{Ray, Scalar, Vector, config};

config! {
    /// How the scene is halved.
    pub struct TwoBoxesConfig {
        /// part of the primitives that goes into the first box
        share: f64 = ParamSpec::real("share", "0.5", 0.0, 1.0),
    }
}

/// Registry line.
pub static INFO: StructureInfo = StructureInfo {
    name: "two-boxes",
    summary: "two lists of primitives, each skipped by rays that miss its box",
    paper: "none",
    deviations: "none",
    params: TwoBoxesConfig::PARAMS,
    variants: &[""],
    also_tested: &["share=0", "share=0.9"],
    known_defect: no_defect,
    sampled: true,
};

/// Both halves.
pub struct TwoBoxes<S: Scalar> {
    halves: [(Aabb<S>, Vec<u32>); 2],
}

impl<S: Scalar> Structure<S> for TwoBoxes<S> {
    // no id is in both lists: mailboxes have nothing to spare
    const DUPLICATES: bool = false;

    type Config = TwoBoxesConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<TwoBoxesConfig>,
    ) -> Result<Self, BuildError> {
        // padded boxes: rounding must not lose a hit
        let boxes = BoundsOf::new(prims, BoundsRule::Padded)
            .map_err(|id| BuildError::NonFiniteBounds { structure: settings.structure(), id })?;
        let size = boxes.scene().size().to_array();
        let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let mut ids: Vec<u32> = (0..prims.len() as u32).collect();
        let low = |id: &u32| boxes.of(*id).min.to_array()[axis].to_f64();
        ids.sort_by(|a, b| low(a).total_cmp(&low(b)));
        let first = (settings.share * ids.len() as f64) as usize;
        let second = ids.split_off(first);
        let around =
            |ids: Vec<u32>| (ids.iter().fold(Aabb::empty(), |b, &id| b.union(boxes.of(id))), ids);
        Ok(Self { halves: [around(ids), around(second)] })
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        for (bounds, ids) in &self.halves {
            sink.elementary_step(ids.is_empty());
            // no further than the best hit so far: the sink knows it
            let enters = bounds.clip(ray.origin, ray.direction, ray.t_min, sink.t_max());
            if enters.is_some() && sink.test(ids).is_break() {
                return;
            }
        }
    }

    fn stats(&self) -> StructureStats {
        let lengths = self.halves.each_ref().map(|(_, ids)| ids.len() as u64);
        StructureStats {
            cells: 2,
            empty_cells: lengths.iter().filter(|&&n| n == 0).count() as u64,
            references: lengths.iter().sum(),
            bytes: size_of::<Self>() as u64 + 4 * lengths.iter().sum::<u64>(),
            ..StructureStats::default()
        }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        for (bounds, ids) in &self.halves {
            each(Cell::elementary(*bounds, 0, ids));
        }
        Ok(())
    }
}
