//! A scene ready for the experiments of an axis: its primitives, its rays, and who answers them.

use std::hash::{DefaultHasher, Hash, Hasher};

use crate::accuracy::record::TrialCounts;
use crate::error::StudyError;
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::Entry;
use accel_core::{Aabb, Hit, Ray, Scalar, occluders};
use measurement::plan::rows::Row;
use measurement::rays::batches::{Answers, trace};
use measurement::rounds::MeasureError;
use measurement::system::clock::Clock;
use renderer::{Geometry, RayBatches, RayKind, RaySettings, generate_rays};
use scene_loading::Scene;
use statistics::random::Random;

/// Structure that traces whatever is not varied.
pub const TRACER: &str = "wide-bvh";

/// Trials where nobody asks what they come to.
const FEW_TRIALS: usize = 1000;

pub struct PreparedScene {
    pub scene: Scene,
    /// Its primitives in single precision.
    pub geometry: Geometry<f32>,
    pub rays: RayBatches<f32>,
}

impl PreparedScene {
    pub fn new(scene: Scene, registry: &[Entry], rays: &RaySettings) -> Result<Self, StudyError> {
        let geometry = Geometry::<f32>::of(&scene)?;
        let tracer = build(registry, TRACER, &scene.name, &geometry)?;
        let rays = generate_rays(&scene, &*tracer, rays);
        drop(tracer);
        Ok(Self { scene, geometry, rays })
    }
}

/// The structure of that label over the primitives of a scene of that name.
pub fn build<'g, S: Buildable>(
    registry: &[Entry],
    label: &str,
    scene: &str,
    geometry: &'g Geometry<S>,
) -> Result<Box<dyn Tracer<S> + 'g>, StudyError> {
    let row = Row::parse(registry, label)?;
    let built = row.entry.build(geometry.prims(), &row.params);
    Ok(built.map_err(|source| MeasureError::Build { scene: scene.to_owned(), source })?)
}

/// Context of an axis on one scene.
pub struct Stage<'a> {
    pub axis: &'static str,
    pub name: &'a str,
    pub prepared: &'a PreparedScene,
    pub registry: &'a [Entry],
    pub occluders: &'a [occluders::Entry],
    pub clock: &'a dyn Clock,
    pub limits: Limits,
}

#[derive(Debug, Clone, Copy)]
pub struct Limits {
    pub seed: u64,
    pub rounds: usize,
    /// Rays that are traced in a timed pass, at most.
    pub timed_rays: usize,
    /// Trials of an exact oracle for a variant.
    pub aims: usize,
    /// A first look only.
    pub quick: bool,
    /// Only times are asked for: another process says how wrong each variant is.
    pub only_times: bool,
}

pub struct StagedStructure<'a, S: Scalar = f32> {
    pub label: String,
    /// Known defect, by design.
    pub known_defect: Option<&'static str>,
    pub tracer: Box<dyn Tracer<S> + 'a>,
    /// Seconds of the build, made once.
    pub build_s: f64,
}

impl<S: Scalar> StagedStructure<'_, S> {
    /// How to have it in a run.
    pub fn setting(&self) -> String {
        format!("run -s {}", self.label.replace(' ', ":"))
    }

    /// What it takes beside time, as columns.
    pub fn columns(&self) -> [(&'static str, f64); 2] {
        build_columns(self.tracer.stats().bytes, self.build_s)
    }
}

impl<'a> Stage<'a> {
    pub fn random(&self, purpose: &str) -> Random {
        Random::new(self.limits.seed, &format!("accuracy/{}/{}/{purpose}", self.axis, self.name))
    }

