//! Measuring acceleration structures: what is asked for ([`settings`]) becomes a [`plan`]; its rays
//! ([`rays`]) are answered, the answers judged ([`answers`]), rows timed in interleaved [`rounds`],
//! and everything kept as a [`record`] and in a [`journal`]. [`system`] is all there is of the
//! outside world. Nothing here knows a command line or a study.

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

pub mod answers;
pub mod callgrind;
pub mod journal;
pub mod plan;
pub mod rays;
pub mod record;
pub mod rounds;
pub mod scenes;
pub mod settings;
pub mod system;
