//! Rules that keep a ray off the surface it leaves: self-hits against leaks, and further costs.
//!
//! From each hit of an eye ray a ray leaves into the outer half-space, made as the renderer makes
//! it. Two demands are exact: flat primitives and spheres, seen from outside, are never met again
//! by a ray that leaves them; and a thin sheet that lies close above the surface is not passed, so
//! that the first point of the ray that counts lies below it. Further columns say how loose the
//! rule is ([`smallest_offset`]), how far it moves refracted rays ([`refracted_shift`]), and what
//! shadow rays a smoothly shaded mesh blocks itself ([`shadow_terminator`]).

use glam::DVec3;
use measurement::plan::ray_overrides::RULES;
use renderer::Geometry;
use scene_loading::Scene;

use super::refracted_shift::GlassEntries;
use super::secondary_rays::{GAP, SecondaryRays, SecondaryWork, height};
use super::shadow_terminator::LitPoints;
use super::smallest_offset::SmallestOffsets;
use crate::accuracy::axis::*;

pub static AXIS: Axis = Axis {
    name: "ray-offset",
    summary: "offset of a ray from the surface it leaves: none, fixed, ulps, error bound",
    paper: "Waechter, Binder 2019; Pharr, Jakob, Humphreys 2016",
    metric: "rays in 10^6 that hit what they leave, or begin beyond a sheet close above it",
    reference: "a plane or a sphere is not met again from outside; height over the surface",
    scenes: &["balls", "teapot", "pavilion"],
    setting: "rays.offset",
    measure: Measure::Whole(measure),
};

/// How far a scene is moved, in its diagonals, to see what is left of the rule there.
const MOVED: f64 = 100.0;

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let scene = stage.scene();
    let here = SecondaryRays::new(stage, scene, &stage.prepared.geometry)?;
    let moved = moved(scene);
    let moved_geometry = Geometry::<f32>::of(&moved)?;
    let there = SecondaryRays::new(stage, &moved, &moved_geometry)?;
    let double = Geometry::<f64>::of(scene)?;
    let smallest = SmallestOffsets::new(&here, &stage.prepared.geometry, &double);
    let glass = GlassEntries::new(stage, &here, &double)?;
    let lit = LitPoints::new(scene, &here);
    let mut variants = Vec::new();
    for (name, rule) in RULES {
        let work = here.work(rule, here.outward());
        let [self_hits, leaks] = judged(&here, &work);
        let [far, _] = judged(&there, &there.work(rule, there.outward()));
        let wrong = self_hits.wrong() + leaks.wrong();
        let error = ErrorOf::Counted { wrong, trials: here.departures.len() as u64 };
        let looseness = smallest.columns(&here, &work);
        let variant = work.variant(name, error, stage.limits.timed_rays).also([
            ("self-hits in 10^6", self_hits.error().value()),
            ("leaks in 10^6", leaks.error().value()),
            ("self-hits in 10^6 100 diagonals away", far.error().value()),
        ]);
        let variant = variant.also(looseness).also(glass.columns(&here, rule));
        variants.push(variant.also(lit.columns(&here, rule)));
    }
    let rays = here.departures.len();
    let said = SceneOutcome::new(
        format!("{} rays made and traced through {TRACER}", rays.min(stage.limits.timed_rays)),
        format!(
            "{rays} rays from flat primitives and spheres; a sheet {GAP:e} diagonals above; {}; {}; {}",
            smallest.words(),
            glass.words(),
            lit.words()
        ),
    );
    Ok(timed(stage, said, variants))
}

fn moved(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let by = DVec3::new(0.62, -0.54, 0.57) * diagonal(&scene) * MOVED;
    scene.rebase(scene.origin - by);
    scene
}

fn judged(secondary: &SecondaryRays<'_>, work: &SecondaryWork<'_>) -> [TrialCounts; 2] {
    let [mut self_hits, mut leaks] = [TrialCounts::default(); 2];
    for (departure, (point, ray, hit)) in secondary.departures.iter().zip(work.outcomes()) {
        self_hits.add(hit.id == departure.id);
        leaks.add(height(point, ray) > GAP * secondary.diagonal);
    }
    [self_hits, leaks]
}
