//! Other tests of triangles and spheres, compiled into the traversals of two structures: what they
//! lose, and what they cost.
//!
//! A traversal is compiled once more for each test, over a set of that test's type ([`TriangleSet`]
//! of another test, [`RetestedSet`]), as it is for the default tests; a default that is chosen by
//! name is the default. A test that were called would cost its call, which hides what tests differ
//! by. The settings ([`TRIANGLE_TEST`], [`SPHERE_TEST`]) are those of the structures on which
//! `accuracy` compares tests: `uniform-grid`, primitives one by one or in blocks, and `wide-bvh`,
//! triangles in blocks. They serve f32, primitives at rest, and of the grid's traversals the default
//! and the accumulating one.

use std::marker::PhantomData;

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3};
use crate::params::{ParamError, ParamSpec, Params};
use crate::primitives::prim_set::as_its_set;
use crate::primitives::{
    Ball, MixedSet, MoellerTrumbore, PrimSet, PrimitiveKind, Primitives, PrimsRef,
    RearrangedSphere, Shear, SphereTest, TriangleTest, Watertight,
};
use crate::variants::sphere_tests::{NaiveSphere, SphereInDouble};
use crate::variants::triangle_tests::{
    MoellerTrumboreTolerant, Pluecker, WatertightFallback, WatertightInDouble,
};

/// The test that is compiled into every traversal.
const DEFAULT: &str = "default";

/// Test of triangles.
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
.about("test of triangles, compiled into the traversal; the default is the watertight one");

/// Test of spheres.
pub const SPHERE_TEST: ParamSpec =
    ParamSpec::choice("sphere-test", DEFAULT, &[DEFAULT, "naive", "rearranged", "f64"])
        .about("test of spheres, compiled into the traversal; the default is the rearranged one");

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

/// Values of [`TRIANGLE_TEST`] but its default, and the test each is.
pub const TRIANGLE_TESTS: [(&str, TriangleChoice); 6] = [
    ("moeller-trumbore", TriangleChoice::MoellerTrumbore),
    ("moeller-trumbore-epsilon", TriangleChoice::Tolerant),
    ("pluecker", TriangleChoice::Pluecker),
    ("watertight", TriangleChoice::Watertight),
    ("watertight-fallback", TriangleChoice::Fallback),
    ("f64", TriangleChoice::Double),
];

/// The same of [`SPHERE_TEST`].
pub const SPHERE_TESTS: [(&str, SphereChoice); 3] = [
    ("naive", SphereChoice::Naive),
    ("rearranged", SphereChoice::Rearranged),
    ("f64", SphereChoice::Double),
];

