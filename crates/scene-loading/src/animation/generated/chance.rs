//! Numbers without a pattern that are the same on every machine, by their places.
//!
//! SplitMix64: G. Steele, D. Lea, C. Flood, "Fast Splittable Pseudorandom Number Generators",
//! OOPSLA 2014.

use glam::DVec3;

/// A number in [0, 1): of thing `i` the one called `what`.
pub(super) fn unit(i: u64, what: u64) -> f64 {
    (mixed(i.wrapping_mul(64).wrapping_add(what)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A number in [low, high).
pub(super) fn between(low: f64, high: f64, i: u64, what: u64) -> f64 {
    low + (high - low) * unit(i, what)
}

/// Three numbers in [-1, 1): those called `what` and the two behind it.
pub(super) fn vector(i: u64, what: u64) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| between(-1.0, 1.0, i, what + k)))
}

/// A whole number from 0 to `below` - 1.
pub(super) fn whole(below: u64, i: u64, what: u64) -> u64 {
    mixed(i.wrapping_mul(64).wrapping_add(what)) % below
}

fn mixed(i: u64) -> u64 {
    let z = i.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
