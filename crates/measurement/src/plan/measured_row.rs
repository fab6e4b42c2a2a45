//! Rows of a run: a structure answers all rays, an occluder shadow rays only.

use accel_core::occluders::{self, BoxedOccluder};
use accel_core::primitives::PrimsRef;
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::{Foreign, Tracer};
use accel_core::registry::{self, Buildable, RegistryItem};
use accel_core::structure::{Batches, BuildError, StructureStats};
use accel_core::structures::Entry;
use glam::DVec3;
use rayon::prelude::*;
use renderer::RayKind;

use crate::plan::error::PlanError;
use crate::plan::rows::{self, Row};
use crate::rays::batches::{Answers, Batch, CHUNK, trace, trace_chunked};
use crate::rays::exactness::Exactness;
use crate::record::query::Query;
use crate::record::{AnsweredRays, RowRecord, Verdict};
use crate::system::clock::{Clock, timed};

#[derive(Debug, Clone, PartialEq)]
pub enum MeasuredRow<'r> {
    Structure(Row<'r>),
    Occluder(Row<'r, occluders::OccluderRegistry>),
}

/// Calls the same on whichever row it is.
macro_rules! either {
    ($self:ident, $row:ident => $call:expr) => {
        match $self {
            MeasuredRow::Structure($row) => $call,
            MeasuredRow::Occluder($row) => $call,
        }
    };
}

impl MeasuredRow<'_> {
    pub fn structure(&self) -> &'static str {
        either!(self, row => row.structure())
    }

    pub fn settings(&self) -> String {
        either!(self, row => row.settings())
    }

    pub fn label(&self) -> String {
        either!(self, row => row.label())
    }

    pub fn known_defect(&self) -> Option<&'static str> {
        either!(self, row => row.known_defect())
    }

    pub fn is_sampled(&self) -> bool {
        either!(self, row => row.is_sampled())
    }

    pub fn answers(&self, kind: RayKind) -> bool {
        match self {
            Self::Structure(_) => true,
            Self::Occluder(_) => kind.is_occlusion(),
        }
    }

    /// Returns whether it answers rays of one kind only.
    pub fn is_occluder(&self) -> bool {
        matches!(self, Self::Occluder(_))
    }

    pub fn unmeasured(&self, verdict: Verdict, error: Option<String>) -> RowRecord {
        RowRecord {
            answers: match self {
                Self::Structure(_) => AnsweredRays::AllRays,
                Self::Occluder(_) => AnsweredRays::ShadowRays,
            },
            known_defect: self.known_defect().map(Into::into),
            error,
            ..RowRecord::unmeasured(self.structure().into(), self.settings(), verdict)
        }
    }

    /// Reads its settings. What is left is the build, which alone is timed.
    pub fn prepare<S: Buildable>(&self) -> PreparedRow<S> {
        match self {
            Self::Structure(row) => {
                let build = row.entry.prepare(&row.params);
                Box::new(move |prims, _| Ok(BuiltRow::Structure(build(prims, None)?)))
            }
            Self::Occluder(row) => {
                let build = row.entry.prepare(&row.params);
                Box::new(move |prims, lights| Ok(BuiltRow::Occluder(build(prims, lights)?)))
            }
        }
    }
}

/// A row whose settings have been read, to be built over a scene with those lights.
pub type PreparedRow<S> = Box<
    dyn for<'a> Fn(PrimsRef<'a, S>, &[DVec3]) -> Result<BuiltRow<'a, S>, BuildError> + Send + Sync,
>;

