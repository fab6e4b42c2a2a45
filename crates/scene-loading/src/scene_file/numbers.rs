//! Numbers of scene files that must lie in a range. Refused while the file is parsed, so that the
//! error names the line. (JSON itself has neither NaN nor infinity, and the parser refuses numbers
//! that `f64` cannot hold.)

use serde::de::{Deserialize, Deserializer, Error};

/// Largest number of samples of one effect: more would take hours.
pub(crate) const MOST_SAMPLES: u32 = 65_536;

fn checked<'de, D: Deserializer<'de>>(
    from: D,
    is_valid: fn(f64) -> bool,
    expected: &str,
) -> Result<f64, D::Error> {
    let x = f64::deserialize(from)?;
    if is_valid(x) {
        Ok(x)
    } else {
        Err(D::Error::custom(format!("found {x}, expected {expected}")))
    }
}

/// A length or a time.
pub(crate) fn at_least_0<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    checked(from, |x| x >= 0.0, "a number of at least 0")
}

/// A length that may be missing but not 0.
pub(crate) fn above_0<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    checked(from, |x| x > 0.0, "a number above 0").map(Some)
}

pub(crate) fn share<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    checked(from, |x| (0.0..=1.0).contains(&x), "a number from 0 to 1").map(Some)
}

/// A number of samples.
pub(crate) fn samples<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u32>, D::Error> {
    let n = u32::deserialize(from)?;
    if (1..=MOST_SAMPLES).contains(&n) {
        return Ok(Some(n));
    }
    Err(D::Error::custom(format!("found {n}, expected 1 to {MOST_SAMPLES} samples")))
}
