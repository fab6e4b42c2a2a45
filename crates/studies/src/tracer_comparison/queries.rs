//! Cost of finding the candidates of a beam or cone: one query per pixel, through every structure
//! with frustum queries, compared with brute force.

use accel_core::primitives::PrimsRef;
use accel_core::query::region::{Candidates, Frustum, FrustumWork};
use accel_core::query::tracer::Tracer;
use accel_core::structure::BuildError;
use accel_core::structures::frustum_queries;
use accel_core::{Hit, Ray};
use glam::DVec2;
use renderer::camera::{EyeRays, Sampling};
use scene_loading::Scene;

use super::record::QueryRecord;
use measurement::rounds::interleaved::timed;
use measurement::system::clock::Clock;
use statistics::estimate::estimate;

/// Brute force asks about as many hulls per round at most, the structure in question all frusta.
const MOST_TESTS: usize = 1 << 25;

/// A pyramid a pixel, with what the ray through the pixel's centre hits.
pub fn pixel_frusta(
    scene: &Scene,
    tracer: &dyn Tracer<f64>,
    resolution: [u32; 2],
) -> Vec<(Frustum, Option<u32>)> {
    let eye = EyeRays::new(&scene.camera, resolution, Sampling::PixelCentres);
    let apex = eye.origin();
    let [w, h] = resolution;
    let pixels = || (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    let rays: Vec<Ray<f64>> =
        pixels().map(|(x, y)| Ray::from_dvec3(apex, eye.direction(x, y))).collect();
    let mut hits = vec![Hit::NONE; rays.len()];
    tracer.closest_hits(&rays, &mut hits);
    // twice as far as the farthest corner
    let bounds = scene.bounds();
    let corner = (bounds.min - apex).abs().max((bounds.max - apex).abs());
    let reach = 2.0 * corner.length().max(f64::MIN_POSITIVE);
    let frustum = |(x, y)| {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corners = corners.map(|at| eye.direction_within(x, y, DVec2::from(at)));
        Frustum::pyramid(apex, &corners, reach)
    };
    let seen = hits.iter().map(|hit| hit.is_hit().then_some(hit.id));
    pixels().map(frustum).zip(seen).collect()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rounds {
    pub rounds: u32,
    pub seed: u64,
    /// Primitives of the scene: how many tests brute force makes a query.
    pub primitives: usize,
}

/// Asks every structure of `registry` for the candidates of all frusta, `rounds` times in seeded
/// random order, on the calling thread. `seen` is what a ray within each frustum hits, if anything:
/// it must be among the candidates.
pub fn measure(
    registry: &[frustum_queries::Entry],
    prims: PrimsRef<'_, f64>,
    frusta: &[(Frustum, Option<u32>)],
    rounds: Rounds,
    clock: &dyn Clock,
) -> Result<Vec<QueryRecord>, BuildError> {
    let stride = (frusta.len() * rounds.primitives).div_ceil(MOST_TESTS).max(1);
    let sample: &[_] = &frusta.iter().step_by(stride).collect::<Vec<_>>();
    let mut built = Vec::new();
    for entry in registry {
        built.push((entry.info.name, entry.build(prims, &entry.params([])?)?));
    }
    let mut works: Vec<Box<dyn FnMut() + '_>> = Vec::new();
    for (_, queries) in &built {
        works.push(Box::new(move || {
            let mut candidates = Candidates::default();
            for (frustum, _) in sample {
                queries.query(frustum, &mut candidates);
                std::hint::black_box(&candidates.ids);
            }
        }));
    }
    let seed = rounds.seed;
    let is_left = |round| round < rounds.rounds as usize;
    let seconds = timed(&mut works, seed, "queries", clock, is_left);
    let brute = built.iter().position(|(name, _)| *name == "brute-force").unwrap_or(0);
    let Some(base) = seconds.get(brute) else { return Ok(Vec::new()) };
    let rows = built.iter().zip(&seconds).filter_map(|((name, queries), seconds)| {
        let per_query: Vec<f64> =
            seconds.iter().map(|s| s * 1e6 / sample.len().max(1) as f64).collect();
        let ratios: Vec<f64> =
            seconds.iter().zip(base).map(|(s, b)| s / b.max(f64::MIN_POSITIVE)).collect();
        let (mut candidates, mut missed) = (Candidates::default(), 0);
        for (frustum, seen) in sample {
            queries.query(frustum, &mut candidates);
            missed += usize::from(seen.is_some_and(|seen| !candidates.ids.contains(&seen)));
        }
        let FrustumWork { cells, references, tests: hull_tests, found, .. } = candidates.work;
        Some(QueryRecord {
            structure: (*name).to_owned(),
            queries: sample.len(),
            microseconds: estimate(&per_query, seed)?,
            ratio_to_brute_force: estimate(&ratios, seed)?,
            cells,
            references,
            hull_tests,
            found,
            missed,
        })
    });
    Ok(rows.collect())
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::time::Duration;

    use accel_core::params::config::Settings;
    use accel_core::primitives::Primitives;
    use accel_core::query::region::FrustumTraversal;
    use accel_core::query::sink::Sink;
    use accel_core::structure::{Structure, StructureStats};
    use accel_core::structures::uniform_grid::{INFO, UniformGrid};
    use renderer::Geometry;

    use super::*;
    use measurement::scenes::{InstalledScenes, SceneSource};
    use measurement::system::clock::SteppingClock;

    /// A grid that loses two of three cells.
    struct LossyGrid(UniformGrid<f64>);

    impl Structure<f64> for LossyGrid {
        type Config = <UniformGrid<f64> as Structure<f64>>::Config;

        fn build(
            prims: &dyn Primitives<f64>,
            settings: &Settings<Self::Config>,
        ) -> Result<Self, BuildError> {
            Structure::build(prims, settings).map(Self)
        }

        fn traverse<K: Sink<f64>>(&self, ray: &Ray<f64>, sink: &mut K) {
            self.0.traverse(ray, sink);
        }

        fn stats(&self) -> StructureStats {
            Structure::<f64>::stats(&self.0)
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
                if number % 3 == 0 { cell(ids, depth) } else { ControlFlow::Continue(()) }
            });
        }
    }

    #[test]
    fn structures_that_lose_candidates_are_wrong() {
        let scene =
            InstalledScenes.resolve(&["tetra:3".to_owned()]).unwrap()[0].load().unwrap().scene;
        let geometry = Geometry::<f64>::of(&scene).unwrap();
        let entry = accel_core::structures::find("brute-force").unwrap();
        let tracer = entry.build(geometry.prims(), &entry.params([]).unwrap()).unwrap();
        let frusta = pixel_frusta(&scene, &*tracer, [24; 2]);
        let rounds = Rounds { rounds: 2, seed: 1, primitives: scene.primitives.len() };
        let clock = SteppingClock::new(Duration::from_millis(1));
        let asked = |registry: &[frustum_queries::Entry]| {
            measure(registry, geometry.prims(), &frusta, rounds, &clock).unwrap()
        };
        let rows = asked(frustum_queries::REGISTRY);
        assert!(
            rows.iter().all(|r| r.missed == 0 && r.ratio_to_brute_force.holds(1.0)),
            "{rows:?}"
        );
        let planted = [frustum_queries::line(&INFO, frustum_queries::build::<LossyGrid>)];
        assert!(asked(&planted)[0].missed > 0);
    }
}
