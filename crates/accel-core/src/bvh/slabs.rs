//! Slabs of boxes by the bits of numbers, as Embree compares them: as integers, of which Intel's
//! processors find the greater in one cycle, of numbers in four. Each node is waited for twice that.

use glam::{Vec4, Vec4Swizzles};
use wide::{f32x8, i32x4, i32x8};

use crate::geometry::ray_lanes::LANES;

/// More than the reciprocal of any component that counts, and less than overflows in a scene of
/// unit size.
pub(super) const LARGE: f32 = 1e37;

/// In which lanes a ray is within three slabs before its end, a bit each, and from which parameter
/// on, +0 at least. `enter`, `leave`: by axis, where it enters the slabs of a lane and where it
/// leaves them. There -0 counts as negative: no offset of a ray is -0, so that only a slab which
/// ends behind the ray's origin is left at -0, by rounding.
#[inline(always)]
pub(super) fn within(enter: [f32x8; 3], leave: [f32x8; 3], end: f32x8) -> (u32, f32x8) {
    let bits = |x: f32x8| bytemuck::cast::<f32x8, i32x8>(x);
    let [x, y, z] = enter.map(bits);
    let enter = x.max(y).max(z.max(i32x8::ZERO));
    let [x, y, z] = leave.map(bits);
    let leave = x.min(y).min(z.min(bits(end)));
    let is_missed = enter.simd_gt(leave).to_bitmask();
    (is_missed ^ ((1 << LANES) - 1), bytemuck::cast(enter))
}

/// Reciprocals no larger than [`LARGE`].
#[inline(always)]
pub(super) fn inverse_of(d: Vec4) -> Vec4 {
    let inverse = bits(d.recip().abs()).min(bits(Vec4::splat(LARGE)));
    Vec4::from_array(bytemuck::cast(inverse)).copysign(d)
}

/// The largest magnitude of three axes, in each of their lanes.
#[inline(always)]
pub(super) fn longest_axis(v: Vec4) -> Vec4 {
    let v = v.abs();
    let longest = bits(v).max(bits(v.yzxw())).max(bits(v.zxyw()));
    Vec4::from_array(bytemuck::cast(longest))
}

/// Integers in the order of numbers that are not negative; those of others are negative.
#[inline(always)]
fn bits(v: Vec4) -> i32x4 {
    bytemuck::cast(v.to_array())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::structures::test_scenes::Random;

    /// Of any size and sign, or infinite, but not -0.
    fn number(random: &mut Random) -> f32 {
        let size = 10f64.powf(random.unit() * 40.0 - 30.0);
        let sign = if random.unit() < 0.3 { -1.0 } else { 1.0 };
        (size * sign * if random.unit() < 0.1 { f64::INFINITY } else { 1.0 }) as f32
    }

    #[test]
    fn slabs_by_bits_are_those_by_numbers() {
        let mut random = Random(3);
        let mut met = 0;
        for _ in 0..50_000 {
            let mut columns =
                |scale: f32| [0; 3].map(|_| [0; LANES].map(|_| number(&mut random) * scale));
            let (enter, leave) = (columns(1e-10), columns(1e10));
            let end = if random.unit() < 0.1 { 0.0 } else { number(&mut random).abs() };
            let (lanes, from) =
                within(enter.map(f32x8::new), leave.map(f32x8::new), f32x8::splat(end));
            let from = from.to_array();
            for lane in 0..LANES {
                let first = enter.iter().fold(0.0f32, |all, axis| all.max(axis[lane]));
                let last = leave.iter().fold(end, |all, axis| all.min(axis[lane]));
                assert_eq!(lanes >> lane & 1 == 1, first <= last, "{enter:?} {leave:?} {end}");
                assert_eq!(from[lane].to_bits(), first.to_bits(), "{enter:?}");
                met += lanes >> lane & 1;
            }
        }
        assert!((20_000..380_000).contains(&met), "{met}");
    }

    #[test]
    fn axes_by_bits_are_those_by_numbers() {
        let mut random = Random(4);
        for round in 0..50_000 {
            let mut v = Vec3::from_array([0; 3].map(|_| number(&mut random)));
            if round % 4 > 0 {
                v[round % 3] = 0.0;
            }
            let lanes = v.extend(0.0);
            assert_eq!(longest_axis(lanes).truncate(), Vec3::splat(v.abs().max_element()), "{v}");
            let expected = v.recip().clamp(Vec3::splat(-LARGE), Vec3::splat(LARGE));
            assert_eq!(inverse_of(lanes).truncate(), expected, "{v}");
        }
    }
}
