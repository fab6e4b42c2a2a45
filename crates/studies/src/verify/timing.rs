//! What rays that cannot hit anything cost: their time over that of normal rays (HARD_CASES R4,
//! R1). A structure that takes NaN through its cells once took 700 times as long as normal.

use accel_core::query::tracer::Tracer;
use accel_core::{Hit, Ray, Vector};
use glam::DVec3;

use super::model::Model;
use super::registry::{Ask, find};
use super::round::{Round, ray};
use super::subject::Subject;
use crate::error::StudyError;
use measurement::plan::error::PlanError;
use measurement::rounds::error::MeasureError;
use measurement::system::clock::Clock;
use presentation::table::{Cell, Style, Table};
use statistics::random::Random;

/// Meaningless rays may take so many times as long as normal ones.
pub const LIMIT: f64 = 2.5;

/// Rays a batch.
const RAYS: usize = 4000;

/// Batches; the median counts.
const BATCHES: usize = 7;

/// The times of one structure.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Timed {
    /// Its label.
    pub structure: String,
    /// Time of R4's rays (zero, infinite, NaN; empty intervals) over that of normal ones.
    pub meaningless: f64,
    /// Time of R1's rays with negative zeros over that with positive ones.
    pub negative_zeros: f64,
}

/// Times all structures among the subjects, in single precision, one after the other.
///
/// # Errors
/// [`MeasureError::Build`] when a structure refuses the scene.
pub fn timed(
    subjects: &[Subject<'_>],
    clock: &dyn Clock,
    seed: u64,
) -> Result<Vec<Timed>, StudyError> {
    let bad = drawn("R4", seed)?;
    let normal = aimed(&bad, seed);
    let signs = drawn("R1", seed)?;
    let zeros = [1.0, -1.0].map(|sign| with_zeros(&signs.rays, sign));
    let structures = subjects.iter().filter(|s| matches!(s, Subject::Structure(_)));
    let mut all = Vec::new();
    for subject in structures {
        let ratio = |model: &Model<f32>, usual: &[Ray<f32>], odd: &[Ray<f32>]| {
            let over = subject.over(model, |tracer| ratio(tracer, clock, usual, odd));
            let scene = || "R4 or R1".to_owned();
            over.map_err(|source| StudyError::from(MeasureError::Build { scene: scene(), source }))
        };
        let (meaningless, negative_zeros) =
            (ratio(&bad.model, &normal, &bad.rays)?, ratio(&signs.model, &zeros[0], &zeros[1])?);
        if let (Some(meaningless), Some(negative_zeros)) = (meaningless, negative_zeros) {
            all.push(Timed { structure: subject.label(), meaningless, negative_zeros });
        }
    }
    Ok(all)
}

/// A round of the case.
fn drawn(id: &str, seed: u64) -> Result<Round<f32>, StudyError> {
    let (_, case) = find(id)?;
    let random = &mut Random::new(seed, "verify timing");
    match case.ask {
        Ask::Rays { single, .. } => single(random, RAYS).ok(),
        Ask::Parts(_) => None,
    }
    .ok_or_else(|| PlanError::Malformed { text: id.to_owned(), expected: "a case of rays" }.into())
}

/// As many normal rays at the triangles of a round.
fn aimed(round: &Round<f32>, seed: u64) -> Vec<Ray<f32>> {
    let random = &mut Random::new(seed, "verify timing, normal rays");
    let triangles: Vec<[DVec3; 3]> = match &round.model {
        Model::Triangles(set) => {
            let corner = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
            set.triangles().iter().map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])]).collect()
        }
        Model::Mixed(_) => Vec::new(),
    };
    let one = |_| {
        let target = super::cases::point_within(random, &triangles);
        let (origin, along) = super::cases::toward(random, target, 2.0);
        ray(origin, along)
    };
    (0..round.rays.len()).map(one).collect()
}

/// The rays with all zeros of that sign.
fn with_zeros(rays: &[Ray<f32>], sign: f64) -> Vec<Ray<f32>> {
    let one = |r: &Ray<f32>| {
        let d = r.direction.to_dvec3().to_array();
        let d = d.map(|x| if x == 0.0 { 0.0_f64.copysign(sign) } else { x });
        ray(r.origin.to_dvec3(), DVec3::from_array(d))
    };
    rays.iter().map(one).collect()
}

/// Median time of the odd rays over that of the usual ones; batches take turns.
fn ratio(tracer: &dyn Tracer<f32>, clock: &dyn Clock, usual: &[Ray<f32>], odd: &[Ray<f32>]) -> f64 {
    let mut hits = vec![Hit::NONE; usual.len().max(odd.len())];
    let mut seconds = |rays: &[Ray<f32>]| {
        let start = clock.now();
        tracer.closest_hits(rays, &mut hits);
        std::hint::black_box(&hits);
        clock.seconds_since(start)
    };
    let pairs: Vec<(f64, f64)> = (0..BATCHES).map(|_| (seconds(usual), seconds(odd))).collect();
    let median = |mut all: Vec<f64>| {
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let (usual, odd): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
    median(odd) / median(usual)
}

/// Structures down, both ratios across; those beyond [`LIMIT`] stand out.
pub fn table(all: &[Timed]) -> Table {
    let cell = |ratio: f64| {
        let style = if ratio > LIMIT { Style::Bad } else { Style::Plain };
        Cell { text: format!("{ratio:.2}"), style }
    };
    let row =
        |t: &Timed| vec![t.structure.clone().into(), cell(t.meaningless), cell(t.negative_zeros)];
    Table {
        title: "time of odd rays over that of normal ones".into(),
        header: vec!["structure", "R4 meaningless", "R1 -0 over +0"],
        rows: all.iter().map(row).collect(),
        notes: vec![format!("limit {LIMIT}: times vary with the machine and fail no check")],
    }
}
