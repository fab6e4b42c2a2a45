//! The tests of triangles and of spheres: what leaks or errs, and what it takes not to.
//!
//! Of triangles, rays at corners and edges within a mesh are judged ([`super::triangle_aims`]); of
//! spheres, rays that pass the centre at 0.95 or 1.05 of the radius, from 10 to 10^4 radii away: f64
//! tells on which side, with room to spare.

use accel_core::primitives::{PrimSet, PrimitiveKind, Primitives, PrimsRef};
use accel_core::variants::chosen_tests::{
    Choice, SPHERE_TESTS, SphereChoice, TRIANGLE_TESTS, TestedSetVisitor, TriangleChoice,
    visit_tested,
};
use accel_core::{Ray, Vector};
use glam::DVec3;
use renderer::RaySettings;
use scene_loading::Scene;
use statistics::estimate::median;

use super::triangle_aims::{AimedRay, SharedFeatures, triangles};
use crate::accuracy::axis::*;
use crate::accuracy::stage::PreparedScene;
use crate::verify::draw::{direction, unit};

pub static TRIANGLES: Axis = Axis {
    name: "triangle-test",
    summary: "tests of triangles: Moeller-Trumbore, Pluecker, watertight, f64",
    paper: "Moeller, Trumbore 1997; Shoemake 1998; Woop, Benthin, Wald 2013",
    metric: "rays in 10^6, aimed at corners and edges within a mesh, that pass through it",
    reference: "exact predicates",
    scenes: &["teapot", "mount", "pavilion"],
    setting: "STRUCTURE.triangle-test",
    measure: Measure::Each { subjects: SUBJECTS, serves, measure: test_triangles },
};

/// Through what the tests are timed: triangles one by one, then in blocks of eight.
const SUBJECTS: &[&str] = &["uniform-grid:kernel=scalar", "uniform-grid", "wide-bvh"];

/// Blocks are of triangles alone: in other scenes they would repeat what is tested one by one.
fn serves(prepared: &PreparedScene, subject: &str) -> bool {
    let is_one_by_one = subject.ends_with("kernel=scalar");
    is_one_by_one || matches!(prepared.geometry.prims(), PrimsRef::Watertight(_))
}

fn test_triangles(stage: &Stage<'_>, subject: &str) -> Result<SceneOutcome, StudyError> {
    let aims = aims(stage, stage.prepared.geometry.prims());
    if aims.is_empty() {
        return Err(stage.unfit("no edge or corner of it is surrounded by triangles"));
    }
    let sphere = SphereChoice::Rearranged;
    let tests = TRIANGLE_TESTS.map(|(name, triangle)| (name, Choice { triangle, sphere }));
    let said = SceneOutcome::new(
        format!("of the scene through {subject}"),
        format!("{} rays at corners and edges within the mesh", aims.len()),
    );
    let is_met = vec![true; aims.len()];
    compared(stage, &format!("{subject}:triangle-test"), &tests, (&aims, &is_met), said)
}

/// Rays at the corners and edges of the scene's meshes.
fn aims(stage: &Stage<'_>, prims: PrimsRef<'_, f32>) -> Vec<AimedRay> {
    let triangles = triangles(prims);
    let shared = SharedFeatures::new(&triangles);
    let bounds = stage.bounds();
    let (centre, reach) = ((bounds.min + bounds.max) * 0.5, bounds.size().length());
    let mut random = stage.random("aims");
    // some of what is drawn is an outline or open
    let drawn = (0..stage.trials() * 8).filter_map(|_| shared.aim(&mut random, centre, reach));
    drawn.take(stage.trials()).collect()
}

pub static SPHERES: Axis = Axis {
    name: "sphere-test",
    summary: "tests of spheres: the quadratic as it stands, rearranged, in f64",
    paper: "Glassner 1989; Haines, Guenther, Akenine-Moeller 2019",
    metric: "rays in 10^6, 10 to 10^4 radii away, that hit or miss a sphere wrongly",
    reference: "distance of the centre from the ray, clear by 2% of the radius",
    scenes: &["balls", "rings", "pavilion"],
    setting: "STRUCTURE.sphere-test",
    measure: Measure::Whole(test_spheres),
};

fn test_spheres(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    if !stage.scene().spheres.is_empty() {
        return test_spheres_of(stage, "the scene");
    }
    let beads = beads(stage.scene()).ok_or_else(|| stage.unfit("it has no corners"))?;
    let resolution = [if stage.limits.quick { 32 } else { 96 }; 2];
    let settings = RaySettings { resolution, ..RaySettings::default() };
    let prepared = PreparedScene::new(beads, stage.registry, &settings)?;
    let stage = &Stage { prepared: &prepared, ..*stage };
    test_spheres_of(stage, "a bead at a corner of each primitive")
}