    pub fn scene(&self) -> &'a Scene {
        &self.prepared.scene
    }

    /// Trials of an axis that times none of the rays that it draws for them: few where only times
    /// are asked for.
    pub fn trials(&self) -> usize {
        if self.limits.only_times { self.limits.aims.min(FEW_TRIALS) } else { self.limits.aims }
    }

    /// Builds a structure with settings, as `run -s` takes them.
    pub fn built(&self, label: &str) -> Result<StagedStructure<'a>, StudyError> {
        self.over(label, &self.prepared.geometry)
    }

    /// The structure of that label over other primitives than those of the scene.
    pub fn over<'g, S: Buildable>(
        &self,
        label: &str,
        geometry: &'g Geometry<S>,
    ) -> Result<StagedStructure<'g, S>, StudyError> {
        let row = Row::parse(self.registry, label)?;
        let build = row.entry.prepare(&row.params);
        let start = self.clock.now();
        let tracer = build(geometry.prims(), None).map_err(|source| self.refused(source))?;
        let build_s = self.clock.seconds_since(start);
        let (label, known_defect) = (row.label(), row.known_defect());
        Ok(StagedStructure { label, known_defect, tracer, build_s })
    }

    pub fn over_each<'g>(
        &self,
        label: &str,
        geometries: &'g [Geometry<f32>],
    ) -> Result<Vec<StagedStructure<'g>>, StudyError> {
        geometries.iter().map(|geometry| self.over(label, geometry)).collect()
    }

    /// The error for a structure that refuses the scene.
    pub fn refused(&self, source: BuildError) -> StudyError {
        MeasureError::Build { scene: self.name.to_owned(), source }.into()
    }

    /// The error for a scene that has nothing the axis is about.
    pub fn unfit(&self, reason: &'static str) -> StudyError {
        StudyError::UnfitScene { axis: self.axis, scene: self.name.to_owned(), reason }
    }

    /// The box of its primitives.
    pub fn bounds(&self) -> Aabb<f32> {
        self.prepared.geometry.prims().primitives().scene_bounds()
    }

    /// At most `most` of the rays, evenly thinned, of the kinds that `keep` says and that have any.
    pub fn batches(&self, most: usize, keep: impl Fn(RayKind) -> bool) -> Batches<f32> {
        let rays = &self.prepared.rays;
        let kinds = || RayKind::ALL.into_iter().filter(|kind| keep(*kind));
        let all: usize = kinds().map(|kind| rays.rays(kind).len()).sum();
        let stride = all.div_ceil(most.max(1)).max(1);
        let thinned = |kind| rays.rays(kind).iter().step_by(stride).copied().collect::<Vec<_>>();
        kinds().map(|kind| (kind, thinned(kind))).filter(|(_, rays)| !rays.is_empty()).collect()
    }

    /// The rays that are timed, of all kinds.
    pub fn all_batches(&self) -> Batches<f32> {
        self.batches(self.limits.timed_rays, |_| true)
    }
}

pub type Batches<S> = Vec<(RayKind, Vec<Ray<S>>)>;

pub fn count<S: Scalar>(batches: &Batches<S>) -> usize {
    batches.iter().map(|(_, rays)| rays.len()).sum()
}

/// The same rays in double precision.
pub fn widened(batches: &Batches<f32>) -> Batches<f64> {
    let wide = |rays: &Vec<Ray<f32>>| rays.iter().map(Ray::widened).collect();
    batches.iter().map(|(kind, rays)| (*kind, wide(rays))).collect()
}

/// Diagonal of the scene's box, world units.
pub fn diagonal(scene: &Scene) -> f64 {
    scene.bounds().size().length()
}

pub fn mebibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

/// The columns of what a structure takes beside time.
pub fn build_columns(bytes: u64, build_s: f64) -> [(&'static str, f64); 2] {
    [("MiB", mebibytes(bytes)), ("build ms", build_s * 1e3)]
}

/// Answers a batch, by its number.
type Ask<'a, S> = Box<dyn FnMut(usize, &mut Answers<S>) + 'a>;

/// Batches of rays that are asked again and again.
pub struct Replay<'a, S: Scalar> {
    /// One per batch.
    pub answers: Vec<Answers<S>>,
    /// Names of the batches, where each is timed by itself.
    pub parts: Vec<&'static str>,
    ask: Ask<'a, S>,
}

impl<'a, S: Buildable> Replay<'a, S> {
    pub fn new(tracer: &'a dyn Tracer<S>, batches: &'a Batches<S>) -> Self {
        Self::of_several([(tracer, batches)])
    }

