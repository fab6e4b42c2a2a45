//! Chosen tests compiled into traversals, as the default tests are: the feature `compiled-tests`.
//!
//! A test that is called costs its call, and the compiler keeps nothing in registers across it:
//! what two called tests differ by is not what they differ by when compiled in, and a default that
//! is chosen by name becomes slower than itself. Here each traversal is compiled once more for each
//! test, over a set of that test's type ([`TriangleSet`] of another test,
//! [`Retested`](crate::primitives::Retested) mixed sets), for the scalar kernel and for blocks of
//! eight. The defaults chosen by name are the types that are built when nothing is chosen.
//!
//! The structure is built over the set itself, so that it is the same for every test. Not compiled,
//! but called as without the feature: sets that move, f64, tests of triangles and spheres that are
//! both no defaults (f64 of both is compiled), and `adapter=direct`, which would answer by the
//! library's test.

use crate::params::config::Settings;
use crate::primitives::{
    MixedSet, MoellerTrumbore, PrimsRef, RearrangedSphere, SphereTest, TriangleSet, TriangleTest,
    Watertight,
};
use crate::query::tracer::Tracer;
use crate::query::tracer::tested::{TestChoice, tested_as};
use crate::structure::{BuildError, Structure};
use crate::variants::chosen_tests::{Choice, SphereChoice, TriangleChoice};
use crate::variants::sphere_tests::{NaiveSphere, SphereInDouble};
use crate::variants::triangle_tests::{
    MoellerTrumboreTolerant, Pluecker, WatertightFallback, WatertightInDouble,
};

/// By which settings it is built.
type BuildInput<'h, T> = (&'h Settings<<T as Structure<f32>>::Config>, &'h TestChoice);

/// A structure that answers, or why it was not built.
type BuiltTracer<'a> = Result<Box<dyn Tracer<f32> + 'a>, BuildError>;

/// Builds `T`, the tests that the settings choose compiled in; `None` where none is chosen or they
/// are called.
pub(crate) fn build<'a, T: Structure<f32>>(
    prims: PrimsRef<'a, f32>,
    how: BuildInput<'_, T>,
) -> Option<BuiltTracer<'a>> {
    let Choice { triangle, sphere } = how.1.choice?;
    if how.1.is_direct {
        return None;
    }
    match prims {
        PrimsRef::Watertight(set) => Some(match triangle {
            TriangleChoice::MoellerTrumbore => triangles::<MoellerTrumbore, T>(set, how),
            TriangleChoice::Tolerant => triangles::<MoellerTrumboreTolerant, T>(set, how),
            TriangleChoice::Pluecker => triangles::<Pluecker, T>(set, how),
            TriangleChoice::Watertight => triangles::<Watertight, T>(set, how),
            TriangleChoice::Fallback => triangles::<WatertightFallback, T>(set, how),
            TriangleChoice::Double => triangles::<WatertightInDouble, T>(set, how),
        }),
        PrimsRef::Mixed(set) if set.has_motion() => None,
        PrimsRef::Mixed(set) => Some(match (triangle, sphere) {
            (TriangleChoice::Watertight, SphereChoice::Rearranged) => {
                tested_as::<f32, _, _, T>(set, set, how, None)
            }
            (TriangleChoice::MoellerTrumbore, SphereChoice::Rearranged) => {
                mixed::<MoellerTrumbore, RearrangedSphere, T>(set, how)
            }
            (TriangleChoice::Tolerant, SphereChoice::Rearranged) => {
                mixed::<MoellerTrumboreTolerant, RearrangedSphere, T>(set, how)
            }
            (TriangleChoice::Pluecker, SphereChoice::Rearranged) => {
                mixed::<Pluecker, RearrangedSphere, T>(set, how)
            }
            (TriangleChoice::Fallback, SphereChoice::Rearranged) => {
                mixed::<WatertightFallback, RearrangedSphere, T>(set, how)
            }
            (TriangleChoice::Double, SphereChoice::Rearranged) => {
                mixed::<WatertightInDouble, RearrangedSphere, T>(set, how)
            }
            (TriangleChoice::Watertight, SphereChoice::Naive) => {
                mixed::<Watertight, NaiveSphere, T>(set, how)
            }
            (TriangleChoice::Watertight, SphereChoice::Double) => {
                mixed::<Watertight, SphereInDouble, T>(set, how)
            }
            (TriangleChoice::Double, SphereChoice::Double) => {
                mixed::<WatertightInDouble, SphereInDouble, T>(set, how)
            }
            _ => return None,
        }),
    }
}

fn triangles<'a, X: TriangleTest<f32>, T: Structure<f32>>(
    set: &'a TriangleSet<f32>,
    how: BuildInput<'_, T>,
) -> BuiltTracer<'a> {
    tested_as::<f32, _, _, T>(set, set.tested_by::<X>(), how, None)
}

