//! The test of spheres: small and far ones, against the distance of their centres from the ray.
//!
//! The rays that are judged pass the centre of a sphere of the scene at 0.95 or 1.05 of its radius,
//! from 10 to 10^4 radii away: f64 tells on which side, with room to spare.

use accel_core::primitives::PrimsRef;
use accel_core::primitives::{PrimSet, PrimitiveKind};
use accel_core::variants::chosen_tests::{Choice, SphereChoice, TriangleChoice, visit_tested};
use accel_core::{Ray, Vector};
use glam::DVec3;
use renderer::RaySettings;
use scene_loading::Scene;

use super::chosen_tests::{NearestOf, variant};
use super::triangle_aims::AimedRay;
use crate::accuracy::axis::{Axis, Measure};
use crate::accuracy::record::SceneOutcome;
use crate::accuracy::stage::{PreparedScene, Stage, TRACER, count};
use crate::accuracy::timing::{AxisReport, timed};
use crate::error::StudyError;
use crate::verify::draw::{direction, unit};

pub static AXIS: Axis = Axis {
    name: "sphere-test",
    summary: "tests of spheres: the quadratic as it stands, rearranged, in f64",
    paper: "Glassner 1989; Haines, Guenther, Akenine-Moeller 2019",
    metric: "rays in 10^6, 10 to 10^4 radii away, that hit or miss a sphere wrongly",
    reference: "distance of the centre from the ray, clear by 2% of the radius",
    scenes: &["balls", "rings", "pavilion"],
    setting: "STRUCTURE.sphere-test",
    measure: Measure::Whole(measure),
};

const TESTS: [(&str, SphereChoice); 3] = [
    ("naive", SphereChoice::Naive),
    ("rearranged", SphereChoice::Rearranged),
    ("f64", SphereChoice::Double),
];

fn measure(stage: &Stage<'_>) -> Result<SceneOutcome, StudyError> {
    let has_spheres = !stage.scene().spheres.is_empty();
    if has_spheres {
        return judged(stage, "the scene");
    }
    let beads = beads(stage.scene()).ok_or_else(|| stage.unfit("it has no corners"))?;
    let settings = RaySettings {
        resolution: [if stage.quick { 32 } else { 96 }; 2],
        ..RaySettings::default()
    };
    let prepared = PreparedScene::new(beads, stage.registry, &settings)?;
    judged(&Stage { prepared: &prepared, ..*stage }, "a bead at a corner of each primitive")
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

fn judged(stage: &Stage<'_>, what: &str) -> Result<SceneOutcome, StudyError> {
    let PrimsRef::Mixed(set) = stage.prepared.geometry.prims() else {
        return Err(stage.unfit("it has no spheres"));
    };
    let labels = TESTS.map(|(name, _)| format!("{TRACER}:sphere-test={name}"));
    let built = stage.built_all(&labels.each_ref().map(String::as_str))?;
    let batches = stage.all_batches();
    let rays = count(&batches);
    let spheres: Vec<u32> =
        (0..set.len() as u32).filter(|&id| set.kind(id) == PrimitiveKind::Sphere).collect();
    let mut random = stage.random("spheres");
    let mut aims = Vec::with_capacity(stage.aims);
    let mut balls = Vec::new();
    while aims.len() < stage.aims {
        let id = spheres[random.below(spheres.len())];
        balls.clear();
        set.hull(id, &mut balls);
        let Some(ball) = balls.first() else { break };
        let along = direction(&mut random);
        let away = 10.0_f64.powf(1.0 + 3.0 * unit(&mut random)) * ball.radius;
        let beside = if random.below(2) == 0 { 0.95 } else { 1.05 } * ball.radius;
        let aside = along.any_orthonormal_vector();
        let from = ball.center + aside * beside - along * away;
        let ray = Ray::<f32>::new(from.as_vec3(), along.as_vec3());
        let passing = passes_at(&ray, ball.center) / ball.radius;
        if !ball.radius.is_normal() || (passing - 1.0).abs() < 0.02 {
            // single precision cannot hold such a ray: the coordinates are too large
            aims.push(None);
            continue;
        }
        aims.push(Some((AimedRay { ray, primitives: vec![id] }, passing < 1.0)));
    }
    let (aims, is_met): (Vec<_>, Vec<bool>) = aims.into_iter().flatten().unzip();
    let hit = |sphere: SphereChoice| {
        let choice = Choice { triangle: TriangleChoice::Watertight, sphere };
        visit_tested(PrimsRef::Mixed(set), choice, NearestOf { aims: &aims }).unwrap_or_default()
    };
    let exact = hit(SphereChoice::Double);
    let variants = built.iter().zip(TESTS).map(|(built, (name, test))| {
        let answers = hit(test).into_iter().zip(&exact).zip(&is_met);
        let answers = answers.map(|((t, exact), is_met)| (t, *exact, t.is_some() != *is_met));
        variant(name, built, &batches, answers)
    });
    let said = AxisReport {
        timed: format!("{rays} rays of {what} through {TRACER}"),
        judged: format!("{} rays beside and through spheres of {what}", aims.len()),
        ..AxisReport::default()
    };
    let variants = variants.collect();
    Ok(timed(stage, said, variants))
}

/// How near the line of a ray comes to a point.
fn passes_at(ray: &Ray<f32>, p: DVec3) -> f64 {
    let d = ray.direction.to_dvec3();
    (ray.origin.to_dvec3() - p).cross(d).length() / d.length()
}
