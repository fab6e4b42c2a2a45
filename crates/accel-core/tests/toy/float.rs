//! A third scalar for tests: numbers of few binary digits, with the exponents of f64.
//!
//! An operation is that of f64, rounded once more, to nearest and to even. For sums, products,
//! quotients and square roots that is the correctly rounded result where digits are at most half of
//! those of f64 less one (S. A. Figueroa, "When is Double Rounding Innocuous?", SIGNUM Newsletter
//! 30(3), 1995).

use std::fmt::{Debug, Display, Formatter, Result};
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Sub};

use wide::{i32x4, i32x8};

use crate::geometry::lanes::{Eight, Four, Lanes, inlined};
use crate::geometry::scalar::{Scalar, Vector};

/// Digits of f64.
const DIGITS: u32 = 53;

/// A number of `P` binary digits, at most 25.
#[derive(Clone, Copy, PartialEq, PartialOrd, Default)]
pub(crate) struct Toy<const P: u32>(f64);

impl<const P: u32> Toy<P> {
    /// The least step of the bits of f64 that stays within `P` digits.
    const STEP: u64 = 1 << (DIGITS - P);

    #[inline(always)]
    fn rounded(x: f64) -> Self {
        let bits = x.to_bits();
        let to_even = Self::STEP / 2 - 1 + ((bits / Self::STEP) & 1);
        let rounded = f64::from_bits((bits + to_even) & !(Self::STEP - 1));
        Self(if x.is_finite() { rounded } else { x })
    }

    /// So many steps away from zero.
    fn moved(self, steps: i64) -> Self {
        Self(f64::from_bits(self.0.to_bits().wrapping_add_signed(steps * Self::STEP as i64)))
    }
}

impl<const P: u32> Debug for Toy<P> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        Debug::fmt(&self.0, f)
    }
}

impl<const P: u32> Display for Toy<P> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        Display::fmt(&self.0, f)
    }
}

macro_rules! operations {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl<const P: u32> $trait for Toy<P> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::rounded(self.0 $op other.0)
            }
        }
        impl<const P: u32, const N: usize> $trait for ToyLanes<P, N> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
    )*};
}

operations!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const P: u32> AddAssign for Toy<P> {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const P: u32> Neg for Toy<P> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<const P: u32> Scalar for Toy<P> {
    type Vec3 = ToyVec<P>;
    type Four = ToyLanes<P, 4>;
    type Eight = ToyLanes<P, 8>;
    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);
    const INFINITY: Self = Self(f64::INFINITY);
    const EPSILON: Self = Self(2.0 / (1u64 << P) as f64);
    const NAME: &'static str = "toy";
    const SCENE_EXPONENTS: [i32; 2] = f64::SCENE_EXPONENTS;
    const DIRECTION_LENGTHS: [Self; 2] = [Self(1e-140), Self(1e140)];
    const LEAST_SLOPE: Self = Self(1e-220);
    const LEAST_DETERMINANT: Self = Self(1e-290);

    inlined! {
        fn from_f64(x: f64) -> Self = Self::rounded(x);
        fn to_f64(self) -> f64 = self.0;
        fn sqrt(self) -> Self = Self::rounded(self.0.sqrt());
        fn abs(self) -> Self = Self(self.0.abs());
        fn to_i32(self) -> i32 = self.0 as i32;
        fn to_index(self, most: i32) -> i32 = self.0.to_index(most);
        fn from_i32(i: i32) -> Self = Self::rounded(f64::from(i));
        fn is_finite(self) -> bool = self.0.is_finite();
        fn next_up(self) -> Self =
            if self.0 == 0.0 { Self(f64::MIN_POSITIVE) } else { self.moved(self.0.signum() as i64) };
        fn next_down(self) -> Self = -(-self).next_up();
        fn to_unit_size(self) -> Self = Self(self.0.to_unit_size());
    }
}

/// Three of them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct ToyVec<const P: u32>([Toy<P>; 3]);

impl<const P: u32> ToyVec<P> {
    fn zip(self, other: Self, f: impl Fn(Toy<P>, Toy<P>) -> Toy<P>) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
}

impl<const P: u32> Add for ToyVec<P> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const P: u32> Sub for ToyVec<P> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const P: u32> Mul<Toy<P>> for ToyVec<P> {
    type Output = Self;
    fn mul(self, factor: Toy<P>) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}

impl<const P: u32> Neg for ToyVec<P> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<const P: u32> Vector<Toy<P>> for ToyVec<P> {
    inlined! {
        fn new(x: Toy<P>, y: Toy<P>, z: Toy<P>) -> Self = Self([x, y, z]);
        fn to_array(self) -> [Toy<P>; 3] = self.0;
        fn min(self, other: Self) -> Self = self.zip(other, Scalar::lesser);
        fn max(self, other: Self) -> Self = self.zip(other, Scalar::greater);
        fn from_dvec3(v: glam::DVec3) -> Self = Self(v.to_array().map(Toy::rounded));
        fn to_dvec3(self) -> glam::DVec3 = self.0.map(|x| x.0).into();
        fn is_finite(self) -> bool = self.0.iter().all(|x| x.0.is_finite());
    }