fn named<T: Copy>(tests: &[(&str, T)], name: &str) -> Option<T> {
    tests.iter().find(|test| test.0 == name).map(|test| test.1)
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
        if [triangle, sphere] == [DEFAULT; 2] {
            return None;
        }
        Some(Self {
            triangle: named(&TRIANGLE_TESTS, triangle).unwrap_or(TriangleChoice::Watertight),
            sphere: named(&SPHERE_TESTS, sphere).unwrap_or(SphereChoice::Rearranged),
        })
    }

    /// The refusal of these settings where they are not compiled: for `expected`, all others.
    pub(crate) fn refused(params: &Params, expected: &str) -> ParamError {
        let chosen = |(name, _): &(&'static str, &str)| {
            [TRIANGLE_TEST.name, SPHERE_TEST.name].contains(name)
        };
        let (name, value) = params.changed().find(chosen).unwrap_or((TRIANGLE_TEST.name, DEFAULT));
        ParamError::Invalid {
            structure: params.structure(),
            name,
            value: value.to_owned(),
            expected: expected.to_owned(),
        }
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

/// What is done with a set under the tests that were chosen.
pub trait TestedSetVisitor<'a> {
    type Output;
    fn visit<P: PrimSet<f32>>(self, set: &'a P) -> Self::Output;
}

/// A mixed set, its triangles tested by `T`, its spheres by `Q`.
///
/// It is a view without a cost of its own: with the default tests it computes what a [`MixedSet`]
/// does. Polygons and cones keep their tests, so that the shear of a ray is computed for the
/// polygons whatever the test of triangles is. Primitives that move are seen where they are at time
/// 0.
#[derive(Debug)]
#[repr(transparent)]
pub struct RetestedSet<S: Scalar, T, Q> {
    set: MixedSet<S>,
    tests: PhantomData<(T, Q)>,
}

impl<S: Scalar> MixedSet<S> {
    /// The same set under other tests; nothing is copied.
    pub fn retested<T: TriangleTest<S>, Q: SphereTest<S>>(&self) -> &RetestedSet<S, T, Q> {
        // SAFETY: `RetestedSet` is a transparent wrapper of `MixedSet`.
        unsafe { &*std::ptr::from_ref(self).cast::<RetestedSet<S, T, Q>>() }
    }
}

impl<S: Scalar, T: TriangleTest<S>, Q: SphereTest<S>> Primitives<S> for RetestedSet<S, T, Q> {
    as_its_set!(S);

    fn corners(&self, id: u32) -> Option<[Vec3<S>; 3]> {
        self.set.corners(id)
    }
}

impl<S: Scalar, T: TriangleTest<S>, Q: SphereTest<S>> PrimSet<S> for RetestedSet<S, T, Q> {
    type RaySetup = (Shear<S>, T::Setup);

    const HAS_OTHER_TESTS: bool = true;

    #[inline(always)]
    fn setup(&self, ray: &Ray<S>) -> Self::RaySetup {
        let shear = self.set.setup(ray);
        (shear, T::setup_beside(ray, self.set.magnitude(), &shear))
    }

    #[inline(always)]
    fn intersect(&self, id: u32, ray: &Ray<S>, setup: &Self::RaySetup, t_max: S) -> Option<S> {
        self.set.tested::<T, Q>(id, ray, &setup.0, &setup.1, t_max)
    }
}

/// Hands the set under the chosen tests to `visitor`; `None` where a test of triangles and one of
/// spheres were chosen that are not compiled together.
pub fn visit_tested<'a, V: TestedSetVisitor<'a>>(
    prims: PrimsRef<'a, f32>,
    choice: Choice,
    visitor: V,
) -> Option<V::Output> {
    use {SphereChoice as Q, TriangleChoice as T};
    Some(match prims {
        PrimsRef::Watertight(set) => match choice.triangle {
            T::MoellerTrumbore => visitor.visit(set.tested_by::<MoellerTrumbore>()),
            T::Tolerant => visitor.visit(set.tested_by::<MoellerTrumboreTolerant>()),
            T::Pluecker => visitor.visit(set.tested_by::<Pluecker>()),
            T::Watertight => visitor.visit(set),
            T::Fallback => visitor.visit(set.tested_by::<WatertightFallback>()),
            T::Double => visitor.visit(set.tested_by::<WatertightInDouble>()),
        },
        PrimsRef::Mixed(set) => {
            macro_rules! under {
                ($triangle:ty, $sphere:ty) => {
                    visitor.visit(set.retested::<$triangle, $sphere>())
                };
            }
            match (choice.triangle, choice.sphere) {
                (T::MoellerTrumbore, Q::Rearranged) => under!(MoellerTrumbore, RearrangedSphere),
                (T::Tolerant, Q::Rearranged) => under!(MoellerTrumboreTolerant, RearrangedSphere),
                (T::Pluecker, Q::Rearranged) => under!(Pluecker, RearrangedSphere),
                (T::Watertight, Q::Rearranged) => visitor.visit(set),
                (T::Fallback, Q::Rearranged) => under!(WatertightFallback, RearrangedSphere),
                (T::Double, Q::Rearranged) => under!(WatertightInDouble, RearrangedSphere),
                (T::Watertight, Q::Naive) => under!(Watertight, NaiveSphere),
                (T::Watertight, Q::Double) => under!(Watertight, SphereInDouble),
                (T::Double, Q::Double) => under!(WatertightInDouble, SphereInDouble),
                _ => return None,
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_choose_tests_and_name_their_defects() {
        let params = |settings: &[(&str, &str)]| {
            Params::new("x", &[TRIANGLE_TEST, SPHERE_TEST], settings.iter().copied()).unwrap()
        };
        assert_eq!(Choice::of(&params(&[])), None);
        let naive = params(&[("sphere-test", "naive")]);
        assert_eq!(Choice::of(&naive).unwrap().triangle, TriangleChoice::Watertight);
        let refusal = Choice::refused(&naive, "default in f64").to_string();
        assert_eq!(refusal, "x.sphere-test = 'naive': expected default in f64");
        let has_defect = |name, value| known_defect(&params(&[(name, value)])).is_some();
        for test in ["moeller-trumbore", "moeller-trumbore-epsilon", "pluecker", "f64"] {
            assert!(has_defect("triangle-test", test), "{test}");
        }
        assert!(has_defect("sphere-test", "naive") && has_defect("sphere-test", "f64"));
        assert!(!has_defect("triangle-test", "watertight"));
        assert!(!has_defect("sphere-test", "rearranged"));
    }
}
