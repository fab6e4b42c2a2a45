//! The test of triangles: what leaks, and what it takes not to.

use accel_core::primitives::PrimsRef;
use accel_core::primitives::{PrimSet, PrimitiveKind};
use accel_core::variants::chosen_tests::{Choice, SphereChoice, TriangleChoice, visit_tested};

use super::chosen_tests::{NearestOf, variant};
use super::triangle_aims::{AimedRay, SharedFeatures};
use crate::accuracy::axis::{Axis, Measure};
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::stage::{PreparedScene, Stage, count};
use crate::accuracy::timing::{AxisReport, timed};
use crate::error::StudyError;

pub static AXIS: Axis = Axis {
    name: "triangle-test",
    summary: "tests of triangles: Moeller-Trumbore, Pluecker, watertight, f64",
    paper: "Moeller, Trumbore 1997; Shoemake 1998; Woop, Benthin, Wald 2013",
    metric: "rays in 10^6, aimed at corners and edges within a mesh, that pass through it",
    reference: "exact predicates",
    scenes: &["teapot", "mount", "pavilion"],
    setting: "STRUCTURE.triangle-test",
    measure: Measure::Each { subjects: SUBJECTS, serves, measure },
};

/// Through what the tests are timed: triangles one by one, then in blocks of eight.
const SUBJECTS: &[&str] = &["uniform-grid:kernel=scalar", "uniform-grid", "wide-bvh"];

/// Blocks are of triangles alone: in other scenes they would repeat what is tested one by one.
fn serves(prepared: &PreparedScene, subject: &str) -> bool {
    let is_one_by_one = subject.ends_with("kernel=scalar");
    is_one_by_one || matches!(prepared.geometry.prims(), PrimsRef::Watertight(_))
}

/// Values of the setting, and the test each is.
pub const TESTS: [(&str, TriangleChoice); 6] = [
    ("moeller-trumbore", TriangleChoice::MoellerTrumbore),
    ("moeller-trumbore-epsilon", TriangleChoice::Tolerant),
    ("pluecker", TriangleChoice::Pluecker),
    ("watertight", TriangleChoice::Watertight),
    ("watertight-fallback", TriangleChoice::Fallback),
    ("f64", TriangleChoice::Double),
];

fn measure(stage: &Stage<'_>, subject: &str) -> Result<SceneOutcome, StudyError> {
    let prims = stage.prepared.geometry.prims();
    let labels = TESTS.map(|(name, _)| format!("{subject}:triangle-test={name}"));
    let built = stage.built_all(&labels.each_ref().map(String::as_str))?;
    let batches = stage.all_batches();
    let rays = count(&batches);
    let aims = match prims {
        PrimsRef::Watertight(set) => aims(stage, set),
        PrimsRef::Mixed(set) => aims(stage, set),
    };
    if aims.is_empty() {
        return Err(stage.unfit("no edge or corner of it is surrounded by triangles"));
    }
    let hit = |triangle: TriangleChoice| {
        let choice = Choice { triangle, sphere: SphereChoice::Rearranged };
        visit_tested(prims, choice, NearestOf { aims: &aims }).unwrap_or_default()
    };
    let exact = hit(TriangleChoice::Double);
    let variants = built.iter().zip(TESTS).map(|(built, (name, test))| {
        let answers = hit(test).into_iter().zip(&exact).map(|(t, exact)| (t, *exact, t.is_none()));
        variant(name, built, &batches, answers)
    });
    let said = AxisReport {
        timed: format!("{rays} rays of the scene through {subject}"),
        judged: format!("{} rays at corners and edges within the mesh", aims.len()),
        ..AxisReport::default()
    };
    let variants = variants.collect();
    Ok(timed(stage, said, variants))
}

/// Rays at the corners and edges of the scene's meshes.
fn aims<P: PrimSet<f32>>(stage: &Stage<'_>, set: &P) -> Vec<AimedRay> {
    let mut balls = Vec::new();
    let corners = |id: u32| {
        balls.clear();
        set.hull(id, &mut balls);
        match (set.kind(id), balls.as_slice()) {
            (PrimitiveKind::Triangle, [a, b, c]) => {
                Some((id, [a, b, c].map(|p| p.center.as_vec3().to_array())))
            }
            _ => None,
        }
    };
    let triangles: Vec<_> = (0..set.len() as u32).filter_map(corners).collect();
    let shared = SharedFeatures::new(&triangles);
    let bounds = set.scene_bounds();
    let (centre, reach) = ((bounds.min + bounds.max) * 0.5, bounds.size().length());
    let mut random = stage.random("aims");
    // some of what is drawn is an outline or open
    let drawn = (0..stage.trials() * 8).filter_map(|_| shared.aim(&mut random, centre, reach));
    drawn.take(stage.trials()).collect()
}
