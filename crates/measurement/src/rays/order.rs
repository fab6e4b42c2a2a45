//! The order in which a row is asked its rays: as the image has them, line by line, or shuffled.
//!
//! Neighbours in an image take much the same way, so that what one ray brought into the caches
//! serves the next. Shuffled, the same rays have nothing of it: the worst case of what a renderer
//! asks after many bounces. The shuffle is seeded, so that every row and every run has the same
//! one.
//!
//! In records the rays of a kind go by its name; those in shuffled order by `NAME-shuffled`.

use std::collections::BTreeMap;

use crate::settings::choice::Choice;

const SUFFIX: &str = "-shuffled";

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RayOrder {
    /// As the image has them.
    #[default]
    Scanline,
    Shuffled,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Orders {
    #[default]
    Scanline,
    Shuffled,
    Both,
}

impl Choice for Orders {
    const ALL: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Scanline, "scanline", "As the image has them, line by line"),
        (Self::Shuffled, "shuffled", "At random, seeded"),
        (Self::Both, "both", "One after the other"),
    ];
}

impl Orders {
    pub fn name(self) -> &'static str {
        self.as_typed()
    }

    /// Them, in the order of the tables.
    pub fn orders(self) -> &'static [RayOrder] {
        match self {
            Self::Scanline => &[RayOrder::Scanline],
            Self::Shuffled => &[RayOrder::Shuffled],
            Self::Both => &[RayOrder::Scanline, RayOrder::Shuffled],
        }
    }
}

pub fn batch_name(kind: &str, order: RayOrder) -> String {
    match order {
        RayOrder::Scanline => kind.to_owned(),
        RayOrder::Shuffled => format!("{kind}{SUFFIX}"),
    }
}

/// The kind of the rays that records call so.
pub fn kind_of(name: &str) -> &str {
    name.strip_suffix(SUFFIX).unwrap_or(name)
}

/// Rays by name, without those that are there in another order, too.
pub fn distinct(rays: &BTreeMap<String, u64>) -> impl Iterator<Item = (&str, u64)> {
    let is_first = |name: &str| kind_of(name) == name || !rays.contains_key(kind_of(name));
    rays.iter().map(|(name, n)| (name.as_str(), *n)).filter(move |(name, _)| is_first(name))
}
