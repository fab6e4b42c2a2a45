//! Vectors of four and of eight scalars, over crate `wide`: one instruction where the target has
//! it, plain arithmetic elsewhere. No operation contracts a product and a sum, so that lanes round
//! as scalars do.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

use wide::{f32x4, f32x8, f64x4, f64x8, i32x4, i32x8};

/// Arithmetic that vectors of any width have.
pub trait Lanes:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// Type of one lane.
    type Scalar;
    /// The lanes as an array.
    type Array;
    fn new(lanes: Self::Array) -> Self;
    fn splat(x: Self::Scalar) -> Self;
    /// The lanes as an array.
    fn to_array(self) -> Self::Array;
    /// The lesser of both; either where one is NaN.
    fn lesser(self, other: Self) -> Self;
    /// The greater of both; either where one is NaN.
    fn greater(self, other: Self) -> Self;
}

/// Four lanes, the first three for the axes.
pub trait Four: Lanes {
    /// Lanes of the three axes; 0 in the fourth.
    fn of_axes(axes: [Self::Scalar; 3]) -> Self;
    /// Exact for |i| < 2^24.
    fn from_i32(i: i32x4) -> Self;
    /// Truncates towards zero what is in the range of i32.
    fn truncate(self) -> i32x4;
    /// All ones where `self <= other`.
    fn at_most(self, other: Self) -> i32x4;
    /// Lanes of `self` where `mask` has all ones, of `other` where it has zeros.
    fn where_set(self, mask: i32x4, other: Self) -> Self;
}

/// Eight lanes. Comparisons give lanes of all ones or all zeros, of which operations on bits make
/// others.
pub trait Eight: Lanes + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// Lane mask of `self == other`.
    fn equal(self, other: Self) -> Self;
    /// Lane mask of `self <= other`.
    fn at_most(self, other: Self) -> Self;
    /// Lane mask of `self < other`.
    fn below(self, other: Self) -> Self;
    fn absolute(self) -> Self;
    /// Lanes of `self` where `mask` has all ones, of `other` where it has zeros.
    fn where_set(self, mask: Self, other: Self) -> Self;
    fn transposed(rows: [Self; 8]) -> [Self; 8];
    /// The highest bit of each lane, the first lane's lowest.
    fn high_bits(self) -> u32;
    /// Exact for |i| < 2^24.
    fn from_i32(i: i32x8) -> Self;
    /// Truncates towards zero what is in the range of i32.
    fn truncate(self) -> i32x8;
    /// Lanes of all ones or zeros as those of integers.
    fn to_mask(self) -> i32x8;
}

/// The lowest of some bits that are set, which is then set no more.
#[inline(always)]
pub fn take_lowest(bits: &mut u32) -> usize {
    let lowest = bits.trailing_zeros() as usize;
    *bits &= *bits - 1;
    lowest
}

/// Functions of an expression each, always inlined.
macro_rules! inlined {
    ($(fn $name:ident($($parameter:tt)*) -> $result:ty = $value:expr;)*) => {$(
        #[inline(always)]
        fn $name($($parameter)*) -> $result {
            $value
        }
    )*};
}
pub(super) use inlined;

macro_rules! lanes {
    ($vector:ty, $scalar:ty, $n:literal) => {
        impl Lanes for $vector {
            type Scalar = $scalar;
            type Array = [$scalar; $n];
            inlined! {
                fn new(lanes: [$scalar; $n]) -> Self = <$vector>::new(lanes);
                fn splat(x: $scalar) -> Self = <$vector>::splat(x);
                fn to_array(self) -> [$scalar; $n] = <$vector>::to_array(self);
                fn lesser(self, other: Self) -> Self = self.fast_min(other);
                fn greater(self, other: Self) -> Self = self.fast_max(other);
            }
        }
    };
}

lanes!(f32x4, f32, 4);
lanes!(f64x4, f64, 4);
lanes!(f32x8, f32, 8);
lanes!(f64x8, f64, 8);

macro_rules! eight {
    ($vector:ty, {$($conversions:tt)*}) => {
        impl Eight for $vector {
            inlined! {
                fn equal(self, other: Self) -> Self = self.simd_eq(other);
                fn at_most(self, other: Self) -> Self = self.simd_le(other);
                fn below(self, other: Self) -> Self = self.simd_lt(other);
                fn absolute(self) -> Self = self.abs();
                fn where_set(self, mask: Self, other: Self) -> Self = mask.select(self, other);
                fn transposed(rows: [Self; 8]) -> [Self; 8] = <$vector>::transpose(rows);
                fn high_bits(self) -> u32 = self.to_bitmask();
                $($conversions)*
            }
        }
    };
}

eight!(f32x8, {
    fn from_i32(i: i32x8) -> Self = Self::from_i32x8(i);
    fn truncate(self) -> i32x8 = self.fast_trunc_int();
    fn to_mask(self) -> i32x8 = bytemuck::cast(self);
});
eight!(f64x8, {
    fn from_i32(i: i32x8) -> Self = Self::new(i.to_array().map(f64::from));
    fn truncate(self) -> i32x8 = i32x8::new(self.to_array().map(|x| x as i32));
    fn to_mask(self) -> i32x8 =
        i32x8::new(self.to_array().map(|x| (x.to_bits() >> 32) as i32));
});

