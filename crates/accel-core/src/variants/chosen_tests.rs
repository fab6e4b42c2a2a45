//! A set whose tests are chosen at run time: what other tests of triangles and spheres lose, all
//! through equal machinery.
//!
//! It is a view of a set. A traversal hands lists over by a call, and a test is a call of one
//! function that branches to the test chosen, the same way for all rays; the tests that are the
//! default are compiled into every traversal and pass by here not at all. So the times of chosen
//! tests say nothing beside the default's, and little beside one another's: the call hides what
//! differs. Their prices are measured with the feature `compiled-tests`, which compiles each into
//! the traversals of some structures as the default is (`variants/compiled_tests.rs`,
//! [`is_compiled`]).
//!
//! The settings are parameters of every structure ([`TRIANGLE_TEST`], [`SPHERE_TEST`]).

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::Scalar;
use crate::params::{ParamSpec, Params};
use crate::primitives::Shear;
use crate::primitives::Sphere;
use crate::primitives::mixed::ShapeRef;
use crate::primitives::triangle::{MoellerTrumbore, TriangleSet, TriangleTest, Watertight};
use crate::primitives::{Ball, MixedSet, PrimSet, PrimitiveKind};
use crate::query::tracer::Tracer;
use crate::variants::sphere_tests;
use crate::variants::triangle_tests::{
    MoellerTrumboreTolerant, Pluecker, WatertightFallback, WatertightInDouble,
};

/// The test that is compiled into every traversal.
const DEFAULT: &str = "default";

/// A setting that every structure has.
pub const TRIANGLE_TEST: ParamSpec = ParamSpec::choice(
    "triangle-test",
    DEFAULT,
    &[
        DEFAULT,
        "moeller-trumbore",
        "moeller-trumbore-epsilon",
        "pluecker",
        "watertight",
        "watertight-fallback",
        "f64",
    ],
)
.about(
    "test of triangles: the default is the watertight one, compiled into each traversal; \
              others are called, unless built with the feature compiled-tests",
);

pub const SPHERE_TEST: ParamSpec =
    ParamSpec::choice("sphere-test", DEFAULT, &[DEFAULT, "naive", "rearranged", "f64"]).about(
        "test of spheres: the default is the rearranged one, compiled into each traversal; \
              others are called, unless built with the feature compiled-tests",
    );

/// Returns whether a tracer's chosen tests are compiled into its traversals, as the default tests
/// are.
pub fn is_compiled<S: Scalar>(tracer: &dyn Tracer<S>) -> bool {
    !tracer.code().contains("ChosenTests")
}

/// A test of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TriangleChoice {
    MoellerTrumbore,
    Tolerant,
    Pluecker,
    Watertight,
    Fallback,
    Double,
}

/// A test of spheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SphereChoice {
    /// The quadratic formula as it stands.
    Naive,
    Rearranged,
    /// The same in f64.
    Double,
}

/// The tests of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    pub triangle: TriangleChoice,
    pub sphere: SphereChoice,
}

impl Choice {
    /// Tests named in the settings of a structure; `None` for the compiled-in tests.
    pub fn of(params: &Params) -> Option<Self> {
        let [triangle, sphere] =
            ["triangle-test", "sphere-test"].map(|name| params.get(name).unwrap_or(DEFAULT));
        if triangle == DEFAULT && sphere == DEFAULT {
            return None;
        }
        let triangle = match triangle {
            "moeller-trumbore" => TriangleChoice::MoellerTrumbore,
            "moeller-trumbore-epsilon" => TriangleChoice::Tolerant,
            "pluecker" => TriangleChoice::Pluecker,
            "watertight-fallback" => TriangleChoice::Fallback,
            "f64" => TriangleChoice::Double,
            _ => TriangleChoice::Watertight,
        };
        let sphere = match sphere {
            "naive" => SphereChoice::Naive,
            "f64" => SphereChoice::Double,
            _ => SphereChoice::Rearranged,
        };
        Some(Self { triangle, sphere })
    }
}

/// Why the answers under these settings differ from the default's, if they may.
pub fn known_defect(params: &Params) -> Option<&'static str> {
    let choice = Choice::of(params)?;
    match (choice.triangle, choice.sphere) {
        (TriangleChoice::MoellerTrumbore | TriangleChoice::Tolerant, _) => {
            Some("Moeller-Trumbore's test leaks at edges and corners")
        }
        (_, SphereChoice::Naive) => {
            Some("the naive sphere test invents and loses hits of small and far spheres")
        }
        (TriangleChoice::Watertight, SphereChoice::Rearranged) => None,
        _ => Some("another test of primitives: its t differs in the last bits"),
    }
}

