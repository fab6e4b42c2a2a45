//! The rays of a scene, and the answers that all rows are compared with: those of the structure
//! that is asked first, amended where f64 brute force refutes them on a sample.
//!
//! Whichever is asked first, rows are judged alike: see [`Arbiter`].

use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use renderer::{Geometry, RayBatches, RayKind, generate_rays};
use scene_loading::Scene;

use crate::answers::arbiter::Arbiter;
use crate::plan::rows::Row;
use crate::plan::{Limits, Plan};
use crate::rays::batches::{Answers, answer};
use crate::record::OracleRecord;
use crate::rounds::MeasureError;
use crate::system::panics::caught;
use crate::system::pools::Pools;
use statistics::random::Random;

/// Fewest rays per kind that the oracle answers, whatever they cost.
const FEWEST_ORACLE_RAYS: usize = 16;

/// The rays of a scene, the first answers to them, and the oracle's counts.
pub struct Reference<S: Buildable> {
    pub rays: RayBatches<S>,
    /// The answers, one batch a kind.
    pub answers: Vec<(RayKind, Answers<S>)>,
    /// How they were judged; `reference` is `None` if the oracle refuted every structure.
    pub record: OracleRecord,
}

/// A scene ready to be asked.
pub struct Stage<'a, S: Buildable> {
    pub scene: &'a Scene,
    pub geometry: &'a Geometry<S>,
    pub arbiter: &'a Arbiter<'a, S>,
}

impl<S: Buildable> Stage<'_, S> {
    /// Produces rays and answers with the first structure that the oracle does not refute on a
    /// sample; with any that can be built if it refutes all.
    ///
    /// # Errors
    /// [`MeasureError::NoAnswers`] when no structure can be built at all.
    pub fn reference(&self, plan: &Plan<'_>, pools: &Pools) -> Result<Reference<S>, MeasureError> {
        let mut unconfirmed = None;
        let mut refused = Vec::new();
        for row in &plan.answers {
            let why = match caught(|| pools.helper.install(|| self.candidate(row, plan))) {
                Err(panicked) => panicked.to_string(),
                Ok(Err(error)) => error.to_string(),
                Ok(Ok((mut reference, None))) => {
                    reference.record.reference = Some(row.label());
                    reference.record.refused = refused;
                    return Ok(reference);
                }
                Ok(Ok((reference, Some(example)))) => {
                    unconfirmed = Some(reference);
                    example
                }
            };
            refused.push(format!("{}: {why}", row.label()));
        }
        let (scene, reasons) = (self.scene.name.clone(), refused.join("; "));
        let mut reference = unconfirmed.ok_or(MeasureError::NoAnswers { scene, reasons })?;
        reference.record.refused = refused;
        Ok(reference)
    }

    /// Rays and answers of one candidate, and its first wrong answer. Runs in the current pool.
    fn candidate(
        &self,
        row: &Row<'_>,
        plan: &Plan<'_>,
    ) -> Result<(Reference<S>, Option<String>), BuildError> {
        let tracer = row.entry.build(self.geometry.prims(), &row.params)?;
        let rays = generate_rays(self.scene, &*tracer, &plan.settings);
        let mut answers = answer(&rays, &plan.kinds, &*tracer);
        let mut record = OracleRecord::default();
        let mut example = None;
        let count = oracle_rays(self.geometry.len(), answers.len(), &plan.limits);
        for (kind, answers) in &mut answers {
            let rays = rays.rays(*kind);
            let sample = oracle_sample(plan.seed, &self.scene.name, *kind, rays.len(), count);
            let tally = self.arbiter.oracle.check(*kind, rays, answers, &sample);
            for (&i, ray) in tally.wrong.iter().filter_map(|i| Some((i, rays.get(*i)?))) {
                answers.set(i, &self.arbiter.answer(*kind, ray));
            }
            record.checked += tally.checked as u64;
            record.borderline += tally.borderline as u64;
            let counts = [tally.checked as u64, tally.borderline as u64];
            record.by_kind.insert(kind.name().into(), counts);
            example = example.or(tally.example);
        }
        Ok((Reference { rays, answers, record }, example))
    }
}

/// Number of rays of a kind that the oracle answers: fewer in large scenes.
pub fn oracle_rays(primitives: usize, kinds: usize, limits: &Limits) -> usize {
    let tests_per_ray = primitives.max(1) as u64 * kinds.max(1) as u64;
    let affordable = (limits.oracle_tests / tests_per_ray) as usize;
    affordable.max(FEWEST_ORACLE_RAYS).min(limits.oracle_rays)
}

/// Seeded sample of the rays of a kind that the oracle answers.
pub fn oracle_sample(
    seed: u64,
    scene: &str,
    kind: RayKind,
    rays: usize,
    count: usize,
) -> Vec<usize> {
    Random::new(seed, &format!("oracle/{scene}/{}", kind.name())).sample(rays, count)
}
