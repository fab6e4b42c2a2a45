//! Numbers that are not finite, or whose products are not.

use accel_core::primitives::{PrimitiveError, PrimsRef, TriangleSet, Watertight};
use accel_core::structure::BuildError;
use accel_core::structures::REGISTRY;

#[test]
fn sets_refuse_coordinates_that_are_not_finite() {
    let good = [[0.0f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut triangles = vec![good; 4];
        triangles[2][1][0] = bad;
        let set = TriangleSet::<f32, Watertight>::new(triangles, |_| false);
        assert_eq!(set.unwrap_err(), PrimitiveError::NotFinite { id: 2 });
    }
    // finite, but no product of them is
    let far = |x: f32| [[x; 3], [x * 0.9, x, x], [x, x * 0.9, x]];
    let set = vec![good, far(3e38), far(-3e38)];
    let set = TriangleSet::<f32, Watertight>::new(set, |_| false).unwrap();
    for entry in REGISTRY.iter().filter(|e| e.info.name != "brute-force") {
        let params = entry.params([]).unwrap();
        let result = entry.build(PrimsRef::Watertight(&set), &params);
        assert!(
            matches!(result, Err(BuildError::OutOfScale { exponent: 127, .. })),
            "{} accepts it",
            entry.info.name
        );
    }
}
