//! Numbers of twice the digits of f64, as unevaluated sums of two.
//!
//! T. J. Dekker, "A Floating-Point Technique for Extending the Available Precision", Numerische
//! Mathematik 18, 1971; the product's error by fused multiplication.

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::DVec3;

/// `high + low`, of which `low` is at most half an ulp of `high`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct DoubleDouble {
    pub high: f64,
    low: f64,
}

impl DoubleDouble {
    pub const ZERO: Self = Self { high: 0.0, low: 0.0 };

    fn sum(high: f64, low: f64) -> Self {
        let sum = high + low;
        Self { high: sum, low: low - (sum - high) }
    }

    /// The square root; zero below zero.
    pub fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::ZERO;
        }
        // one step of Newton's doubles the digits
        let root = Self::from(self.high.sqrt());
        (root + self / root) * Self::from(0.5)
    }
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let sum = self.high + other.high;
        let part = sum - self.high;
        let error = (self.high - (sum - part)) + (other.high - part);
        Self::sum(sum, error + self.low + other.low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = self.high * other.high;
        let error = self.high.mul_add(other.high, -product);
        Self::sum(product, error + (self.high * other.low + self.low * other.high))
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = Self::from(self.high / other.high);
        let rest = self - first * other;
        first + Self::from(rest.high / other.high)
    }
}

/// A vector in more digits.
pub fn vector(v: DVec3) -> [DoubleDouble; 3] {
    [v.x.into(), v.y.into(), v.z.into()]
}

/// `a - b`, exact.
pub fn difference(a: DVec3, b: DVec3) -> [DoubleDouble; 3] {
    let of = |a: f64, b: f64| DoubleDouble::from(a) - DoubleDouble::from(b);
    [of(a.x, b.x), of(a.y, b.y), of(a.z, b.z)]
}

pub fn dot(a: [DoubleDouble; 3], b: [DoubleDouble; 3]) -> DoubleDouble {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: [DoubleDouble; 3], b: [DoubleDouble; 3]) -> [DoubleDouble; 3] {
    let of = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    [of(1, 2), of(2, 0), of(0, 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirty_digits_are_right() {
        let of = DoubleDouble::from;
        let third = of(1.0) / of(3.0);
        assert!(((third * of(3.0)) - of(1.0)).high.abs() < 1e-31);
        let root = of(2.0).sqrt();
        assert!((root * root - of(2.0)).high.abs() < 1e-31);
        // digits that f64 has lost
        let small = of(1e-25);
        assert_eq!((of(1.0) + small - of(1.0)).high, 1e-25);
        assert_eq!(of(-4.0).sqrt(), DoubleDouble::ZERO);
    }
}
