//! The structures that can be asked by frusta ([`crate::query::region`]).

use super::{bricked_grid, brute_force, hashed_grid, kd_tree, uniform_grid};
use crate::geometry::scalar::Scalar;
use crate::params::Params;
use crate::params::config::Settings;
use crate::primitives::PrimsRef;
use crate::query::region::{BoundFrustumQueries, FrustumQueries, FrustumTraversal};
use crate::registry::{self, RegistryItem};
use crate::structure::{BuildError, StructureInfo, refuse_unusable};

/// Every structure that can be asked by frusta: one line each.
pub static REGISTRY: &[Entry] = &[
    line(&brute_force::INFO, build::<brute_force::BruteForce<f64>>),
    line(&uniform_grid::INFO, build::<uniform_grid::UniformGrid<f64>>),
    line(&hashed_grid::INFO, build::<hashed_grid::HashedGrid<f64>>),
    line(&bricked_grid::INFO, build::<bricked_grid::BrickedGrid<f64>>),
    line(&kd_tree::INFO, build::<kd_tree::KdTree<f64>>),
];

/// A line of a registry; `build` is [`build`] of the structure.
pub const fn line(info: &'static StructureInfo, build: Builder) -> Entry {
    Entry::new(info, build, build)
}

/// How one is built.
type Builder = fn(PrimsRef<'_, f64>, &Params) -> Result<Box<dyn FrustumQueries>, BuildError>;

/// A structure that frusta can be asked of, in f64.
pub struct FrustumAnswering;

impl RegistryItem for FrustumAnswering {
    type Builder<S: Scalar> = Builder;
}

/// One line of [`REGISTRY`].
pub type Entry = registry::Entry<FrustumAnswering>;

impl Entry {
    /// Builds the structure over the set; it keeps what it needs of the primitives.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn build(
        &self,
        prims: PrimsRef<'_, f64>,
        params: &Params,
    ) -> Result<Box<dyn FrustumQueries>, BuildError> {
        <f64 as registry::Buildable>::builder(self)(prims, params)
    }
}

/// The entry of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    registry::find(REGISTRY, name)
}

