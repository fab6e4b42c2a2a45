//! Statistics of measurements: medians with bootstrap intervals, tests, fits, random numbers.

// What a command line or a file says can make nothing panic. Modules that index lists of their own
// making say so.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::indexing_slicing,
        clippy::panic,
        clippy::unreachable
    )
)]
#![allow(clippy::indexing_slicing)]

pub mod change_points;
pub mod estimate;
pub mod mann_whitney;
pub mod normal;
pub mod power_law;
pub mod product_of_medians;
pub mod random;
pub mod ratio_of_medians;
pub mod series;
pub mod verdict;