    /// The same, each kind of ray timed by itself.
    pub fn by_kind(tracer: &'a dyn Tracer<S>, batches: &'a Batches<S>) -> Self {
        let parts = batches.iter().map(|(kind, _)| kind.name()).collect();
        Self { parts, ..Self::new(tracer, batches) }
    }

    /// Several structures, each with batches of its own.
    pub fn of_several(
        structures: impl IntoIterator<Item = (&'a dyn Tracer<S>, &'a Batches<S>)>,
    ) -> Self {
        let of_one = |(tracer, batches): (&'a dyn Tracer<S>, &'a Batches<S>)| {
            batches.iter().map(move |(kind, rays)| (tracer, *kind, rays))
        };
        let asked: Vec<_> = structures.into_iter().flat_map(of_one).collect();
        let answers = asked.iter().map(|(_, kind, rays)| Answers::new(*kind, rays.len())).collect();
        Self::answered_by(answers, move |batch, answers| {
            if let Some((tracer, _, rays)) = asked.get(batch) {
                trace(*tracer, rays, answers);
            }
        })
    }

    pub fn answered_by(
        answers: Vec<Answers<S>>,
        ask: impl FnMut(usize, &mut Answers<S>) + 'a,
    ) -> Self {
        let mut replay = Self { answers, parts: Vec::new(), ask: Box::new(ask) };
        replay.prepare();
        replay.run();
        replay
    }

    /// Number of answers that differ from another's to the same rays.
    pub fn differing(&self, other: &Self) -> u64 {
        let pairs = self.answers.iter().zip(&other.answers);
        pairs.map(|(a, b)| a.differing(b).count() as u64).sum()
    }
}

pub fn counted<S: Scalar>(tracer: &dyn Tracer<S>, batches: &Batches<S>) -> WorkCounters {
    let mut total = WorkCounters::default();
    for (kind, rays) in batches {
        total += if kind.is_occlusion() {
            tracer.count_occlusions(rays, &mut vec![false; rays.len()])
        } else {
            tracer.count_closest_hits(rays, &mut vec![Hit::NONE; rays.len()])
        };
    }
    total
}

impl<S: Buildable> Work for Replay<'_, S> {
    fn prepare(&mut self) {
        self.answers.iter_mut().for_each(Answers::clear);
    }

    fn run(&mut self) {
        (0..self.answers.len()).for_each(|part| self.run_part(part));
    }

    fn parts(&self) -> &[&'static str] {
        &self.parts
    }

    fn run_part(&mut self, part: usize) {
        if let Some(answers) = self.answers.get_mut(part) {
            (self.ask)(part, answers);
        }
    }

    fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.answers.iter().for_each(|answers| answers.bytes().hash(&mut hasher));
        hasher.finish()
    }
}

/// Counts the hits that `differ` from exact ones, and the occlusions that are not the same.
pub fn compare<S: Scalar, E: Scalar>(
    answers: &[Answers<S>],
    exact: &[Answers<E>],
    differ: impl Fn(&Hit<S>, &Hit<E>) -> bool,
) -> TrialCounts {
    let mut tally = TrialCounts::default();
    for pair in answers.iter().zip(exact) {
        match pair {
            (Answers::Hits(hits), Answers::Hits(exact)) => {
                hits.iter().zip(exact).for_each(|(hit, exact)| tally.add(differ(hit, exact)));
            }
            (Answers::Blocked(blocked), Answers::Blocked(exact)) => {
                blocked.iter().zip(exact).for_each(|(b, e)| tally.add(b != e));
            }
            _ => {}
        }
    }
    tally
}

pub trait Work {
    /// Undoes what the last run left, so that it cannot pass for this one's.
    fn prepare(&mut self) {}
    fn run(&mut self);
    /// Names of the parts that are timed one by one, in order; none where it is timed as a whole.
    fn parts(&self) -> &[&'static str] {
        &[]
    }
    /// The part of that number; all parts together are the work itself.
    fn run_part(&mut self, _part: usize) {
        self.run();
    }
    /// A number that changes with any answer of the last run.
    fn fingerprint(&self) -> u64;
}