/// The set that is seen.
#[derive(Debug)]
enum TestedSet<'a, S: Scalar> {
    Triangles(&'a TriangleSet<S>),
    Mixed(&'a MixedSet<S>),
}

/// A set under chosen tests.
#[derive(Debug)]
pub struct ChosenTests<'a, S: Scalar> {
    over: TestedSet<'a, S>,
    choice: Choice,
}

/// Ray data of the chosen test; data of other tests is not computed.
#[derive(Debug, Clone, Copy)]
pub struct ChosenSetup<S: Scalar> {
    shear: Option<Shear<S>>,
    double: Option<(Ray<f64>, Shear<f64>)>,
}

impl<'a, S: Scalar> ChosenTests<'a, S> {
    /// Triangles under another test.
    pub fn of_triangles(set: &'a TriangleSet<S>, choice: Choice) -> Self {
        Self { over: TestedSet::Triangles(set), choice }
    }

    /// Primitives of any kind, moving ones too, whose triangles and spheres have other tests.
    pub fn of_mixed(set: &'a MixedSet<S>, choice: Choice) -> Self {
        Self { over: TestedSet::Mixed(set), choice }
    }

    #[inline(always)]
    fn triangle(
        &self,
        v: &[[S; 3]; 3],
        ray: &Ray<S>,
        setup: &ChosenSetup<S>,
        t_max: S,
    ) -> Option<S> {
        match (self.choice.triangle, &setup.shear, &setup.double) {
            (TriangleChoice::MoellerTrumbore, _, _) => {
                MoellerTrumbore::intersect(v, ray, &(), t_max)
            }
            (TriangleChoice::Tolerant, _, _) => {
                MoellerTrumboreTolerant::intersect(v, ray, &(), t_max)
            }
            (TriangleChoice::Pluecker, _, _) => Pluecker::intersect(v, ray, &(), t_max),
            (TriangleChoice::Watertight, Some(shear), _) => {
                Watertight::intersect(v, ray, shear, t_max)
            }
            (TriangleChoice::Fallback, Some(shear), _) => {
                WatertightFallback::intersect(v, ray, shear, t_max)
            }
            (TriangleChoice::Double, _, Some(double)) => {
                WatertightInDouble::intersect(v, ray, double, t_max)
            }
            // `setup` computes what each test needs
            (_, None, _) | (TriangleChoice::Double, _, None) => {
                Watertight::intersect(v, ray, &Shear::of(ray, self.magnitude()), t_max)
            }
        }
    }

    #[inline(always)]
    fn sphere(&self, sphere: &Sphere<S>, ray: &Ray<S>, t_max: S) -> Option<S> {
        match self.choice.sphere {
            SphereChoice::Naive => sphere_tests::naive(sphere, ray, t_max),
            SphereChoice::Rearranged => sphere.intersect(ray, t_max),
            SphereChoice::Double => sphere_tests::in_double(sphere, ray, t_max),
        }
    }

    fn of_shape(
        &self,
        set: &MixedSet<S>,
        id: u32,
        ray: &Ray<S>,
        setup: &ChosenSetup<S>,
        t_max: S,
    ) -> Option<S> {
        match set.shape(id) {
            ShapeRef::Triangle(v) => self.triangle(v, ray, setup, t_max),
            ShapeRef::Sphere(sphere) => self.sphere(sphere, ray, t_max),
            ShapeRef::Other => {
                let shear = setup.shear.unwrap_or_else(|| Shear::of(ray, set.magnitude()));
                set.intersect(id, ray, &shear, t_max)
            }
        }
    }
}

/// Calls the same of whichever set it is.
macro_rules! seen {
    ($self:ident, $set:ident => $call:expr) => {
        match $self.over {
            TestedSet::Triangles($set) => $call,
            TestedSet::Mixed($set) => $call,
        }
    };
}