/// A scene without spheres as beads: one at the first corner of each primitive, its radius a
/// quarter of the mean side of their boxes.
fn beads(scene: &Scene) -> Option<Scene> {
    let mut beads = scene.clone();
    beads.primitives.clear();
    let sides = scene.primitives.iter().map(|p| scene.shape_bounds(p.shape).size().max_element());
    let radius = sides.sum::<f64>() / scene.primitives.len().max(1) as f64 / 4.0;
    for primitive in &scene.primitives {
        if let Some(corner) = scene.outline(primitive.shape).first() {
            beads.push_sphere(primitive.material, *corner, radius);
        }
    }
    (!beads.primitives.is_empty() && radius > 0.0).then_some(beads)
}

fn test_spheres_of(stage: &Stage<'_>, what: &str) -> Result<SceneOutcome, StudyError> {
    let PrimsRef::Mixed(set) = stage.prepared.geometry.prims() else {
        return Err(stage.unfit("it has no spheres"));
    };
    let spheres: Vec<u32> =
        (0..set.len() as u32).filter(|&id| set.kind(id) == PrimitiveKind::Sphere).collect();
    let mut random = stage.random("spheres");
    let mut balls = Vec::new();
    let drawn = (0..stage.limits.aims).filter_map(|_| {
        let id = spheres[random.below(spheres.len())];
        balls.clear();
        set.hull(id, &mut balls);
        let ball = balls.first()?;
        let along = direction(&mut random);
        let away = 10.0_f64.powf(1.0 + 3.0 * unit(&mut random)) * ball.radius;
        let beside = if random.below(2) == 0 { 0.95 } else { 1.05 } * ball.radius;
        let aside = along.any_orthonormal_vector();
        let from = ball.center + aside * beside - along * away;
        let ray = Ray::<f32>::new(from.as_vec3(), along.as_vec3());
        let passing = passes_at(&ray, ball.center) / ball.radius;
        // otherwise single precision cannot hold such a ray: the coordinates are too large
        let is_held = ball.radius.is_normal() && (passing - 1.0).abs() >= 0.02;
        is_held.then(|| (AimedRay { ray, primitives: vec![id] }, passing < 1.0))
    });
    let (aims, is_met): (Vec<_>, Vec<bool>) = drawn.unzip();
    let triangle = TriangleChoice::Watertight;
    let tests = SPHERE_TESTS.map(|(name, sphere)| (name, Choice { triangle, sphere }));
    let said = SceneOutcome::new(
        format!("of {what} through {TRACER}"),
        format!("{} rays beside and through spheres of {what}", aims.len()),
    );
    compared(stage, &format!("{TRACER}:sphere-test"), &tests, (&aims, &is_met), said)
}

/// How near the line of a ray comes to a point.
fn passes_at(ray: &Ray<f32>, p: DVec3) -> f64 {
    let d = ray.direction.to_dvec3();
    (ray.origin.to_dvec3() - p).cross(d).length() / d.length()
}

/// The test that all others are compared with.
const REFERENCE: &str = "f64";

/// The parameter by which an aimed ray hits, of the nearest of the primitives that it is judged by.
struct NearestOf<'m> {
    aims: &'m [AimedRay],
}

impl TestedSetVisitor<'_> for NearestOf<'_> {
    type Output = Vec<Option<f32>>;

    fn visit<P: PrimSet<f32>>(self, set: &P) -> Self::Output {
        let nearest = |aim: &AimedRay| {
            let setup = set.setup(&aim.ray);
            let t = |id: &u32| set.intersect(*id, &aim.ray, &setup, f32::INFINITY);
            aim.primitives.iter().filter_map(t).reduce(f32::min)
        };
        self.aims.iter().map(nearest).collect()
    }
}

/// Times the values of a structure's setting, which choose tests, and judges each by the aimed rays,
/// of which some must meet what they are asked of and the others must not.
fn compared(
    stage: &Stage<'_>,
    setting: &str,
    tests: &[(&'static str, Choice)],
    (aims, is_met): (&[AimedRay], &[bool]),
    said: SceneOutcome,
) -> Result<SceneOutcome, StudyError> {
    let named = |(name, _): &(&'static str, Choice)| (*name, format!("{setting}={name}"));
    let settings: Vec<(&str, String)> = tests.iter().map(named).collect();
    let hits = |choice| {
        let prims = stage.prepared.geometry.prims();
        visit_tested(prims, choice, NearestOf { aims }).unwrap_or_default()
    };
    let exact = tests.iter().find(|(name, _)| *name == REFERENCE);
    let exact = exact.map(|(_, choice)| hits(*choice)).unwrap_or_default();
    timed_settings(stage, &settings, REFERENCE, &stage.all_batches(), said, |i, _, _| {
        let (mut tally, mut ulps) = (TrialCounts::default(), Vec::new());
        for ((t, exact), is_met) in hits(tests[i].1).into_iter().zip(&exact).zip(is_met) {
            tally.add(t.is_some() != *is_met);
            if let (Some(t), Some(exact)) = (t, exact) {
                let ulp = f64::from(exact.next_up()) - f64::from(*exact);
                ulps.push((f64::from(t) - f64::from(*exact)).abs() / ulp);
            }
        }
        Ok((tally.error(), vec![("t off by ulps, median", median(&ulps).unwrap_or(0.0))]))
    })
}
