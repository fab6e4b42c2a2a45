//! Builders of primitives refuse what is no primitive, with a typed error; what they take, every
//! structure builds and traces.

use accel_core::primitives::{Cone, Instance, MixedSet, MixedSetBuilder, PrimSet, PrimsRef};
use accel_core::primitives::{PrimitiveError, TriangleSet, Watertight};
use accel_core::registry::Buildable;
use accel_core::structures::REGISTRY;
use accel_core::{Hit, Ray, Vec3, Vector};
use glam::{DAffine3, DMat3, DVec3, dvec3};

use crate::common::build;

/// Numbers that are none, and the smallest and largest that are.
const SPECIAL: [f64; 10] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -1e-300, -0.0, 5e-324, 1e-45, 3e38, 1.7e308];

/// Every structure builds and answers, or says with a typed error why not.
fn all_answer<S: Buildable>(set: &MixedSet<S>) {
    let point = |p: DVec3| Vec3::<S>::from_dvec3(p);
    let rays = [
        Ray::new(point(dvec3(0.1, 0.2, -9.0)), point(DVec3::Z)),
        Ray::new(point(dvec3(0.1, 0.2, 0.3)), point(dvec3(1.0, 1.0, 0.1))),
        Ray::new(point(DVec3::ZERO), point(DVec3::X)),
    ];
    for entry in REGISTRY {
        for variant in entry.info.variants {
            if let Ok(tracer) = build(PrimsRef::Mixed(set), entry.info.name, variant) {
                tracer.closest_hits(&rays, &mut [Hit::NONE; 3]);
                tracer.occlusions(&rays, &mut [false; 3]);
            }
        }
    }
}

/// A set of two triangles and what `add` adds, if the builder takes that.
fn added<S: Buildable>(
    add: impl FnOnce(&mut MixedSetBuilder<S>) -> Result<(), PrimitiveError>,
) -> Result<MixedSet<S>, PrimitiveError> {
    let mut set = MixedSetBuilder::default();
    set.triangle([DVec3::ZERO, DVec3::X, DVec3::Y])?;
    set.triangle([DVec3::Z, DVec3::X, DVec3::Y])?;
    add(&mut set)?;
    Ok(set.finish())
}

fn builders_refuse_or_serve<S: Buildable>() {
    let [mut refused, mut taken] = [0; 2];
    let mut asked = |made: Result<MixedSet<S>, PrimitiveError>| match made {
        Ok(set) => {
            taken += 1;
            all_answer(&set);
        }
        Err(PrimitiveError::TooMany { .. }) => panic!("not many"),
        Err(_) => refused += 1,
    };
    for x in SPECIAL {
        let odd = dvec3(0.5, x, 0.1);
        asked(added(|set| set.sphere(DVec3::splat(0.5), x)));
        asked(added(|set| set.sphere(odd, 0.5)));
        asked(added(|set| set.triangle([DVec3::ZERO, DVec3::Z, odd])));
        asked(added(|set| set.polygon(&[DVec3::ZERO, DVec3::X, DVec3::Y, odd])));
        asked(added(|set| set.cone(Cone::new(DVec3::ZERO, x, DVec3::ONE, 0.5))));
        asked(added(|set| set.cone(Cone::new(DVec3::ZERO, 0.5, DVec3::ONE, x))));
        asked(added(|set| set.cone(Cone::new(DVec3::ZERO, x, DVec3::ONE, x))));
        asked(added(|set| set.cone(Cone::new(odd, 0.5, DVec3::ONE, 0.1))));
        asked(added(|set| set.cone(Cone::new(DVec3::ZERO, 0.5, odd, 0.1))));
        asked(added(|set| set.last_moves(dvec3(0.1, x, 0.0), 1.0)));
        asked(added(|set| set.last_moves(dvec3(0.1, 0.2, 0.0), x)));
        // claims of copies that are none are left out
        let placements = [
            DAffine3::from_translation(odd),
            DAffine3::from_mat3(DMat3::from_diagonal(odd)),
            DAffine3::from_mat3(DMat3::ZERO),
        ];
        for placement in placements {
            let claim = |first, placement| Instance { object: 0, first, count: 1, placement };
            let claims = [claim(0, DAffine3::IDENTITY), claim(1, placement)];
            asked(added(|_| Ok(())).map(|set: MixedSet<S>| set.with_instances(&claims)));
        }
    }
    assert!(refused > 30 && taken > 40, "{} {refused} {taken}", S::NAME);
}

