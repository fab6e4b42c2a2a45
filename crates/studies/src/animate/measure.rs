//! Measuring an animation: frames in their order, in each all rows and rounds in a seeded random
//! order. A lane is a row with a number of threads, from frame to frame.

use accel_core::params::Params;
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::{KeptStructure, PreviousFrame};
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::Entry;
use accel_core::update;
use measurement::answers::arbiter::Arbiter;
use measurement::answers::check::stride_for;
use measurement::answers::judge::judge;
use measurement::answers::reference::{Reference, Stage};
use measurement::plan::measured_row::{BuiltRow, MeasuredRow};
use measurement::rays::batches::{Answers, Batch, BatchSet};
use measurement::record::WorkRecord;
use measurement::rounds::MeasureError;
use measurement::rounds::interleaved::round_order;
use measurement::rounds::scene_run::lights_asked;
use measurement::rounds::scope::Scope;
use measurement::system::clock::{Clock, timed};
use measurement::system::panics::caught;
use measurement::system::pools::{Pools, pool};
use measurement::system::progress::Progress;
use rayon::ThreadPool;
use renderer::Geometry;
use scene_loading::{LoadError, Scene};

use crate::animate::Animate;
use crate::animate::quality::{SurfacePoint, quality, surface_points};
use crate::animate::record::{AnimationRecord, FrameRecord, LaneFrame, LaneRecord};
use crate::error::StudyError;

/// Measures all frames, which `scene_of` makes by their numbers, into `record`; the bar has a step
/// for each. `watch` sees what there is after each.
pub fn measure<S: Buildable>(
    animate: &Animate<'_>,
    mut scene_of: impl FnMut(u32) -> Result<Scene, LoadError>,
    (clock, progress): (&dyn Clock, &Progress),
    record: &mut AnimationRecord,
    mut watch: impl FnMut(&mut AnimationRecord),
) -> Result<(), StudyError> {
    let plan = &animate.plan;
    let pools = Pools::new(plan.threads)?;
    let measured = animate.threads.iter();
    let measured = measured.map(|&n| Ok(pool(n)?)).collect::<Result<Vec<_>, StudyError>>()?;
    let mut lanes: Vec<Lane<'_>> = plan
        .rows
        .iter()
        .flat_map(|row| measured.iter().filter_map(|pool| Lane::new(row, pool, animate.rounds)))
        .collect();
    let (mut first, mut before): (Option<Geometry<S>>, Option<Geometry<S>>) = (None, None);
    let [begin, end] = animate.frames;
    for number in begin..=end {
        progress.message(format!("{}: frame {number}", animate.scene));
        let scene = scene_of(number).map_err(MeasureError::from)?;
        let exact = Geometry::<f64>::of(&scene)?;
        let mut geometry = Geometry::<S>::of(&scene)?;
        if let Some(first) = &first {
            geometry.keep_rigid(first);
        }
        let moved = before.as_ref().and_then(|before| geometry.moved_since(before));
        let frame = Frame { number, scene, geometry, exact, moved };
        if number > begin && frame.moved.is_none() {
            // no structure of the frame before can be updated
            lanes.iter_mut().for_each(|lane| lane.kept.fill_with(|| None));
        }
        let visited = visit_all(animate, &frame, &pools, (clock, progress), &mut lanes)?;
        record.frames.push(visited);
        record.lanes = lanes.iter().map(|lane| lane.record.clone()).collect();
        watch(record);
        progress.step(clock.now());
        let done = before.replace(frame.geometry);
        if first.is_none() {
            first = done;
        }
    }
    Ok(())
}