fn mixed<'a, X: TriangleTest<f32>, Q: SphereTest<f32>, T: Structure<f32>>(
    set: &'a MixedSet<f32>,
    how: BuildInput<'_, T>,
) -> BuiltTracer<'a> {
    tested_as::<f32, _, _, T>(set, set.retested::<X, Q>(), how, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Hit;
    use crate::geometry::ray::Ray;
    use crate::structures::test_scenes::{Random, mixed_scene, rays};
    use crate::structures::{find, prepare};
    use crate::variants::chosen_tests::is_compiled;

    const STRUCTURES: [&str; 6] =
        ["obvhs-bvh2", "obvhs-cwbvh", "uniform-grid", "kd-tree", "wide-bvh", "irregular-grid"];
    const TESTS: [&str; 6] = [
        "moeller-trumbore",
        "moeller-trumbore-epsilon",
        "pluecker",
        "watertight",
        "watertight-fallback",
        "f64",
    ];

    fn soup() -> TriangleSet<f32> {
        let mut random = Random(5);
        let mut triangle = || {
            let at = random.point([1.0; 3]);
            [0; 3].map(|_| (at + random.point([0.2; 3])).as_vec3().to_array())
        };
        TriangleSet::new((0..300).map(|_| triangle()).collect(), |id| id % 5 == 0).unwrap()
    }

    fn tracer<'a>(
        name: &str,
        prims: PrimsRef<'a, f32>,
        settings: &[(&str, &str)],
    ) -> Box<dyn Tracer<f32> + 'a> {
        let entry = find(name).unwrap();
        entry.build(prims, &entry.params(settings.iter().copied()).unwrap()).unwrap()
    }

    fn answers(tracer: &dyn Tracer<f32>, rays: &[Ray<f32>]) -> (Vec<Hit<f32>>, Vec<bool>) {
        let (mut hits, mut blocked) = (vec![Hit::NONE; rays.len()], vec![false; rays.len()]);
        tracer.closest_hits(rays, &mut hits);
        tracer.occlusions(rays, &mut blocked);
        (hits, blocked)
    }

    #[test]
    fn a_default_chosen_by_name_is_the_default_and_a_called_one_is_not() {
        let (triangles, mixed) = (soup(), mixed_scene::<f32>(60, 9, [1.0; 3]));
        let sets = [PrimsRef::Watertight(&triangles), PrimsRef::Mixed(&mixed)];
        for name in STRUCTURES {
            for set in sets {
                let default = tracer(name, set, &[]).code();
                for chosen in [("triangle-test", "watertight"), ("sphere-test", "rearranged")] {
                    assert_eq!(tracer(name, set, &[chosen]).code(), default, "{name}");
                }
            }
        }
        // planted: the same choice, called
        let entry = find("wide-bvh").unwrap();
        let params = entry.params([("triangle-test", "watertight")]).unwrap();
        type WideBvhF32 = crate::structures::wide_bvh::WideBvh<f32>;
        let called = prepare::<f32, WideBvhF32>(&params)(sets[0], None).unwrap();
        assert_ne!(called.code(), tracer("wide-bvh", sets[0], &[]).code());
        assert!(!is_compiled(&*called));
    }

    #[test]
    fn compiled_tests_answer_as_called_ones_do() {
        let (triangles, mixed) = (soup(), mixed_scene::<f32>(60, 9, [1.0; 3]));
        let all = rays(&mixed, 400, 10);
        for set in [PrimsRef::Watertight(&triangles), PrimsRef::Mixed(&mixed)] {
            for test in TESTS {
                let params = find("brute-force").unwrap();
                let params = params.params([("triangle-test", test)]).unwrap();
                let called = find("brute-force").unwrap().build(set, &params).unwrap();
                assert!(!is_compiled(&*called));
                let expected = answers(&*called, &all);
                assert!(expected.0.iter().filter(|hit| hit.is_hit()).count() > 100);
                for (name, kernel) in [
                    ("obvhs-bvh2", Some("scalar")),
                    ("obvhs-bvh2", Some("block")),
                    ("obvhs-cwbvh", Some("scalar")),
                    ("obvhs-cwbvh", Some("block")),
                    ("uniform-grid", Some("scalar")),
                    ("uniform-grid", Some("block")),
                    ("kd-tree", Some("scalar")),
                    ("kd-tree", Some("block")),
                    ("wide-bvh", None),
                    ("irregular-grid", None),
                ] {
                    let mut settings = vec![("triangle-test", test)];
                    settings.extend(kernel.map(|kernel| ("kernel", kernel)));
                    let tracer = tracer(name, set, &settings);
                    assert!(is_compiled(&*tracer), "{name} {test}");
                    let got = answers(&*tracer, &all);
                    assert!(got == expected, "{name} {kernel:?} {test}");
                }
            }
        }
    }

    #[test]
    fn spheres_have_tests_of_their_own_and_the_library_keeps_its_test() {
        let mixed = mixed_scene::<f32>(60, 9, [1.0; 3]);
        let all = rays(&mixed, 400, 10);
        let set = PrimsRef::Mixed(&mixed);
        for test in ["naive", "f64"] {
            let expected = answers(&*tracer("brute-force", set, &[("sphere-test", test)]), &all);
            for name in STRUCTURES {
                let tracer = tracer(name, set, &[("sphere-test", test)]);
                assert!(is_compiled(&*tracer) && answers(&*tracer, &all) == expected, "{name}");
            }
        }
        let both = [("sphere-test", "f64"), ("triangle-test", "f64")];
        assert!(is_compiled(&*tracer("kd-tree", set, &both)));
        let triangles = soup();
        let set = PrimsRef::Watertight(&triangles);
        let direct = [("adapter", "direct"), ("triangle-test", "watertight")];
        assert!(!is_compiled(&*tracer("obvhs-bvh2", set, &direct)));
    }
}
