//! The studies: each a list of things to measure, and what is said of the results.

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

pub mod accuracy;
pub mod animate;
#[allow(clippy::indexing_slicing)]
pub mod cost;
pub mod error;
pub mod explain;
#[allow(clippy::indexing_slicing)]
pub mod images;
pub mod reproduce;
pub mod run;
#[allow(clippy::indexing_slicing)]
pub mod showing;
#[allow(clippy::indexing_slicing)]
pub mod sweep;
#[allow(clippy::indexing_slicing)]
pub mod tracer_comparison;
#[allow(clippy::indexing_slicing)]
pub mod verify;