#[test]
fn builders_refuse_or_serve_in_f32() {
    builders_refuse_or_serve::<f32>();
}

#[test]
fn builders_refuse_or_serve_in_f64() {
    builders_refuse_or_serve::<f64>();
}

#[test]
fn errors_name_the_primitive() {
    let radius = added::<f32>(|set| set.sphere(DVec3::ZERO, -1.0)).unwrap_err();
    assert_eq!(radius, PrimitiveError::NegativeRadius { id: 2 });
    for exposure in [-1.0, f64::NAN, f64::INFINITY] {
        let moved = added::<f32>(|set| set.last_moves(DVec3::X, exposure)).unwrap_err();
        assert_eq!(moved, PrimitiveError::Exposure { id: 1 });
    }
    for x in [f64::NAN, f64::INFINITY, 1e300] {
        let sphere = added::<f32>(|set| set.sphere(DVec3::ZERO, x)).unwrap_err();
        let cone = |set: &mut MixedSetBuilder<f32>| set.cone(Cone::new(DVec3::X, x, DVec3::Y, 1.0));
        assert_eq!(sphere, PrimitiveError::NotFinite { id: 2 });
        assert_eq!(added(cone).unwrap_err(), PrimitiveError::NotFinite { id: 2 });
    }
}

/// Triangles far smaller than the scene, whose products underflow, are hit at their parameter.
fn tiny_triangles_are_hit<S: Buildable>(sizes: &[f64]) {
    for &size in sizes {
        let corners = |size: f64, z: f64| {
            [dvec3(-1.0, -1.0, 0.0), dvec3(2.0, -1.0, 0.0), dvec3(-1.0, 2.0, 0.0)]
                .map(|p| Vec3::<S>::from_dvec3((p * size).with_z(z)).to_array())
        };
        let tiny: Vec<_> = (0..16).map(|_| corners(size, 0.5)).collect();
        let large = corners(1.0, 0.875);
        let triangles = tiny.into_iter().chain([large]).collect();
        let set = TriangleSet::<S, Watertight>::new(triangles, |_| false).unwrap();
        let point = |x: f64, y: f64, z: f64| Vec3::<S>::from_dvec3(dvec3(x * size, y * size, z));
        let direction = Vec3::<S>::from_dvec3(DVec3::Z);
        for (x, y, is_met) in [(0.1, 0.2, true), (0.0, 0.0, true), (0.6, 0.6, false)] {
            let ray = Ray::<S>::new(point(x, y, 0.0), direction);
            let setup = set.setup(&ray);
            let outline = [[-1.0, -1.0], [0.5, -1.0], [2.0, -1.0], [-1.0, 2.0]];
            let mut mixed = MixedSetBuilder::<S>::default();
            mixed.polygon(&outline.map(|[x, y]| dvec3(x * size, y * size, 0.5))).unwrap();
            mixed.triangle([DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap();
            let mixed = mixed.finish();
            let met = mixed.intersect(0, &ray, &mixed.setup(&ray), S::INFINITY).map(S::to_f64);
            assert_eq!(met, is_met.then_some(0.5), "polygon {size:e} {x} {y}");
            let met = set.intersect(0, &ray, &setup, S::INFINITY).map(S::to_f64);
            assert_eq!(met, is_met.then_some(0.5), "{size:e} {x} {y}");
            for entry in REGISTRY {
                let params = entry.params([]).unwrap();
                if (entry.info.known_defect)(&params).is_some() {
                    continue;
                }
                let tracer = entry.build(PrimsRef::Watertight(&set), &params).unwrap();
                let mut hit = [Hit::NONE];
                tracer.closest_hits(&[ray], &mut hit);
                let expected = if is_met { (0.5, 0) } else { (0.875, 16) };
                let found = (hit[0].t.to_f64(), hit[0].id);
                assert_eq!(found, expected, "{} {size:e} {x} {y}", entry.info.name);
            }
        }
    }
}

#[test]
fn triangles_whose_products_underflow_are_hit() {
    tiny_triangles_are_hit::<f32>(&[1e-12, 1e-18, 1e-21, 1e-23]);
    tiny_triangles_are_hit::<f64>(&[1e-100, 1e-150, 1e-156, 1e-170, 1e-220]);
}
