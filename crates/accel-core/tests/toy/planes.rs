//! Parameters at which rays meet planes, for all numbers of few digits.

use super::float::Toy;
use crate::geometry::aabb::Aabb;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::grid::voxel_traversal::{GridFrame, inverse_direction};
use crate::tree::ray_planes::RayPlanes;

/// All numbers of a sign, an exponent of 4 bits and 3 more digits, but for zero, infinite ones and
/// NaN.
fn of_eight_bits() -> impl Iterator<Item = f64> + Clone {
    let sizes = (-7..8).flat_map(|e| (8..16).map(move |m| f64::from(m) * 2f64.powi(e - 3)));
    sizes.flat_map(|x| [x, -x])
}

/// All of `P` digits in [1, 2).
fn of_unit_size<const P: u32>() -> impl Iterator<Item = f64> + Clone {
    (0..1 << (P - 1)).map(|i| 1.0 + f64::from(i) * Toy::<P>::EPSILON.to_f64())
}

fn along_x<const P: u32>(o: f64, d: f64) -> Ray<Toy<P>> {
    let vector = |x: f64| Vec3::<Toy<P>>::from_dvec3(glam::dvec3(x, 0.0, 0.0));
    Ray::new(vector(o), vector(d))
}

#[test]
fn crossings_of_planes_lie_in_their_intervals() {
    let (mut asked, mut off, mut most) = (0, 0, 0.0f64);
    for o in of_eight_bits() {
        // powers of two only shift exponents
        for d in of_unit_size::<4>().flat_map(|d| [d, -d]) {
            let planes = RayPlanes::new(&along_x::<4>(o, d));
            for plane in of_eight_bits() {
                let plane = Toy::<4>::from_f64(plane);
                // exact in f64, as is its product with the direction
                let way = plane.to_f64() - o;
                let (early, late) = planes.crossing_interval(0, plane);
                let (a, b) = (early.to_f64() * d, late.to_f64() * d);
                assert!(a.min(b) <= way && way <= a.max(b), "{o} {d} {plane}: {early} {late}");
                let crossed = planes.crossing(0, plane).to_f64() * d;
                asked += 1;
                // planted: the parameter itself is no interval
                off += usize::from(crossed != way);
                let epsilons = (crossed - way).abs() / Toy::<4>::EPSILON.to_f64();
                most = most.max(if way == 0.0 { 0.0 } else { epsilons / way.abs() });
            }
        }
    }
    println!("OUTWARDS: {most:.2} epsilons of a parameter at most in {asked}");
    assert!(off > asked / 2 && (1.0..4.0).contains(&most), "{asked} {off} {most}");
}

/// Digits with which products of two errors, which the bounds leave little room for, are small.
type Eight = Toy<8>;

#[test]
fn planes_of_cells_are_met_near_where_they_are() {
    let (epsilon, magnitude) = (Eight::EPSILON.to_f64(), 1.9921875);
    let bounds = Aabb::<Eight> {
        min: Vec3::<Eight>::splat(Eight::from_f64(-magnitude)),
        max: Vec3::<Eight>::splat(Eight::from_f64(magnitude)),
    };
    let frame = GridFrame::new(bounds, [7; 3]);
    let cell = frame.cell_size()[0].to_f64();
    let mut most = [0.0f64; 2];
    for o in of_unit_size::<8>().flat_map(|o| [o * 0.5, -o, o * 2.0, -o * 4.0, o * 7.9]) {
        let o = Eight::from_f64(o).to_f64();
        for d in of_unit_size::<8>().flat_map(|d| [d, -d]) {
            let ray = along_x::<8>(o, d);
            let t = Eight::from_f64((-magnitude * d.signum() - o) / d);
            let traversal = frame.traversal_at(&ray, inverse_direction(&ray), t);
            let first = traversal.plane[0].to_f64();
            for ahead in 0..7 {
                let plane = -magnitude + (first + f64::from(ahead) * d.signum()) * cell;
                let crossed = o + traversal.plane_ahead(0, ahead).to_f64() * d;
                most[0] = most[0].max((crossed - plane).abs() / (epsilon * magnitude));
            }
        }
    }
    // boxes whose side is in every place
    for x in of_unit_size::<8>().flat_map(|x| [x, x * 0.5, x * 0.125, -x, -x * 0.5, -x * 0.125]) {
        let side = Vec3::<Eight>::splat(Eight::from_f64(x));
        let ([first, ..], _) = frame.range(&Aabb { min: side, max: side });
        let low = -magnitude + f64::from(first) * cell;
        let outside = (low - x).max(x - (low + cell));
        most[1] = most[1].max(outside / (epsilon * magnitude));
    }
    println!(
        "PLANES: {:.1}, PLACEMENT: {:.2} epsilons of the largest coordinate",
        most[0], most[1]
    );
    // with 8 digits products of errors count for an eighth
    assert!((5.0..22.0).contains(&most[0]) && (0.2..3.5).contains(&most[1]), "{most:?}");
}

/// Where a ray leaves a plane of a node of wide-bvh, as `bvh/node.rs` has it; the same without what
/// is added for rounding; and that.
fn leave(plane: Eight, origin: Eight, inverse: Eight) -> [Eight; 3] {
    let product_rounding = Eight::from_f64(1.0 + 1.0 / 32.0) * Eight::EPSILON;
    let leave = origin * inverse;
    let rounding = leave.abs() * product_rounding + inverse.abs() * Eight::EPSILON;
    [plane * inverse + (rounding - leave), plane * inverse + (-leave), rounding]
}

#[test]
fn a_ray_leaves_a_box_no_earlier_than_it_does() {
    // planes stay 64 epsilons below 2
    let planes = of_unit_size::<8>().filter(|p| *p <= 1.5).flat_map(|p| [p, -p, p * 0.3125]);
    let origins =
        of_unit_size::<8>().step_by(3).flat_map(|o| [o, -o, o * 0.125, -o * 4.0, o * 8.0]);
    let (mut early, mut most) = (0, 0.0f64);
    for d in of_unit_size::<8>() {
        let inverse = Eight::ONE / Eight::from_f64(d);
        for (plane, origin) in planes.clone().flat_map(|p| origins.clone().map(move |o| (p, o))) {
            let [plane, origin] = [plane, origin].map(Eight::from_f64);
            // exact in f64
            let exact = (plane.to_f64() - origin.to_f64()) * inverse.to_f64();
            let [left, unpadded, rounding] = leave(plane, origin, inverse);
            assert!(left >= Eight::from_f64(exact), "{plane} {origin} {d}: {left} {exact}");
            // planted: without what is added
            early += usize::from(unpadded < Eight::from_f64(exact));
            let before_its_last = (plane * inverse).to_f64() - (origin * inverse).to_f64();
            most = most.max((exact - before_its_last) / rounding.to_f64());
        }
    }
    println!("PRODUCT_ROUNDING, PLANE_ROUNDING: {most:.2} of both at most");
    assert!(early > 10_000 && most > 0.5, "{early} {most}");
}