impl Four for f32x4 {
    inlined! {
        fn of_axes([x, y, z]: [f32; 3]) -> Self = Self::new([x, y, z, 0.0]);
        fn from_i32(i: i32x4) -> Self = Self::from_i32x4(i);
        fn truncate(self) -> i32x4 = self.fast_trunc_int();
        fn at_most(self, other: Self) -> i32x4 = bytemuck::cast(self.simd_le(other));
        fn where_set(self, mask: i32x4, other: Self) -> Self =
            bytemuck::cast::<_, Self>(mask).select(self, other);
    }
}

impl Four for f64x4 {
    inlined! {
        fn of_axes([x, y, z]: [f64; 3]) -> Self = Self::new([x, y, z, 0.0]);
        fn from_i32(i: i32x4) -> Self = Self::new(i.to_array().map(f64::from));
        fn truncate(self) -> i32x4 = i32x4::new(self.to_array().map(|x| x as i32));
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> i32x4 {
        let (a, b) = (self.to_array(), other.to_array());
        i32x4::new(std::array::from_fn(|k| -i32::from(a[k] <= b[k])))
    }

    #[inline(always)]
    fn where_set(self, mask: i32x4, other: Self) -> Self {
        let (mask, a, b) = (mask.to_array(), self.to_array(), other.to_array());
        Self::new(std::array::from_fn(|k| if mask[k] != 0 { a[k] } else { b[k] }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::scalar::Scalar;

    fn four<V: Four<Scalar = S, Array = [S; 4]>, S: Scalar>() {
        let s = |x: f64| S::from_f64(x);
        let nan = s(f64::NAN);
        let a = V::new([s(-1.5), s(2.5), s(3.0), nan]);
        let b = V::new([s(0.0), s(2.0), s(3.0), s(7.0)]);
        assert_eq!(a.lesser(b).to_array()[..3], [s(-1.5), s(2.0), s(3.0)]);
        assert_eq!(a.greater(b).to_array()[..3], [s(0.0), s(2.5), s(3.0)]);
        assert_eq!(a.at_most(b).to_array(), [-1, 0, -1, 0]);
        let mask = i32x4::new([-1, 0, 0, -1]);
        assert_eq!(b.where_set(mask, a).to_array(), [s(0.0), s(2.5), s(3.0), s(7.0)]);
        assert_eq!((a + b).truncate().to_array()[..3], [-1, 4, 6]);
        assert_eq!(V::of_axes([s(1.0), s(2.0), s(3.0)]).to_array(), [1.0, 2.0, 3.0, 0.0].map(s));
        let i = i32x4::new([-7, 0, 65_535, 9]);
        assert_eq!(V::from_i32(i).to_array(), [s(-7.0), s(0.0), s(65_535.0), s(9.0)]);
    }

    fn eight<V: Eight<Scalar = S, Array = [S; 8]>, S: Scalar>() {
        let s = |x: f64| S::from_f64(x);
        let a = V::new(std::array::from_fn(|i| s(i as f64)));
        let b = V::splat(s(3.0));
        assert_eq!(a.at_most(b).high_bits(), 0b0000_1111);
        assert_eq!(a.equal(b).high_bits(), 0b0000_1000);
        assert_eq!((a - b).high_bits(), 0b0000_0111);
        assert_eq!(a.below(b).high_bits(), 0b0000_0111);
        assert_eq!((a - b).absolute().to_array()[..2], [s(3.0), s(2.0)]);
        assert_eq!(a.at_most(V::splat(s(f64::NAN))).high_bits(), 0);
        assert_eq!(a.where_set(a.below(b), b).to_array()[2..4], [s(2.0), s(3.0)]);
        assert_eq!(a.where_set(b.below(a), b).to_array()[3..5], [s(3.0), s(4.0)]);
        let rows = V::transposed(std::array::from_fn(|i| V::splat(s(i as f64))));
        assert!(rows.iter().all(|row| row.to_array() == a.to_array()));
        assert_eq!(a.below(b).to_mask().to_array(), [-1, -1, -1, 0, 0, 0, 0, 0]);
        let i = i32x8::new([-7, 0, 65_535, 9, -1, 1, 2, 3]);
        assert_eq!(V::from_i32(i).to_array()[..3], [s(-7.0), s(0.0), s(65_535.0)]);
        assert_eq!(
            (V::from_i32(i) + V::splat(s(0.75))).truncate().to_array()[..4],
            [-6, 0, 65_535, 9]
        );
    }

    #[test]
    fn lanes_are_scalars_side_by_side() {
        four::<f32x4, f32>();
        four::<f64x4, f64>();
        eight::<f32x8, f32>();
        eight::<f64x8, f64>();
    }
}
