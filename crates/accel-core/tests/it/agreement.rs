//! Do structures give the answers of brute force?

// each test target uses a part of it
#![allow(dead_code)]

use accel_core::primitives::PrimsRef;
use accel_core::query::tracer::{ShadowCount, ShadowRule, Tracer};
use accel_core::registry::Buildable;
use accel_core::structures::{Entry, find};
use accel_core::{Hit, Ray};

/// Answers of a structure to some rays.
pub struct Answers<S: Buildable> {
    pub hits: Vec<Hit<S>>,
    pub blocked: Vec<bool>,
}

impl<S: Buildable> Answers<S> {
    /// The answers of brute force.
    pub fn expected(prims: PrimsRef<S>, rays: &[Ray<S>]) -> Self {
        let entry = find("brute-force").unwrap();
        Self::written(&*entry.build(prims, &entry.params([]).unwrap()).unwrap(), rays)
    }

    /// The answers of a structure, of which none may be left out: they are the same whatever stood
    /// there before.
    pub fn written(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> Self {
        let mut hits = vec![poisoned(); rays.len()];
        tracer.closest_hits(rays, &mut hits);
        let [blocked, again] = [false, true].map(|preset| {
            let mut blocked = vec![preset; rays.len()];
            tracer.occlusions(rays, &mut blocked);
            blocked
        });
        assert!(again == blocked, "answers are left out");
        Self { hits, blocked }
    }

    /// The answers of a structure. What it does not write is wrong: no hit has the parameter that
    /// stands there before, and every blocked ray stands there as free, every free one as blocked.
    pub fn of(tracer: &dyn Tracer<S>, rays: &[Ray<S>], expected: &Self) -> Self {
        let blocked = expected.blocked.iter().map(|b| !b).collect();
        let mut this = Self { hits: vec![poisoned(); rays.len()], blocked };
        tracer.closest_hits(rays, &mut this.hits);
        tracer.occlusions(rays, &mut this.blocked);
        this
    }

    /// The same from the passes that count.
    pub fn counted(tracer: &dyn Tracer<S>, rays: &[Ray<S>], expected: &Self) -> Self {
        let preset = |blocked: &bool| ShadowCount { blocked: !blocked, glass: 0 };
        let mut shadows: Vec<_> = expected.blocked.iter().map(preset).collect();
        let mut hits = vec![poisoned(); rays.len()];
        tracer.count_closest_hits(rays, &mut hits);
        tracer.count_occlusions(rays, ShadowRule::OpaqueBlocks, &mut shadows);
        Self { hits, blocked: shadows.iter().map(|s| s.blocked).collect() }
    }

    /// Rays with another answer.
    pub fn differing(&self, other: &Self) -> Vec<usize> {
        let differs =
            |&i: &usize| self.hits[i] != other.hits[i] || self.blocked[i] != other.blocked[i];
        (0..self.hits.len()).filter(differs).collect()
    }
}

/// No answer to any ray: not even equal to itself.
fn poisoned<S: Buildable>() -> Hit<S> {
    Hit { t: S::from_f64(f64::NAN), id: 0 }
}

/// Mismatches with brute force of every variant of every structure on one scene.
pub fn mismatches<S: Buildable>(
    registry: &[Entry],
    name: &str,
    prims: PrimsRef<S>,
    rays: &[Ray<S>],
) -> Vec<String> {
    mismatches_under(registry, &[], name, prims, rays)
}

/// The same with further settings.
pub fn mismatches_under<S: Buildable>(
    registry: &[Entry],
    also: &[(&str, &str)],
    name: &str,
    prims: PrimsRef<S>,
    rays: &[Ray<S>],
) -> Vec<String> {
    let expected = Answers::expected(prims, rays);
    let mut wrong = Vec::new();
    for entry in registry {
        for variant in entry.info.variants.iter().chain(entry.info.also_tested) {
            let settings = variant.split_whitespace().map(|s| s.split_once('=').unwrap());
            let params = entry.params(settings.chain(also.iter().copied())).unwrap();
            if (entry.info.known_defect)(&params).is_some() {
                continue;
            }
            let label = format!("{name} {} {} {variant} {also:?}", S::NAME, entry.info.name);
            let tracer = match entry.build(prims, &params) {
                Ok(tracer) => tracer,
                Err(e) => {
                    wrong.push(format!("{label}: {e}"));
                    continue;
                }
            };
            let timed = Answers::of(&*tracer, rays, &expected);
            let counted = Answers::counted(&*tracer, rays, &expected);
            for (pass, answers) in [("timed", timed), ("counted", counted)] {
                wrong.extend(answers.differing(&expected).into_iter().map(|i| {
                    let (is, ought) = (answers.hits[i], expected.hits[i]);
                    let blocked = [answers.blocked[i], expected.blocked[i]];
                    let ray = &rays[i];
                    format!("{label}, {pass}: ray {i} {ray:?}: {is:?}, not {ought:?}; {blocked:?}")
                }));
            }
        }
    }
    wrong
}
