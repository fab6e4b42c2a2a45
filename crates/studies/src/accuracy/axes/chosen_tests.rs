//! Parts shared by the axes of primitive tests: a test chosen by name, its number of wrong answers,
//! and the error of its parameters.

use accel_core::variants::chosen_tests::is_compiled;

use crate::accuracy::error_of::TrialCounts;
use crate::accuracy::stage::{Batches, Replay, StagedStructure};
use crate::accuracy::timing::Variant;
use statistics::estimate::median;

/// The test that all others are compared with.
const REFERENCE: &str = "f64";

/// Note on whether chosen tests are compiled in or called.
pub fn made(built: &[StagedStructure<'_>]) -> &'static str {
    if built.iter().all(|built| is_compiled(&*built.tracer)) {
        "each test compiled into it as the default is"
    } else {
        "each test is a call: build with --features compiled-tests for prices"
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
