//! f32 and f64 from one source: the scalar trait and the vector trait over glam's types.

#![warn(missing_docs)]

use std::fmt::{Debug, Display};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use crate::geometry::lanes::{Eight, Four, inlined};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
    #[cfg(test)]
    impl<const P: u32> Sealed for crate::geometry::toy::Toy<P> {}
}

/// The largest result of [`Scalar::to_index`]: both scalars hold it, and all below it, exactly.
pub const MAX_INDEX: i32 = 1 << 24;

/// glam's three-component vector for the scalar `S`: `glam::Vec3` or `glam::DVec3`.
pub type Vec3<S> = <S as Scalar>::Vec3;

/// A floating-point type of the kernel: `f32` or `f64` (sealed).
pub trait Scalar:
    sealed::Sealed
    + Copy
    + PartialOrd
    + Debug
    + Display
    + Default
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// glam's vector of this scalar.
    type Vec3: Vector<Self>;
    /// Four of this scalar.
    type Four: Four<Scalar = Self, Array = [Self; 4]>;
    /// Eight of this scalar.
    type Eight: Eight<Scalar = Self, Array = [Self; 8]>;
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Positive infinity.
    const INFINITY: Self;
    /// Distance from 1 to the next larger number (2^-23 or 2^-52).
    const EPSILON: Self;
    /// `f32` or `f64`.
    const NAME: &'static str;
    /// Powers of two between which the largest coordinate of a scene must lie: triangle tests
    /// multiply three coordinates, cone tests four, and rays start up to 8 magnitudes away. Beyond
    /// them such products overflow, or underflow for details that are small within the scene.
    const SCENE_EXPONENTS: [i32; 2];
    /// Between these sums of the absolute components a direction is traversed as it is: reciprocals
    /// and parameters in a served scene are normal numbers.
    const DIRECTION_LENGTHS: [Self; 2];
    /// Components below this part of the longest one are too small for triangle tests: their
    /// products with lengths in a served scene may be subnormal numbers, of few digits.
    const LEAST_SLOPE: Self;
    /// Sums of products of coordinates below this may be subnormal numbers, of few digits.
    const LEAST_DETERMINANT: Self;

    /// Rounds to nearest.
    fn from_f64(x: f64) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Truncates towards zero, saturating; NaN gives 0.
    fn to_i32(self) -> i32;
    /// The whole part, but at least 0 and at most `most`, which is at most [`MAX_INDEX`]; NaN
    /// gives 0. Three instructions where [`Scalar::to_i32`] and a clamp are eight.
    fn to_index(self, most: i32) -> i32;
    /// Exact for |i| < 2^24.
    fn from_i32(i: i32) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// The next representable number above.
    fn next_up(self) -> Self;
    /// The next representable number below.
    fn next_down(self) -> Self;

    /// A power of two by which a number of this size becomes one in [1, 2), or comes as close to
    /// that as a normal number can bring it.
    fn to_unit_size(self) -> Self;

    /// `self < other ? self : other`: one instruction, and `other` when `self` is NaN.
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    /// `self > other ? self : other`: one instruction, and `other` when `self` is NaN.
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

/// A three-component vector of `S`; implemented by glam's `Vec3` and `DVec3`.
pub trait Vector<S: Scalar>:
    Copy
    + PartialEq
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<S, Output = Self>
    + Neg<Output = Self>
{
    /// From components.
    fn new(x: S, y: S, z: S) -> Self;
    /// All components equal.
    fn splat(x: S) -> Self {
        Self::new(x, x, x)
    }
    /// Components as an array.
    fn to_array(self) -> [S; 3];
    /// From an array.
    fn from_array(a: [S; 3]) -> Self {
        Self::new(a[0], a[1], a[2])
    }
    /// Dot product.
    fn dot(self, other: Self) -> S;
    /// Cross product.
    fn cross(self, other: Self) -> Self;
    /// Componentwise minimum.
    fn min(self, other: Self) -> Self;
    /// Componentwise maximum.
    fn max(self, other: Self) -> Self;
    /// Euclidean length.
    fn length(self) -> S {
        self.dot(self).sqrt()
    }
    /// From f64, each component rounded to nearest.
    fn from_dvec3(v: glam::DVec3) -> Self;
    /// To f64, exact.
    fn to_dvec3(self) -> glam::DVec3;
    /// No component is infinite or NaN.
    fn is_finite(self) -> bool;
}

