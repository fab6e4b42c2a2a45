//! The price of right answers as a whole: from the fastest known to right in f64, one step after
//! the other, all compiled alike, on the same rays.
//!
//! The first row is what is fastest: Moeller-Trumbore, boxes as tight as they come, hits that count
//! from a few ulps of the scene's size on. Each further row adds one thing. What a step costs and
//! what it removes depends on their order: an earlier one may hide what a later one is for.

use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray, Scalar, Vec3, Vector};
use measurement::rays::batches::{Answers, trace};
use renderer::ray_offset::{OffsetRule, RayOffset};
use renderer::surface::SurfacePoint;
use renderer::{Geometry, RayKind};

use super::secondary_rays::{Departure, GAP, SecondaryRays, height};
use super::triangle_aims::{KnownHit, judged, known_hits};
use crate::accuracy::axis::*;
use crate::accuracy::cost_tables::OFFSET_RAYS;
use crate::accuracy::stage::StagedStructure;

pub static AXIS: Axis = Axis {
    name: "right-answers",
    summary: "the price of right answers, step by step, from the fastest known to f64",
    paper: "Moeller, Trumbore 1997; Woop, Benthin, Wald 2013; Ize 2013",
    metric: "wrong answers in 10^6 rays, aimed at weak points of cheap variants",
    reference: "exact predicates; a plane is not met again from outside; height over the surface",
    scenes: &["mount", "gears-tess", "pavilion"],
    setting: "STRUCTURE.padding, STRUCTURE.adapter, STRUCTURE.triangle-test, rays.offset, run --precision",
    measure: Measure::Each {
        subjects: &["obvhs-cwbvh", "uniform-grid", "wide-bvh"],
        serves: |_, _| true,
        measure,
    },
};

/// A step: what it adds, the structure's settings from there on, how rays leave surfaces.
struct Step {
    adds: &'static str,
    settings: &'static str,
    offset: OffsetRule,
    is_double: bool,
}

const PLAIN: OffsetRule = OffsetRule::SceneRelative;
const BOUND: OffsetRule = OffsetRule::ErrorBound(4.0);

const fn step(adds: &'static str, settings: &'static str, offset: OffsetRule) -> Step {
    Step { adds, settings, offset, is_double: false }
}

const OBVHS: &[Step] = &[
    step("fastest known: obvhs as its authors use it", "", PLAIN),
    step("adapter, watertight test", ":adapter=robust:kernel=scalar", PLAIN),
    step("ray offset", ":adapter=robust:kernel=scalar", BOUND),
    step("blocks of eight", ":adapter=robust", BOUND),
    Step { adds: "f64", settings: ":adapter=robust", offset: BOUND, is_double: true },
];

const GRID: &[Step] = &[
    step(
        "fastest known: accumulated traversal, tight boxes, Moeller-Trumbore",
        ":kernel=scalar:traversal=accumulate:insertion=box:triangle-test=moeller-trumbore",
        PLAIN,
    ),
    step("voxel traversal", ":kernel=scalar:insertion=box:triangle-test=moeller-trumbore", PLAIN),
    step("box padding", ":kernel=scalar:triangle-test=moeller-trumbore", PLAIN),
    step("watertight test", ":kernel=scalar", PLAIN),
    step("ray offset", ":kernel=scalar", BOUND),
    step("blocks of eight", ":kernel=block", BOUND),
    Step { adds: "f64", settings: ":kernel=block", offset: BOUND, is_double: true },
];

const WIDE: &[Step] = &[
    step(
        "fastest known: no padding, Moeller-Trumbore",
        ":padding=none:triangle-test=moeller-trumbore",
        PLAIN,
    ),
    step("padding of boxes and rays", ":triangle-test=moeller-trumbore", PLAIN),
    step("watertight test", "", PLAIN),
    step("ray offset", "", BOUND),
    Step { adds: "f64", settings: "", offset: BOUND, is_double: true },
];

fn steps(subject: &str) -> &'static [Step] {
    match subject {
        "uniform-grid" => GRID,
        "wide-bvh" => WIDE,
        _ => OBVHS,
    }
}

const KINDS: usize = 3;

fn measure(stage: &Stage<'_>, subject: &str) -> Result<SceneOutcome, StudyError> {
    let most = stage.limits.aims / KINDS;
    let aims = known_hits(stage, most);
    if aims.iter().any(Vec::is_empty) {
        return Err(stage.unfit("the scene has no triangle mesh"));
    }
    let secondary = SecondaryRays::new(stage, stage.scene(), &stage.prepared.geometry)?;
    let double = Geometry::<f64>::of(stage.scene())?;
    let is_timed = |kind| matches!(kind, RayKind::Primary | RayKind::Diffuse | RayKind::Shadow);
    let batches = stage.batches(stage.limits.timed_rays, is_timed);
    let timed_most = stage.limits.timed_rays / KINDS;
    let judge =
        Judge { subject, aims: &aims, secondary: &secondary, judged: most, timed: timed_most };
    let mut variants = Vec::new();
    for step in steps(subject) {
        let label = format!("{subject}{}", step.settings);
        variants.push(if step.is_double {
            judge.variant(step, stage.over(&label, &double)?, widened(&batches))
        } else {
            judge.variant(step, stage.built(&label)?, batches.clone())
        });
    }
    let (all, left) = (count(&batches), secondary.departures.len());
    let (made, judged) = (left.min(timed_most), left.min(most));
    let work = format!("{all} rays of the scene and {made} that leave surfaces, made and traced");
    let [edges, middles] = aims.each_ref().map(Vec::len);
    let judged = format!(
        "{edges} rays at corners and edges, {middles} along axes and from close by, {judged} off \
         surfaces"
    );
    let said = SceneOutcome { is_stepwise: true, ..SceneOutcome::new(work, judged) };
    Ok(timed(stage, said, variants))
}

