//! Tests of primitives chosen by name: what is compiled for them, what they answer, and where they
//! are refused.

use accel_core::params::{ParamError, ParamKind, ParamSpec};
use accel_core::primitives::{PrimSet, PrimsRef};
use accel_core::query::counters::NoCounters;
use accel_core::query::sink::{Answer, Query, Sink};
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::find;
use accel_core::variants::chosen_tests::{
    Choice, SPHERE_TEST, TRIANGLE_TEST, TestedSetVisitor, visit_tested,
};
use accel_core::{Hit, Ray};

use crate::agreement::closest_hits;
use crate::common::{Set, all_scenes, build, settings};
use crate::test_scenes::{mixed_scene, occlusions, rays};

/// The structures that offer the choice, primitives one by one and in blocks.
const STRUCTURES: [(&str, &str); 3] =
    [("uniform-grid", "kernel=scalar"), ("uniform-grid", ""), ("wide-bvh", "")];

/// Each value of a setting but its default.
fn choices_of(setting: ParamSpec) -> impl Iterator<Item = String> {
    let ParamKind::Choice(words) = setting.kind else { panic!("{} has no choices", setting.name) };
    let others = words.iter().filter(move |word| **word != setting.default);
    others.map(move |word| format!("{}={word}", setting.name))
}

fn scene(name: &str) -> Set<f32> {
    all_scenes().into_iter().find(|scene| scene.0 == name).unwrap().1
}

fn triangles_and_mixed() -> [Set<f32>; 2] {
    [scene("soup"), Set::Mixed(mixed_scene(60, 9, [1.0; 3]))]
}

fn answers(tracer: &dyn Tracer<f32>, rays: &[Ray<f32>]) -> (Vec<Hit<f32>>, Vec<bool>) {
    (closest_hits(tracer, rays), occlusions(tracer, rays))
}

/// Every primitive under the tests of the set that is visited, which are called.
struct Oracle<'r>(&'r [Ray<f32>]);

impl<'a> TestedSetVisitor<'a> for Oracle<'_> {
    type Output = (Vec<Hit<f32>>, Vec<bool>);

    fn visit<P: PrimSet<f32>>(self, set: &'a P) -> Self::Output {
        let ids: Vec<u32> = (0..set.len() as u32).collect();
        (answers_of_all(set, &ids, self.0), answers_of_all(set, &ids, self.0))
    }
}

fn answers_of_all<P: PrimSet<f32>, A: Answer<f32>>(
    set: &P,
    ids: &[u32],
    rays: &[Ray<f32>],
) -> Vec<A> {
    let answer = |ray: &Ray<f32>| {
        let mut query = Query::<_, _, NoCounters, A>::new(set, ray);
        let _ = query.test(ids);
        query.finish().0
    };
    rays.iter().map(answer).collect()
}

fn expected(prims: PrimsRef<'_, f32>, text: &str, rays: &[Ray<f32>]) -> (Vec<Hit<f32>>, Vec<bool>) {
    let params = find("wide-bvh").unwrap().params(settings(text)).unwrap();
    let choice = Choice::of(&params).unwrap();
    visit_tested(prims, choice, Oracle(rays)).unwrap()
}

#[test]
fn chosen_tests_answer_as_brute_force_under_them_does() {
    let rays = rays(&mixed_scene(60, 9, [1.0; 3]), 400, 10);
    let mut choices: Vec<_> = choices_of(TRIANGLE_TEST).chain(choices_of(SPHERE_TEST)).collect();
    assert_eq!(choices.len(), 9);
    choices.push("triangle-test=f64 sphere-test=f64".to_owned());
    for set in &triangles_and_mixed() {
        let set = set.prims();
        let default = answers(&*build(set, "brute-force", "").unwrap(), &rays);
        let mut differing = Vec::new();
        for choice in &choices {
            let expected = expected(set, choice, &rays);
            assert!(expected.0.iter().filter(|hit| hit.is_hit()).count() > 100, "{choice}");
            for (name, kernel) in STRUCTURES {
                let tracer = build(set, name, &format!("{choice} {kernel}")).unwrap();
                let got = answers(&*tracer, &rays);
                assert!(got == expected, "{name} {kernel} {choice}");
            }
            if expected != default {
                differing.push(choice.as_str());
            }
        }
        // answers under the default tests would not pass
        assert!(differing.contains(&"triangle-test=moeller-trumbore"), "{differing:?}");
        let has_spheres = matches!(set, PrimsRef::Mixed(_));
        assert_eq!(differing.contains(&"sphere-test=naive"), has_spheres, "{differing:?}");
        assert!(!differing.contains(&"triangle-test=watertight"), "{differing:?}");
        assert!(!differing.contains(&"sphere-test=rearranged"), "{differing:?}");
    }
}

#[test]
fn a_default_chosen_by_name_is_the_default_and_another_test_is_other_code() {
    for set in &triangles_and_mixed() {
        let set = set.prims();
        for (name, kernel) in STRUCTURES {
            let code = |choice: &str| {
                build(set, name, &format!("{choice} {kernel}")).map(|tracer| tracer.code()).unwrap()
            };
            let default = code("");
            assert_eq!(code("triangle-test=watertight"), default, "{name}");
            assert_eq!(code("sphere-test=rearranged"), default, "{name}");
            assert_ne!(code("triangle-test=pluecker"), default, "{name}");
        }
    }
}

#[test]
fn tests_that_are_not_compiled_are_refused() {
    fn refusal<S: Buildable>(prims: PrimsRef<'_, S>, settings: &str) -> String {
        refusal_of("wide-bvh", prims, settings)
    }
    fn refusal_of<S: Buildable>(name: &str, prims: PrimsRef<'_, S>, settings: &str) -> String {
        match build(prims, name, settings) {
            Err(BuildError::Param(error @ ParamError::Invalid { .. })) => error.to_string(),
            Err(error) => panic!("{settings}: {error}"),
            Ok(_) => panic!("{settings}: built"),
        }
    }
    let double = mixed_scene::<f64>(20, 9, [1.0; 3]);
    let naive = "wide-bvh.sphere-test = 'naive': expected default";
    assert_eq!(
        refusal(PrimsRef::Mixed(&double), "sphere-test=naive"),
        format!("{naive} in this precision")
    );
    let moving = scene("moving");
    assert_eq!(
        refusal(moving.prims(), "sphere-test=naive"),
        format!("{naive} where primitives move")
    );
    let [triangles, mixed] = triangles_and_mixed();
    let set = triangles.prims();
    let pluecker = ".triangle-test = 'pluecker': expected default";
    for query in ["batch", "packets"] {
        let text = refusal(set, &format!("triangle-test=pluecker query={query}"));
        assert_eq!(text, format!("wide-bvh{pluecker} for batches"));
    }
    let text =
        refusal_of("uniform-grid", set, "triangle-test=pluecker kernel=scalar mailbox=array");
    assert_eq!(text, format!("uniform-grid{pluecker} where there is a mailbox"));
    for traversal in ["driving-axis", "f64"] {
        let settings = format!("triangle-test=pluecker traversal={traversal}");
        let text = refusal_of("uniform-grid", set, &settings);
        assert_eq!(text, format!("uniform-grid{pluecker} with this traversal"));
    }
    let accumulating = "triangle-test=moeller-trumbore traversal=accumulate kernel=scalar";
    assert!(build(set, "uniform-grid", accumulating).is_ok());
    let both = "sphere-test=naive triangle-test=pluecker";
    let text = refusal(mixed.prims(), both);
    assert!(text.ends_with("expected default, or f64 for both kinds of primitives"), "{text}");
}