pub enum BuiltRow<'a, S: Buildable> {
    Structure(Box<dyn Tracer<S> + 'a>),
    Occluder(BoxedOccluder<'a, S>),
}

impl<S: Buildable> BuiltRow<'_, S> {
    /// Answers a batch in one call; an occluder leaves closest hits as they are.
    pub fn trace(&self, batch: &Batch<'_, S>, answers: &mut Answers<S>) {
        match (self, answers) {
            (Self::Structure(tracer), answers) => trace(&**tracer, &batch.rays, answers),
            (Self::Occluder(occluder), Answers::Blocked(blocked)) => {
                occluder.occlusions(&batch.rays, &batch.lights, blocked);
            }
            (Self::Occluder(_), Answers::Hits(_)) => {}
        }
    }

    /// The same in chunks over the current rayon pool.
    pub fn trace_chunked(&self, batch: &Batch<'_, S>, answers: &mut Answers<S>) {
        match (self, answers) {
            (Self::Structure(tracer), answers) if tracer.foreign().is_some() => {
                trace(&**tracer, &batch.rays, answers);
            }
            (Self::Structure(tracer), answers) => trace_chunked(&**tracer, &batch.rays, answers),
            (Self::Occluder(occluder), Answers::Blocked(blocked)) => batch
                .rays
                .par_chunks(CHUNK)
                .zip(batch.lights.par_chunks(CHUNK))
                .zip(blocked.par_chunks_mut(CHUNK))
                .for_each(|((rays, lights), blocked)| occluder.occlusions(rays, lights, blocked)),
            (Self::Occluder(_), Answers::Hits(_)) => {}
        }
    }

    /// The counting pass over a batch, in chunks over the current pool; sums do not depend on order.
    /// An occluder leaves closest hits as they are.
    pub fn count(&self, batch: &Batch<'_, S>) -> (Answers<S>, WorkCounters) {
        let mut answers = batch.unexpected();
        let chunk = self.chunk(batch);
        let rays = batch.rays.par_chunks(chunk);
        let work = match (self, &mut answers) {
            (Self::Structure(tracer), Answers::Hits(hits)) => rays
                .zip(hits.par_chunks_mut(chunk))
                .map(|(rays, hits)| tracer.count_closest_hits(rays, hits))
                .reduce(WorkCounters::default, sum),
            (Self::Structure(tracer), Answers::Blocked(blocked)) => rays
                .zip(blocked.par_chunks_mut(chunk))
                .map(|(rays, blocked)| tracer.count_occlusions(rays, blocked))
                .reduce(WorkCounters::default, sum),
            (Self::Occluder(occluder), Answers::Blocked(blocked)) => rays
                .zip(batch.lights.par_chunks(chunk))
                .zip(blocked.par_chunks_mut(chunk))
                .map(|((rays, lights), blocked)| occluder.count_occlusions(rays, lights, blocked))
                .reduce(WorkCounters::default, sum),
            (Self::Occluder(_), Answers::Hits(_)) => WorkCounters::default(),
        };
        (answers, work)
    }

    /// Its way to answer the rays of a batch: one by one or together.
    pub fn query(&self) -> Query {
        match self.batches() {
            _ if self.foreign().is_some_and(Foreign::answers_batches) => Query::Batch,
            Batches::Together | Batches::Packets => Query::Batch,
            Batches::RayByRay | Batches::Library => Query::OneRay,
        }
    }

    fn batches(&self) -> Batches {
        match self {
            Self::Structure(tracer) => tracer.batches(),
            Self::Occluder(occluder) => occluder.batches(),
        }
    }

    /// Required agreement of its answers with the expected ones.
    pub fn exactness(&self) -> Exactness {
        Exactness::of(self.foreign(), self.batches())
    }

    /// Its origin, if its code is not part of this program.
    pub fn foreign(&self) -> Option<&dyn Foreign> {
        match self {
            Self::Structure(tracer) => tracer.foreign(),
            Self::Occluder(_) => None,
        }
    }

    /// Rays of a batch that one thread counts at a time, whatever the number of threads. Packets are
    /// made of all of them, as where one thread is timed; a foreign structure divides them itself.
    fn chunk(&self, batch: &Batch<'_, S>) -> usize {
        let is_whole = self.foreign().is_some() || self.batches() == Batches::Packets;
        if is_whole { batch.rays.len().max(1) } else { CHUNK }
    }

    /// Seconds that it takes to answer a batch: in one call, or with several threads in chunks over
    /// the current rayon pool. A foreign structure divides batches itself, and is timed where it is
    /// called.
    pub fn timed(
        &self,
        clock: &dyn Clock,
        batch: &Batch<'_, S>,
        answers: &mut Answers<S>,
        threads: usize,
    ) -> f64 {
        let ((), seconds) = timed(clock, || match threads {
            1 => self.trace(batch, answers),
            _ => self.trace_chunked(batch, answers),
        });
        self.foreign().map_or(seconds, Foreign::take_seconds)
    }

    /// Why nothing that it answered counts.
    pub fn alive(&self) -> Result<(), BuildError> {
        let failure = self.foreign().and_then(Foreign::failure);
        failure.map_or(Ok(()), |how| Err(BuildError::Died(how)))
    }

    pub fn stats(&self) -> StructureStats {
        match self {
            Self::Structure(tracer) => tracer.stats(),
            Self::Occluder(occluder) => occluder.stats(),
        }
    }
}

fn sum(mut one: WorkCounters, other: WorkCounters) -> WorkCounters {
    one += other;
    one
}

/// The rows that `-s` and `--set` ask for: of structures and of occluders. Each of both registries
/// sees what names its lines; `all`, or nothing, means all of both.
#[allow(clippy::type_complexity)]
pub fn select<'r>(
    registry: &'r [Entry],
    occluders: &'r [occluders::Entry],
    names: &[String],
    overrides: &[String],
) -> Result<(Vec<Row<'r>>, Vec<Row<'r, occluders::OccluderRegistry>>), PlanError> {
    let name_of =
        |text: &str| text.split([':', ' ', '.']).find(|p| !p.is_empty()).map(str::to_owned);
    let is_occluder = |text: &&String| {
        name_of(text).is_some_and(|name| occluders.iter().any(|o| o.info.name == name))
    };
    let known =
        || registry.iter().map(|e| e.info.name).chain(occluders.iter().map(|e| e.info.name));
    for text in names.iter().filter(|n| *n != "all") {
        let name = name_of(text).unwrap_or_default();
        if known().all(|known| known != name) {
            return Err(PlanError::unknown("structure", &name, known()));
        }
    }
    let split = |texts: &[String]| -> (Vec<String>, Vec<String>) {
        texts.iter().cloned().partition(|t| is_occluder(&t))
    };
    let (mut of_occluders, mut of_structures) = split(names);
    let (set_occluders, set_structures) = split(overrides);
    if names.is_empty() || names.iter().any(|n| n == "all") {
        of_occluders.insert(0, "all".to_owned());
        if of_structures.is_empty() {
            of_structures.push("all".to_owned());
        }
    }
    let structures = select_of(registry, &of_structures, &set_structures)?;
    Ok((structures, select_of(occluders, &of_occluders, &set_occluders)?))
}

/// The rows of one registry; of no names none.
fn select_of<'r, L: RegistryItem>(
    registry: &'r [registry::Entry<L>],
    names: &[String],
    overrides: &[String],
) -> Result<Vec<Row<'r, L>>, PlanError> {
    match (names, overrides) {
        ([], []) => Ok(Vec::new()),
        // a setting of a structure that is not measured is an error all the same
        ([], _) => Err(rows::override_without_row(registry, overrides)),
        _ => rows::select(registry, names, overrides),
    }
}