macro_rules! scalar {
    (
        $s:ty, $v:ty, $four:ty, $eight:ty, $name:literal, $mantissa_bits:literal, $exponents:expr,
        $longest:literal, $least_slope:literal, $least_determinant:literal
    ) => {
        impl Scalar for $s {
            type Vec3 = $v;
            type Four = $four;
            type Eight = $eight;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const INFINITY: Self = <$s>::INFINITY;
            const EPSILON: Self = <$s>::EPSILON;
            const NAME: &'static str = $name;
            const SCENE_EXPONENTS: [i32; 2] = $exponents;
            const DIRECTION_LENGTHS: [Self; 2] = [1.0 / $longest, $longest];
            const LEAST_SLOPE: Self = $least_slope;
            const LEAST_DETERMINANT: Self = $least_determinant;

            inlined! {
                fn from_f64(x: f64) -> Self = x as $s;
                fn to_f64(self) -> f64 = f64::from(self);
                fn sqrt(self) -> Self = self.sqrt();
                fn abs(self) -> Self = self.abs();
                fn to_i32(self) -> i32 = self as i32;
                fn from_i32(i: i32) -> Self = i as $s;
                fn is_finite(self) -> bool = self.is_finite();
                fn next_up(self) -> Self = self.next_up();
                fn next_down(self) -> Self = self.next_down();
            }

            #[inline(always)]
            fn to_index(self, most: i32) -> i32 {
                // in this order NaN becomes 0
                let within = self.greater(0.0).lesser(most.clamp(0, MAX_INDEX) as $s);
                // SAFETY: `within` is a number from 0 to `MAX_INDEX`, which an i32 holds.
                unsafe { within.to_int_unchecked() }
            }

            #[inline(always)]
            fn to_unit_size(self) -> Self {
                // 1.0 has the exponent bits 0111...1: twice that is what both exponents add up to
                let sum = (1.0 as $s).to_bits() >> $mantissa_bits << 1;
                let exponent = (self.abs().to_bits() >> $mantissa_bits).clamp(1, sum - 1);
                Self::from_bits((sum - exponent) << $mantissa_bits)
            }
        }

        impl Vector<$s> for $v {
            inlined! {
                fn new(x: $s, y: $s, z: $s) -> Self = <$v>::new(x, y, z);
                fn to_array(self) -> [$s; 3] = <$v>::to_array(&self);
                fn dot(self, other: Self) -> $s = self.dot(other);
                fn cross(self, other: Self) -> Self = self.cross(other);
                fn min(self, b: Self) -> Self =
                    Self::new(self.x.lesser(b.x), self.y.lesser(b.y), self.z.lesser(b.z));
                fn max(self, b: Self) -> Self =
                    Self::new(self.x.greater(b.x), self.y.greater(b.y), self.z.greater(b.z));
                fn from_dvec3(v: glam::DVec3) -> Self = <$v>::new(v.x as $s, v.y as $s, v.z as $s);
                fn to_dvec3(self) -> glam::DVec3 =
                    glam::DVec3::new(f64::from(self.x), f64::from(self.y), f64::from(self.z));
                fn is_finite(self) -> bool = <$v>::is_finite(self);
            }
        }
    };
}

scalar!(f32, glam::Vec3, wide::f32x4, wide::f32x8, "f32", 23, [-30, 32], 1e18, 1e-20, 1e-30);
scalar!(f64, glam::DVec3, wide::f64x4, wide::f64x8, "f64", 52, [-240, 240], 1e140, 1e-220, 1e-290);

/// Four lanes of a scalar.
pub type FourOf<S> = <S as Scalar>::Four;
/// Eight lanes of a scalar.
pub type EightOf<S> = <S as Scalar>::Eight;

#[cfg(test)]
mod tests {
    use super::*;

    fn brings_to_unit_size<S: Scalar>(smallest: S, largest: S) {
        for x in [1.0, 1.5, -3.0, 0.1, 1e30, 1e-30].map(S::from_f64) {
            let scaled = (x * x.to_unit_size()).abs().to_f64();
            assert!((1.0..2.0).contains(&scaled), "{x}: {scaled}");
        }
        for x in [S::ZERO, smallest, largest, S::INFINITY] {
            let power = x.to_unit_size();
            assert!(power.is_finite() && power > S::ZERO, "{x}: {power}");
        }
        assert!((largest * largest.to_unit_size()).to_f64() < 4.0);
    }

    fn indices_are_clamped_whole_parts<S: Scalar>() {
        let x = [-1e30, -1.0, -0.5, -0.0, 0.0, 0.999, 1.0, 6.99, 7.0, 7.5, 8.0, 1e9, 1e30];
        let special = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        for x in x.into_iter().chain(special).map(S::from_f64) {
            for most in [0, 1, 7, (1 << 20) - 1, MAX_INDEX] {
                assert_eq!(x.to_index(most), x.to_i32().clamp(0, most), "{x} {most}");
            }
        }
        // beyond what is promised: still no more than an index
        assert_eq!(S::from_f64(1e30).to_index(i32::MAX), MAX_INDEX);
        assert_eq!(S::from_f64(5.0).to_index(-3), 0);
    }

    #[test]
    fn indices_in_both_precisions() {
        indices_are_clamped_whole_parts::<f32>();
        indices_are_clamped_whole_parts::<f64>();
    }

    #[test]
    fn unit_size_in_both_precisions() {
        brings_to_unit_size(f32::from_bits(1), f32::MAX);
        brings_to_unit_size(f64::from_bits(1), f64::MAX);
    }
}
