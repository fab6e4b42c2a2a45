//! `rtbench verify` asks rays among others that run nearly as they do: it catches a structure that is wrong there,
//! and there alone.

use crate::common::{Folder, by_brute_force, occluded_by_brute_force, planted, run_with};
use accel_core::params::config::Settings;
use accel_core::primitives::PrimSet;
use accel_core::query::kernel::ListBlocks;
use accel_core::query::sink::Sink;
use accel_core::structure::{
    BatchAnswers, Batches, BuildError, Structure, StructureInfo, StructureStats,
};
use accel_core::structures::{Entry, brute_force};
use accel_core::{Ray, Scalar, Vector};
use measurement::scenes::Installed;
use measurement::system::clock::SystemClock;

/// Brute force that gives eight rays of a batch which run alike the answer of the first of them.
struct OneForEight<S> {
    ids: Vec<u32>,
    scalar: std::marker::PhantomData<S>,
}

/// Not equal, which the rays of some cases are.
fn are_alike<S: Scalar>(rays: &[Ray<S>]) -> bool {
    let first = rays[0].direction.to_dvec3();
    let is_near = |ray: &Ray<S>| {
        let apart = ray.direction.to_dvec3().distance(first);
        apart > 0.0 && apart < 0.1 * first.length()
    };
    rays.len() == 8 && rays[1..].iter().all(is_near)
}

impl<S: Scalar> Structure<S> for OneForEight<S> {
    type Config = ();

    fn build<P: PrimSet<S>>(prims: &P, _: &Settings<()>) -> Result<Self, BuildError> {
        let ids = (0..prims.len() as u32).collect();
        Ok(Self { ids, scalar: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, _: &Ray<S>, sink: &mut K) {
        let _ = sink.test(&self.ids);
    }

    fn batches<P: PrimSet<S>>(&self, _: &P, _: Option<&ListBlocks<S>>) -> Batches {
        Batches::Together
    }

    fn answer_batch<P: PrimSet<S>>(
        &self,
        prims: &P,
        _: Option<&ListBlocks<S>>,
        rays: &[Ray<S>],
        reach: S,
        answers: BatchAnswers<'_, S>,
    ) {
        match answers {
            BatchAnswers::Closest(hits) => {
                by_brute_force(prims, rays, reach, hits);
                for (_, hits) in alike(rays, hits) {
                    hits.fill(hits[0]);
                }
            }
            BatchAnswers::Occlusion(blocked) => {
                occluded_by_brute_force(prims, rays, reach, blocked);
                for (_, blocked) in alike(rays, blocked) {
                    blocked.fill(blocked[0]);
                }
            }
        }
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

/// Eights that run alike, and their answers.
fn alike<'a, S: Scalar, T>(
    rays: &'a [Ray<S>],
    answers: &'a mut [T],
) -> impl Iterator<Item = (&'a [Ray<S>], &'a mut [T])> {
    rays.chunks(8).zip(answers.chunks_mut(8)).filter(|(rays, _)| are_alike(rays))
}

static ONE_FOR_EIGHT: StructureInfo = planted("one-for-eight", "wrong on purpose");
static FAULTS: &[Entry] = &[
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
    accel_core::entry!(OneForEight, ONE_FOR_EIGHT),
];

#[test]
fn what_is_wrong_among_rays_that_run_alike_is_found() {
    let folder = Folder::new();
    let check = "verify --cases G1,R8 -s one-for-eight --rays 1000 --export-csv";
    let ended = run_with(
        FAULTS,
        &Installed,
        &SystemClock::default(),
        &format!("{check} {}/results.csv", folder.path()),
    );
    assert_eq!(ended.code, 4, "{}{}", ended.out, ended.err);
    assert!(ended.out.contains("in company"), "{}", ended.out);
    let rows = folder.csv();
    assert_eq!(rows.len(), 4);
    for row in rows {
        assert_ne!(row["mismatches"], "0", "{row:?}");
    }
}

#[test]
fn the_fault_is_among_neighbours_alone() {
    let ray = |x: f32| Ray::<f32>::new(glam::Vec3::ZERO, glam::Vec3::new(x, 1.0, 0.0));
    let apart: Vec<_> = (0..8).map(|i| ray(i as f32)).collect();
    let together: Vec<_> = (0..8).map(|i| ray(i as f32 * 1e-3)).collect();
    assert!(!are_alike(&apart) && are_alike(&together) && !are_alike(&together[1..]));
}