/// Builds `T` over whichever set it is, to be asked by frusta.
///
/// # Errors
/// [`BuildError`].
pub fn build<T: FrustumTraversal + 'static>(
    prims: PrimsRef<'_, f64>,
    params: &Params,
) -> Result<Box<dyn FrustumQueries>, BuildError> {
    let (prims, settings) = (prims.primitives(), Settings::<T::Config>::of(params));
    refuse_unusable(prims, settings.limits())?;
    Ok(Box::new(BoundFrustumQueries::new(prims, T::build(prims, &settings)?)))
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::geometry::ray::Ray;
    use crate::geometry::scalar::Vector;
    use crate::primitives::{MixedSet, PrimSet, Primitives};
    use crate::query::region::{Candidates, Frustum};
    use crate::structure::Structure;
    use crate::structures::test_scenes::{Random, hard_scenes, mixed_scene};
    use glam::DVec3;

    /// Pyramids into and through the scene, each with some directions within it.
    fn frusta(set: &MixedSet<f64>, random: &mut Random) -> Vec<(Frustum, DVec3, Vec<DVec3>)> {
        let bounds = set.scene_bounds();
        let (lo, size) = (bounds.min.to_dvec3(), bounds.size().to_dvec3());
        let reach = 8.0 * size.length();
        let frustum = |k: usize| {
            let target = lo + size * random.point([1.0; 3]);
            let apex = lo + size * (random.point([3.0; 3]) - DVec3::ONE);
            let forward = (target - apex).normalize_or(DVec3::X);
            let (u, v) = forward.any_orthonormal_pair();
            let half = [1e-4, 0.01, 0.2, 2.0][k % 4];
            let corner = |a: f64, b: f64| forward + (u * a + v * b) * half;
            let corners =
                [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            let within = (0..20)
                .map(|_| corner(random.unit() * 2.0 - 1.0, random.unit() * 2.0 - 1.0))
                .collect();
            (Frustum::pyramid(apex, &corners, reach), apex, within)
        };
        (0..60).map(frustum).collect()
    }

    /// Hits that `queries` missed, those that came after a depth that excludes them, and all.
    fn missed_and_late(queries: &dyn FrustumQueries, set: &MixedSet<f64>, seed: u64) -> [u32; 3] {
        let mut random = Random(seed);
        let mut candidates = Candidates::default();
        let mut counts = [0; 3];
        for (frustum, apex, directions) in frusta(set, &mut random) {
            // the depth that was announced when each id came
            let mut depths = vec![None; set.len()];
            let mut bound = f64::NEG_INFINITY;
            queries.query_in_order(&frustum, &mut candidates, &mut |ids, depth| {
                assert!(depth >= bound, "depths do not decrease");
                bound = depth;
                for &id in ids {
                    assert!(depths[id as usize].replace(depth).is_none(), "{id} came twice");
                }
                ControlFlow::Continue(())
            });
            for direction in directions {
                let ray = Ray::<f64>::from_dvec3(apex, direction);
                let setup = set.setup(&ray);
                for id in 0..set.len() as u32 {
                    let Some(t) = set.intersect(id, &ray, &setup, f64::INFINITY) else { continue };
                    counts[2] += 1;
                    match depths[id as usize] {
                        None => counts[0] += 1,
                        Some(depth) => {
                            let at = frustum.depth(apex + direction * t);
                            counts[1] +=
                                u32::from(at < depth - 1e-9 * frustum.tolerance().max(1.0));
                        }
                    }
                }
            }
        }
        counts
    }

    #[test]
    fn frustum_queries_find_all_hit_primitives_in_order() {
        let mut sets = hard_scenes::<f64>();
        sets.retain(|(name, _)| *name != "duplicates");
        sets.push(("many", mixed_scene(3000, 5, [1.0, 1.0, 0.2])));
        for entry in REGISTRY {
            let params = entry.params([]).unwrap();
            for (name, set) in &sets {
                let queries = entry.build(PrimsRef::Mixed(set), &params).unwrap();
                let [missed, late, hits] = missed_and_late(queries.as_ref(), set, 3);
                assert_eq!([missed, late], [0, 0], "{} {name}", entry.info.name);
                assert!(hits > 100, "{name}: only {hits} hits");
            }
        }
    }

    #[test]
    fn forgotten_cells_are_caught() {
        struct LossyGrid(uniform_grid::UniformGrid<f64>);
        impl Structure<f64> for LossyGrid {
            type Config = <uniform_grid::UniformGrid<f64> as Structure<f64>>::Config;

            fn build(
                prims: &dyn Primitives<f64>,
                settings: &Settings<Self::Config>,
            ) -> Result<Self, BuildError> {
                Structure::build(prims, settings).map(Self)
            }
            fn traverse<K: crate::query::sink::Sink<f64>>(&self, _: &Ray<f64>, _: &mut K) {}
            fn stats(&self) -> crate::structure::StructureStats {
                self.0.stats()
            }
        }
        impl FrustumTraversal for LossyGrid {
            fn traverse_frustum(
                &self,
                frustum: &Frustum,
                cell: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
            ) {
                let mut number = 0;
                self.0.traverse_frustum(frustum, &mut |ids, depth| {
                    number += 1;
                    if number % 5 == 0 { ControlFlow::Continue(()) } else { cell(ids, depth) }
                });
            }
        }
        let set = mixed_scene(3000, 5, [1.0, 1.0, 0.2]);
        let params = find("uniform-grid").unwrap().params([]).unwrap();
        let forgetful = build::<LossyGrid>(PrimsRef::Mixed(&set), &params).unwrap();
        assert!(missed_and_late(forgetful.as_ref(), &set, 3)[0] > 0);
    }

    #[test]
    fn grids_and_trees_look_at_little_of_the_scene() {
        let set = mixed_scene(3000, 6, [1.0; 3]);
        let work = |name: &str| {
            let entry = find(name).unwrap();
            let queries = entry.build(PrimsRef::Mixed(&set), &entry.params([]).unwrap()).unwrap();
            let mut candidates = Candidates::default();
            for (frustum, _, _) in frusta(&set, &mut Random(4)).iter().filter(|s| s.2.len() == 20) {
                queries.query(frustum, &mut candidates);
            }
            candidates.work
        };
        let all = work("brute-force");
        assert_eq!(all.tests, 3000 * all.queries);
        for name in ["uniform-grid", "kd-tree"] {
            let work = work(name);
            assert!(2 * work.tests < all.tests, "{name}: {work:?}");
            assert!(work.found <= all.found && work.found > 0, "{name}: {work:?} {all:?}");
        }
        assert_eq!(work("hashed-grid"), work("uniform-grid"));
        assert_eq!(work("bricked-grid"), work("uniform-grid"));
    }
}