/// Columns of the wrong answers by kind of trial.
const WRONG: [&str; KINDS] = [
    "wrong in 10^6 at corners and edges",
    "wrong in 10^6 along axes and from close by",
    "wrong in 10^6 off surfaces",
];

struct Judge<'j, 'a> {
    subject: &'j str,
    aims: &'j [Vec<KnownHit>; 2],
    secondary: &'j SecondaryRays<'a>,
    /// Rays that leave surfaces, at most: judged ones and timed ones.
    judged: usize,
    timed: usize,
}

impl<'a> Judge<'_, 'a> {
    /// A step, judged; its work is `batches`, and the rays that leave surfaces.
    fn variant<S: Buildable>(
        &self,
        step: &Step,
        built: StagedStructure<'a, S>,
        batches: Batches<S>,
    ) -> Variant<'a> {
        let StagedStructure { tracer, known_defect, .. } = built;
        let offset = RayOffset::new(step.offset, self.secondary.magnitude);
        let of_aims = |known: &Vec<KnownHit>| {
            let rays: Vec<Ray<S>> = known.iter().map(|known| exactly(&known.ray)).collect();
            judged(&*tracer, known, &rays)
        };
        let [edges, middles] = self.aims.each_ref().map(of_aims);
        let found = [edges, middles, self.off_surfaces(&*tracer, offset)];
        let mut all_kinds = TrialCounts::default();
        found.iter().for_each(|counts| all_kinds.add_counts(*counts));
        let leaving: Vec<_> = self.leaving(self.timed).collect();
        let of_batches = batches.iter().map(|(kind, rays)| Answers::new(*kind, rays.len()));
        let answers = of_batches.chain([Answers::new(RayKind::Diffuse, leaving.len())]).collect();
        let parts = batches.iter().map(|(kind, _)| kind.name()).chain([OFFSET_RAYS]).collect();
        let mut made: Vec<Ray<S>> = Vec::new();
        let mut work = Replay::answered_by(answers, move |part, answers| {
            let rays = match batches.get(part) {
                Some((_, rays)) => rays,
                None => {
                    made.clear();
                    made.extend(leaving.iter().map(|(point, d)| offset.along(point, d.out)));
                    &made
                }
            };
            trace(&*tracer, rays, answers);
        });
        work.parts = parts;
        let precision = if step.is_double { " --precision f64" } else { "" };
        let rule = if step.offset == PLAIN { " --set rays.offset=scene-relative" } else { "" };
        let setting = format!("run -s {}{}{precision}{rule}", self.subject, step.settings);
        Variant::new(step.adds, setting, all_kinds.error(), work)
            .with_defect(known_defect)
            .as_reference(step.is_double)
            .also(WRONG.into_iter().zip(found.map(|counts| counts.error().value())))
    }

    /// Counts the rays that hit the surface they leave, or begin beyond a sheet close above it.
    fn off_surfaces<S: Buildable>(&self, tracer: &dyn Tracer<S>, offset: RayOffset) -> TrialCounts {
        let left: Vec<_> = self.leaving(self.judged).collect();
        let rays: Vec<Ray<S>> = left.iter().map(|(point, d)| offset.along(point, d.out)).collect();
        let mut hits = vec![Hit::NONE; rays.len()];
        tracer.closest_hits(&rays, &mut hits);
        let gap = GAP * self.secondary.diagonal;
        let mut counts = TrialCounts::default();
        for (((point, d), ray), hit) in left.iter().zip(&rays).zip(&hits) {
            counts.add(hit.id == d.id || height(point, ray) > gap);
        }
        counts
    }

    /// The first `most` hits, and the points that rays leave there.
    fn leaving(&self, most: usize) -> impl Iterator<Item = (SurfacePoint<'a>, Departure)> {
        self.secondary.departures.iter().take(most).map(|d| (self.secondary.point(d), *d))
    }
}

/// The same ray: nothing is rounded.
fn exactly<S: Scalar>(ray: &Ray<f32>) -> Ray<S> {
    let wide = ray.widened();
    Ray {
        origin: Vec3::<S>::from_dvec3(wide.origin),
        direction: Vec3::<S>::from_dvec3(wide.direction),
        t_min: S::from_f64(wide.t_min),
        t_max: S::from_f64(wide.t_max),
        time: S::from_f64(wide.time),
    }
}