/// All rounds of all rows on a frame.
fn visit_all<S: Buildable>(
    animate: &Animate<'_>,
    frame: &Frame<S>,
    pools: &Pools,
    (clock, progress): (&dyn Clock, &Progress),
    lanes: &mut [Lane<'_>],
) -> Result<FrameRecord, StudyError> {
    let plan = &animate.plan;
    let arbiter = Arbiter::new(&frame.geometry, &frame.exact)
        .map_err(MeasureError::of_build(&frame.scene.name))?;
    let stage = Stage { scene: &frame.scene, geometry: &frame.geometry, arbiter: &arbiter };
    let Reference { rays, answers, record: mut judged } = stage.reference(plan, pools)?;
    let lights = lights_asked(&frame.scene, &plan.settings);
    let asked = BatchSet::new(&rays, answers, &lights);
    let asked = asked.in_orders(plan.orders, plan.seed, &frame.scene.name);
    let points = surface_points(frame.geometry.prims(), plan.seed);
    let on = FrameInput {
        frame,
        scope: Scope { plan, stage: &stage, lights: &lights, all: &asked, pools, clock, progress },
        points: &points,
    };
    let what = format!("{}/{}", animate.scene, frame.number);
    for round in 0..animate.rounds {
        for lane in round_order(plan.seed, &what, round, lanes.len()) {
            let Some(lane) = lanes.get_mut(lane).filter(|lane| lane.record.error.is_none()) else {
                continue;
            };
            lane.record.error = match caught(|| lane.visit(&on, round)) {
                Ok(Ok(())) => None,
                Ok(Err(error)) => Some(format!("frame {}: {error}", frame.number)),
                Err(panicked) => Some(format!("frame {}: {panicked}", frame.number)),
            };
        }
    }
    if let (Some(first), n @ 1..) = (&judged.reference, arbiter.contradicted()) {
        for lane in lanes.iter_mut().filter(|lane| lane.record.label() == *first) {
            lane.record.mismatches += n as u64;
        }
        judged.refused.push(format!("{first}: wrong on {n} rays that others answered otherwise"));
    }
    Ok(FrameRecord {
        frame: frame.number,
        primitives: frame.geometry.len() as u64,
        moved: frame.moved.as_ref().map(|moved| moved.len() as u64),
        rays: asked.total() as u64,
        oracle: judged,
    })
}

/// Rays of a kind that a first look takes.
const LOOK_RAYS: usize = 1024;

pub struct FrameInput<'a, 'r, S: Buildable> {
    pub frame: &'a Frame<S>,
    /// Its rays, with the answers expected.
    pub scope: Scope<'a, 'r, S>,
    pub points: &'a [SurfacePoint],
}

/// A row with a number of threads.
pub struct Lane<'p> {
    entry: &'p Entry,
    params: &'p Params,
    pool: &'p ThreadPool,
    /// The structures of the frame before, one a round; none where it is built anew in any case.
    pub(super) kept: Vec<Option<KeptStructure>>,
    /// Stride of the rays that are timed; none before the first look.
    stride: Option<usize>,
    pub record: LaneRecord,
}

impl<'p> Lane<'p> {
    /// Before the first frame; none of an occluder.
    pub fn new(row: &'p MeasuredRow<'p>, pool: &'p ThreadPool, rounds: usize) -> Option<Self> {
        let MeasuredRow::Structure(of) = row else { return None };
        Some(Self {
            entry: of.entry,
            params: &of.params,
            pool,
            kept: (0..rounds).map(|_| None).collect(),
            stride: None,
            record: LaneRecord {
                structure: row.structure().into(),
                settings: row.settings(),
                threads: pool.current_num_threads(),
                known_defect: row.known_defect().map(Into::into),
                stride: 1,
                ..LaneRecord::default()
            },
        })
    }

    /// Takes the structure of a round to a frame and asks it.
    pub fn visit<S: Buildable>(
        &mut self,
        on: &FrameInput<'_, '_, S>,
        round: usize,
    ) -> Result<(), BuildError> {
        let Self { entry, params, pool, kept, .. } = self;
        let prims = on.frame.geometry.prims();
        let kept = kept.get_mut(round).and_then(Option::take);
        let before = kept.zip(on.frame.moved.as_deref());
        let before = before.map(|(kept, moved)| PreviousFrame { kept, moved });
        let build = entry.prepare(params);
        let (tracer, update_s) = pool.install(|| timed(on.scope.clock, || build(prims, before)));
        let built = BuiltRow::Structure(tracer?);
        let update_s = built.foreign().map_or(update_s, |foreign| foreign.build_seconds());
        let stride = *self.stride.get_or_insert_with(|| first_look(&built, on, self.pool));
        let thinned = on.scope.all.thinned(stride);
        let trace_s = stride as f64 * self.traced(&built, on, &thinned);
        built.alive()?;
        let is_looked_at = round == 0 && self.record.threads == 1;
        let work = is_looked_at.then(|| self.counted(&built, on, &thinned)).flatten();
        let BuiltRow::Structure(tracer) = built else { return Ok(()) };
        let number = on.frame.number;
        if self.record.frames.last().is_none_or(|frame| frame.frame != number) {
            let quality = is_looked_at.then(|| quality(&*tracer, on.points)).flatten();
            self.record.frames.push(LaneFrame {
                frame: number,
                bytes: tracer.stats().bytes,
                expected_cost: quality.map(|q| q.expected_cost),
                overlap: quality.and_then(|q| q.overlap),
                ..LaneFrame::default()
            });
        }
        self.record.stride = stride;
        if let Some(frame) = self.record.frames.last_mut() {
            frame.updated += usize::from(tracer.is_updated());
            frame.update_s.push(update_s);
            frame.trace_s.push(trace_s);
            frame.work = work.or(frame.work.take());
        }
        let is_kept = self.params.get(update::REFIT.name).is_some_and(|way| way != "rebuild");
        if let Some(room) = self.kept.get_mut(round).filter(|_| is_kept) {
            *room = tracer.released();
        }
        Ok(())
    }

