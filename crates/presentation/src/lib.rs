//! How results look: tables, numbers, plots and pages. Nothing here knows what was measured.

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

pub mod column;
pub mod csv;
pub mod drawing;
pub mod html;
pub mod json;
pub mod markdown;
pub mod numbers;
pub mod outside;
pub mod page;
pub mod svg_plot;
pub mod table;
pub mod text;