    fn dot(self, other: Self) -> Toy<P> {
        let Self([x, y, z]) = self.zip(other, |a, b| a * b);
        x + y + z
    }
    fn cross(self, other: Self) -> Self {
        let (Self([a, b, c]), Self([x, y, z])) = (self, other);
        Self([b * z - y * c, c * x - z * a, a * y - x * b])
    }
}

/// `N` of them; masks have all bits of a lane set, or none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ToyLanes<const P: u32, const N: usize>([Toy<P>; N]);

impl<const P: u32, const N: usize> ToyLanes<P, N> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(Toy<P>, Toy<P>) -> Toy<P>) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }

    fn compare(self, other: Self, f: impl Fn(Toy<P>, Toy<P>) -> bool) -> Self {
        self.zip(other, |a, b| Toy(f64::from_bits(if f(a, b) { !0 } else { 0 })))
    }

    fn bits(self, other: Self, f: impl Fn(u64, u64) -> u64) -> Self {
        self.zip(other, |a, b| Toy(f64::from_bits(f(a.0.to_bits(), b.0.to_bits()))))
    }
}

impl<const P: u32, const N: usize> Lanes for ToyLanes<P, N> {
    type Scalar = Toy<P>;
    type Array = [Toy<P>; N];

    inlined! {
        fn new(lanes: [Toy<P>; N]) -> Self = Self(lanes);
        fn splat(x: Toy<P>) -> Self = Self([x; N]);
        fn to_array(self) -> [Toy<P>; N] = self.0;
        fn lesser(self, other: Self) -> Self = self.zip(other, Scalar::lesser);
        fn greater(self, other: Self) -> Self = self.zip(other, Scalar::greater);
    }
}

impl<const P: u32> Four for ToyLanes<P, 4> {
    inlined! {
        fn of_axes([x, y, z]: [Toy<P>; 3]) -> Self = Self([x, y, z, Toy::from_i32(0)]);
        fn from_i32(i: i32x4) -> Self = Self(i.to_array().map(Toy::from_i32));
        fn truncate(self) -> i32x4 = i32x4::new(self.0.map(Toy::to_i32));
        fn at_most(self, other: Self) -> i32x4 =
            i32x4::new(std::array::from_fn(|k| -i32::from(self.0[k] <= other.0[k])));
    }

    fn where_set(self, mask: i32x4, other: Self) -> Self {
        let mask = mask.to_array();
        Self(std::array::from_fn(|k| if mask[k] != 0 { self.0[k] } else { other.0[k] }))
    }
}

impl<const P: u32> BitAnd for ToyLanes<P, 8> {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        self.bits(other, |a, b| a & b)
    }
}

impl<const P: u32> BitOr for ToyLanes<P, 8> {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        self.bits(other, |a, b| a | b)
    }
}

impl<const P: u32> Eight for ToyLanes<P, 8> {
    inlined! {
        fn equal(self, other: Self) -> Self = self.compare(other, |a, b| a == b);
        fn at_most(self, other: Self) -> Self = self.compare(other, |a, b| a <= b);
        fn below(self, other: Self) -> Self = self.compare(other, |a, b| a < b);
        fn absolute(self) -> Self = Self(self.0.map(Toy::abs));
        fn transposed(rows: [Self; 8]) -> [Self; 8] =
            std::array::from_fn(|i| Self(std::array::from_fn(|k| rows[k].0[i])));
        fn high_bits(self) -> u32 =
            (0..8).map(|k| ((self.0[k].0.to_bits() >> 63) as u32) << k).sum();
        fn from_i32(i: i32x8) -> Self = Self(i.to_array().map(Toy::from_i32));
        fn truncate(self) -> i32x8 = i32x8::new(self.0.map(Toy::to_i32));
        fn to_mask(self) -> i32x8 = i32x8::new(self.0.map(|x| (x.0.to_bits() >> 32) as i32));
    }

    fn where_set(self, mask: Self, other: Self) -> Self {
        let is_set = |k: usize| mask.0[k].0.to_bits() != 0;
        Self(std::array::from_fn(|k| if is_set(k) { self.0[k] } else { other.0[k] }))
    }
}

#[test]
fn numbers_of_four_digits_are_rounded_to_even() {
    type T = Toy<4>;
    let t = T::from_f64;
    // between 1 and 2 there are eighths
    for (x, rounded) in [(1.0625, 1.0), (1.1875, 1.25), (1.07, 1.125), (-1.97, -2.0), (0.3, 0.3125)]
    {
        assert_eq!(t(x).0, rounded, "{x}");
    }
    assert_eq!(
        (t(1.125) * t(1.125), t(1.0) / t(3.0), t(16.0) + t(1.0)),
        (t(1.25), t(0.34375), t(16.0))
    );
    assert_eq!(T::EPSILON, t(1.0).next_up() - t(1.0));
    assert_eq!((t(1.0).next_down(), t(-2.0).next_up()), (t(0.9375), t(-1.875)));
    assert!(T::ZERO.next_down() < T::ZERO && t(f64::NAN).partial_cmp(&T::ONE).is_none());
}
