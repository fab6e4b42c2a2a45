//! Parts shared by the axes of primitive tests: a test chosen by name, its number of wrong answers,
//! and the error of its parameters.

use accel_core::primitives::PrimSet;
use accel_core::variants::chosen_tests::TestedSetVisitor;

use super::triangle_aims::AimedRay;
use crate::accuracy::error_of::TrialCounts;
use crate::accuracy::stage::{Batches, Replay, StagedStructure};
use crate::accuracy::timing::Variant;
use statistics::estimate::median;

/// The test that all others are compared with.
const REFERENCE: &str = "f64";

/// The parameter by which an aimed ray hits, of the nearest of the primitives that it is judged by.
pub struct NearestOf<'m> {
    pub aims: &'m [AimedRay],
}

impl TestedSetVisitor<'_> for NearestOf<'_> {
    type Output = Vec<Option<f32>>;

    fn visit<P: PrimSet<f32>>(self, set: &P) -> Self::Output {
        let nearest = |aim: &AimedRay| {
            let setup = set.setup(&aim.ray);
            let t = |id: &u32| set.intersect(*id, &aim.ray, &setup, f32::INFINITY);
            aim.primitives.iter().filter_map(t).reduce(f32::min)
        };
        self.aims.iter().map(nearest).collect()
    }
}

/// A test of primitives as a variant: `answers` are, for each aim, its parameter, that of
/// `REFERENCE`, and whether it is wrong to meet or to miss there.
pub fn variant<'a>(
    name: &str,
    built: &'a StagedStructure<'_>,
    batches: &'a Batches<f32>,
    answers: impl Iterator<Item = (Option<f32>, Option<f32>, bool)>,
) -> Variant<'a> {
    let (mut tally, mut ulps) = (TrialCounts::default(), Vec::new());
    for (t, exact, is_wrong) in answers {
        tally.add(is_wrong);
        if let (Some(t), Some(exact)) = (t, exact) {
            let ulp = f64::from(exact.next_up()) - f64::from(exact);
            ulps.push((f64::from(t) - f64::from(exact)).abs() / ulp);
        }
    }
    Variant {
        name: name.into(),
        setting: built.setting(),
        known_defect: built.known_defect,
        is_without: false,
        is_reference: name == REFERENCE,
        error: tally.error(),
        also: vec![("t off by ulps, median", median(&ulps).unwrap_or(0.0))],
        work: Box::new(Replay::new(&*built.tracer, batches).by_kind()),
    }
}