    /// Seconds of the rays; their answers are compared.
    fn traced<S: Buildable>(
        &mut self,
        built: &BuiltRow<'_, S>,
        on: &FrameInput<'_, '_, S>,
        asked: &BatchSet<'_, S>,
    ) -> f64 {
        let mut seconds = 0.0;
        for batch in &asked.batches {
            let mut answers = Answers::new(batch.kind, batch.rays.len());
            answers.poison(&batch.expected);
            let threads = self.record.threads;
            let timed = || built.timed(on.scope.clock, batch, &mut answers, threads);
            seconds += self.pool.install(timed);
            self.judge(on, built, (asked, batch), &answers);
        }
        seconds
    }

    /// The work of the rays; the answers of the counting pass are compared as well.
    fn counted<S: Buildable>(
        &mut self,
        built: &BuiltRow<'_, S>,
        on: &FrameInput<'_, '_, S>,
        asked: &BatchSet<'_, S>,
    ) -> Option<WorkRecord> {
        if built.foreign().is_some_and(|foreign| !foreign.has_counters()) {
            return None;
        }
        let mut all = WorkCounters::default();
        for batch in &asked.batches {
            let (answers, work) = on.scope.pools.helper.install(|| built.count(batch));
            self.judge(on, built, (asked, batch), &answers);
            all += work;
        }
        Some(WorkRecord::of(asked.total(), &all))
    }

    /// Counts the wrong answers to a batch.
    fn judge<S: Buildable>(
        &mut self,
        on: &FrameInput<'_, '_, S>,
        built: &BuiltRow<'_, S>,
        (asked, batch): (&BatchSet<'_, S>, &Batch<'_, S>),
        answers: &Answers<S>,
    ) {
        let judged = judge(on.scope.stage, asked, batch, answers, built.exactness());
        self.record.mismatches += judged.wrong as u64;
        if self.record.example.is_none() {
            let number = on.frame.number;
            self.record.example = judged.example.map(|text| format!("frame {number}: {text}"));
        }
    }
}

/// Stride of the rays to time, by what few rays take.
fn first_look<S: Buildable>(
    built: &BuiltRow<'_, S>,
    on: &FrameInput<'_, '_, S>,
    pool: &ThreadPool,
) -> usize {
    let all = on.scope.all;
    let few = all.thinned((all.longest() / LOOK_RAYS).max(1));
    let of_batch = |batch: &Batch<'_, S>| {
        let mut answers = Answers::new(batch.kind, batch.rays.len());
        let mut seconds = || pool.install(|| built.timed(on.scope.clock, batch, &mut answers, 1));
        // the first time warms up
        seconds().min(seconds())
    };
    let seconds: f64 = few.batches.iter().map(of_batch).sum();
    stride_for(seconds * few.stride as f64, on.scope.plan.limits.timed_pass)
}

pub struct Frame<S: Buildable> {
    pub number: u32,
    /// The scene at rest.
    pub scene: Scene,
    /// Geometry that structures are built over.
    pub geometry: Geometry<S>,
    pub exact: Geometry<f64>,
    /// Ids of the primitives that are others than in the frame before, ascending; none in the
    /// first, and where there are not the same primitives in both.
    pub moved: Option<Vec<u32>>,
}