impl<S: Scalar> PrimSet<S> for ChosenTests<'_, S> {
    type RaySetup = ChosenSetup<S>;

    const IS_CALLED: bool = true;

    fn len(&self) -> usize {
        seen!(self, set => set.len())
    }

    fn bounds(&self, id: u32) -> Aabb<S> {
        seen!(self, set => set.bounds(id))
    }

    fn extent(&self, id: u32, direction: DVec3) -> (f64, f64) {
        seen!(self, set => set.extent(id, direction))
    }

    fn farthest(&self, id: u32, from: DVec3) -> f64 {
        seen!(self, set => set.farthest(id, from))
    }

    fn hull(&self, id: u32, balls: &mut Vec<Ball>) {
        seen!(self, set => set.hull(id, balls));
    }

    fn moves(&self, id: u32) -> bool {
        seen!(self, set => set.moves(id))
    }

    fn kind(&self, id: u32) -> PrimitiveKind {
        seen!(self, set => set.kind(id))
    }

    #[inline(never)]
    fn setup(&self, ray: &Ray<S>) -> ChosenSetup<S> {
        let is_mixed = matches!(self.over, TestedSet::Mixed(_));
        let sheared =
            matches!(self.choice.triangle, TriangleChoice::Watertight | TriangleChoice::Fallback);
        ChosenSetup {
            // polygons are tested in the sheared space whatever the test of triangles is
            shear: (is_mixed || sheared).then(|| Shear::of(ray, self.magnitude())),
            double: (self.choice.triangle == TriangleChoice::Double)
                .then(|| <WatertightInDouble as TriangleTest<S>>::setup(ray, self.magnitude())),
        }
    }

    #[inline(never)]
    fn intersect(&self, id: u32, ray: &Ray<S>, setup: &ChosenSetup<S>, t_max: S) -> Option<S> {
        match self.over {
            TestedSet::Triangles(set) => {
                self.triangle(&set.triangles()[id as usize], ray, setup, t_max)
            }
            TestedSet::Mixed(set) => match set.motion().velocity(id) {
                None => self.of_shape(set, id, ray, setup, t_max),
                Some(_) => {
                    let motion = set.motion();
                    let moment = motion.moment(ray.time);
                    let relative = ray.moved_back(motion.velocity_or_zero(id), moment);
                    self.of_shape(set, id, &relative, &self.setup(&relative), t_max)
                }
            },
        }
    }

    fn is_opaque(&self, id: u32) -> bool {
        seen!(self, set => set.is_opaque(id))
    }

    fn magnitude(&self) -> S {
        seen!(self, set => set.magnitude())
    }

    fn bytes(&self) -> usize {
        seen!(self, set => set.bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::MixedSetBuilder;

    fn choice(settings: &[(&str, &str)]) -> Option<Choice> {
        Choice::of(
            &Params::new("x", &[TRIANGLE_TEST, SPHERE_TEST], settings.iter().copied()).unwrap(),
        )
    }

    #[test]
    fn settings_choose_tests_and_say_what_is_wrong_with_them() {
        assert_eq!(choice(&[]), None);
        let chosen = choice(&[("sphere-test", "naive")]).unwrap();
        assert_eq!(chosen.triangle, TriangleChoice::Watertight);
        let defect = |name, value| {
            known_defect(&Params::new("x", &[TRIANGLE_TEST, SPHERE_TEST], [(name, value)]).unwrap())
                .is_some()
        };
        for test in ["moeller-trumbore", "moeller-trumbore-epsilon", "pluecker", "f64"] {
            assert!(defect("triangle-test", test), "{test}");
        }
        assert!(defect("sphere-test", "naive") && defect("sphere-test", "f64"));
        assert!(!defect("triangle-test", "watertight") && !defect("sphere-test", "rearranged"));
    }

    #[test]
    fn the_default_tests_give_the_same_bits_when_chosen() {
        let mut builder = MixedSetBuilder::<f32>::default();
        builder.triangle([DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap();
        builder.sphere(DVec3::new(0.3, 0.2, 1.0), 0.4).unwrap();
        builder.polygon(&[DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y]).unwrap();
        builder.last_moves(DVec3::new(0.1, 0.0, 0.0), 1.0).unwrap();
        let set = builder.finish();
        let chosen =
            ChosenTests::of_mixed(&set, choice(&[("triangle-test", "watertight")]).unwrap());
        let mut hits = 0;
        for i in 0..500 {
            let x = i as f32 * 0.002;
            let mut ray =
                Ray::<f32>::new(glam::vec3(x, 0.1 + x * 0.3, 3.0), glam::vec3(0.01, 0.02, -1.0));
            ray.time = 0.5;
            for id in 0..3 {
                let expected =
                    set.in_motion().intersect(id, &ray, &set.in_motion().setup(&ray), 9.0);
                assert_eq!(chosen.intersect(id, &ray, &chosen.setup(&ray), 9.0), expected);
                hits += usize::from(expected.is_some());
            }
        }
        assert!(hits > 300, "{hits}");
    }
}
