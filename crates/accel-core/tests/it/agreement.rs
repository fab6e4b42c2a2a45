//! Do structures give the answers of brute force?

use accel_core::primitives::PrimsRef;
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structures::Entry;
use accel_core::{Hit, Ray, Scalar};

use crate::common::{build, settings};
use crate::test_scenes::occlusions;

/// Answers of a structure to some rays.
#[derive(Debug, PartialEq)]
pub struct Answers<S: Buildable> {
    pub hits: Vec<Hit<S>>,
    pub blocked: Vec<bool>,
}

impl<S: Buildable> Answers<S> {
    /// The answers of brute force.
    pub fn expected(prims: PrimsRef<S>, rays: &[Ray<S>]) -> Self {
        Self::written(&*build(prims, "brute-force", "").unwrap(), rays)
    }

    /// The answers of a structure, of which none may be left out: they are the same whatever stood
    /// there before.
    pub fn written(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> Self {
        Self { hits: closest_hits(tracer, rays), blocked: occlusions(tracer, rays) }
    }

    /// The answers of a structure. What it does not write is wrong: no hit has the parameter that
    /// stands there before, and every blocked ray stands there as free, every free one as blocked.
    pub fn of(tracer: &dyn Tracer<S>, rays: &[Ray<S>], expected: &Self) -> Self {
        let blocked = expected.blocked.iter().map(|b| !b).collect();
        let mut this = Self { hits: vec![unwritten(); rays.len()], blocked };
        tracer.closest_hits(rays, &mut this.hits);
        tracer.occlusions(rays, &mut this.blocked);
        this
    }

    /// The same from the passes that count, and the work of both.
    pub fn counted(
        tracer: &dyn Tracer<S>,
        rays: &[Ray<S>],
        expected: &Self,
    ) -> (Self, [WorkCounters; 2]) {
        let mut blocked: Vec<bool> = expected.blocked.iter().map(|blocked| !blocked).collect();
        let mut hits = vec![unwritten(); rays.len()];
        let closest = tracer.count_closest_hits(rays, &mut hits);
        let shadow = tracer.count_occlusions(rays, &mut blocked);
        (Self { hits, blocked }, [closest, shadow])
    }

    /// Rays with another answer.
    pub fn differing(&self, other: &Self) -> Vec<usize> {
        let differs =
            |&i: &usize| self.hits[i] != other.hits[i] || self.blocked[i] != other.blocked[i];
        (0..self.hits.len()).filter(differs).collect()
    }
}

/// Stands where no hit was written: not even equal to itself.
pub fn unwritten<S: Scalar>() -> Hit<S> {
    Hit { t: S::from_f64(f64::NAN), id: 0 }
}

/// The closest hits, with nothing in their places before that could be one.
pub fn closest_hits<S: Scalar>(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> Vec<Hit<S>> {
    let mut hits = vec![unwritten(); rays.len()];
    tracer.closest_hits(rays, &mut hits);
    hits
}

/// The answers of a structure, timed and counted alike, and the work of both kinds.
pub fn work<S: Buildable>(
    tracer: &dyn Tracer<S>,
    rays: &[Ray<S>],
) -> (Answers<S>, [WorkCounters; 2]) {
    let timed = Answers::written(tracer, rays);
    let (counted, work) = Answers::counted(tracer, rays, &timed);
    assert_eq!(counted, timed);
    (timed, work)
}

/// Mismatches of a tracer with what is expected, when timed and when counted.
fn differences<S: Buildable>(
    label: &str,
    tracer: &dyn Tracer<S>,
    rays: &[Ray<S>],
    expected: &Answers<S>,
) -> Vec<String> {
    let timed = Answers::of(tracer, rays, expected);
    let (counted, _) = Answers::counted(tracer, rays, expected);
    let mut wrong = Vec::new();
    for (pass, answers) in [("timed", timed), ("counted", counted)] {
        wrong.extend(answers.differing(expected).into_iter().map(|i| {
            let (is, ought) = (answers.hits[i], expected.hits[i]);
            let blocked = [answers.blocked[i], expected.blocked[i]];
            let ray = &rays[i];
            format!("{label}, {pass}: ray {i} {ray:?}: {is:?}, not {ought:?}; {blocked:?}")
        }));
    }
    wrong
}

/// The answers of brute force, of which more than one in `sparse` are hits, after each of these
/// structures, by name and settings, has given them as well.
pub fn agreed<S: Buildable>(
    scene: &str,
    prims: PrimsRef<S>,
    rays: &[Ray<S>],
    sparse: usize,
    tested: &[(&str, impl AsRef<str>)],
) -> Answers<S> {
    let expected = Answers::expected(prims, rays);
    let hits = expected.hits.iter().filter(|hit| hit.is_hit()).count();
    assert!(hits > rays.len() / sparse, "{scene}: {hits} hits of {} rays", rays.len());
    let of = |&(name, ref text): &(&str, _)| {
        let text: &str = AsRef::as_ref(text);
        let label = format!("{scene} {} {name} {text}", S::NAME);
        let wrong = differences(&label, &*build(prims, name, text).unwrap(), rays, &expected);
        Some(format!("{} wrong, first: {}", wrong.len(), wrong.first()?))
    };
    let wrong: Vec<_> = tested.iter().filter_map(of).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    expected
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
            let params = entry.params(settings(variant).chain(also.iter().copied())).unwrap();
            if (entry.info.known_defect)(&params).is_some() {
                continue;
            }
            let label = format!("{name} {} {} {variant} {also:?}", S::NAME, entry.info.name);
            match entry.build(prims, &params) {
                Ok(tracer) => wrong.extend(differences(&label, &*tracer, rays, &expected)),
                Err(e) => wrong.push(format!("{label}: {e}")),
            }
        }
    }
    wrong
}
