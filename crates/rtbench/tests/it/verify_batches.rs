//! `rtbench verify` asks rays among others that run nearly as they do: it catches a structure that
//! is wrong there, and there alone.

use crate::common::{
    BatchFault, Batched, Folder, answered_by_brute_force, planted_entry, run_with,
};
use accel_core::primitives::PrimSet;
use accel_core::structure::{BatchAnswers, RayBatch};
use accel_core::structures::{Entry, brute_force};
use accel_core::{Ray, Scalar, Vector};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

/// Not equal, which the rays of some cases are.
fn are_alike<S: Scalar>(rays: &[Ray<S>]) -> bool {
    let first = rays[0].direction.to_dvec3();
    let is_near = |ray: &Ray<S>| {
        let apart = ray.direction.to_dvec3().distance(first);
        apart > 0.0 && apart < 0.1 * first.length()
    };
    rays.len() == 8 && rays[1..].iter().all(is_near)
}

/// Gives eight rays of a batch which run alike the answer of the first of them.
struct OfTheFirst;

impl BatchFault for OfTheFirst {
    fn answer<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>) {
        answered_by_brute_force(prims, batch);
        match &mut batch.answers {
            BatchAnswers::Closest(hits) => take_the_first(batch.rays, hits),
            BatchAnswers::Occlusion(blocked) => take_the_first(batch.rays, blocked),
        }
    }
}

/// Answers the first ray of coherent groups of eight for all.
fn take_the_first<S: Scalar, T: Clone>(rays: &[Ray<S>], answers: &mut [T]) {
    for (rays, answers) in rays.chunks(8).zip(answers.chunks_mut(8)) {
        if are_alike(rays) {
            answers.fill(answers[0].clone());
        }
    }
}

/// Puts the answers of a batch whose groups of alike rays are mixed one place off.
struct OutOfOrder;

impl BatchFault for OutOfOrder {
    fn answer<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>) {
        let rays = batch.rays;
        let group: Vec<Ray<S>> = rays.iter().copied().step_by((rays.len() / 8).max(1)).collect();
        let is_mixed = rays.len() > 8 && are_alike(&group);
        answered_by_brute_force(prims, batch);
        match &mut batch.answers {
            BatchAnswers::Closest(hits) => hits.rotate_left(usize::from(is_mixed)),
            BatchAnswers::Occlusion(blocked) => blocked.rotate_left(usize::from(is_mixed)),
        }
    }
}

static FAULTS: &[Entry] = &[
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
    planted_entry!("one-for-eight", Batched<S, OfTheFirst>),
    planted_entry!("one-place-off", Batched<S, OutOfOrder>),
];

/// Asserts that a row is wrong in all cases, and that its report says where.
fn assert_found(row: &str, how: &str) {
    let folder = Folder::new();
    let check = format!("verify --cases G1,R8 -s {row} --rays 1000 -o {}", folder.path());
    let ended = run_with(FAULTS, &InstalledScenes, &SystemClock::default(), &check);
    assert_eq!(ended.code, 4, "{}{}", ended.out, ended.err);
    assert!(ended.out.contains(how), "{}", ended.out);
    let rows = folder.csv_of("verify.csv");
    assert_eq!(rows.len(), 4);
    for row in rows {
        assert_ne!(row["mismatches"], "0", "{row:?}");
    }
}

#[test]
fn finds_errors_only_coherent_batches_show() {
    assert_found("one-for-eight", "in a coherent batch");
}

#[test]
fn finds_answers_that_are_not_put_back_into_the_order_of_the_rays() {
    assert_found("one-place-off", "in the same batch, mixed");
}

#[test]
fn the_fault_is_found_among_neighbours_only() {
    let ray = |x: f32| Ray::<f32>::new(glam::Vec3::ZERO, glam::Vec3::new(x, 1.0, 0.0));
    let apart: Vec<_> = (0..8).map(|i| ray(i as f32)).collect();
    let together: Vec<_> = (0..8).map(|i| ray(i as f32 * 1e-3)).collect();
    assert!(!are_alike(&apart) && are_alike(&together) && !are_alike(&together[1..]));
}
