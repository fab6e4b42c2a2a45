//! A wrong answer, and the kinds of answers that differ from ours.

use accel_core::{Hit, Ray, Scalar};
use measurement::rays::exactness::is_apart;

/// How an answer differs from ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Difference {
    /// In `t`, by no more than rounding.
    LastBits,
    /// The ray passes an edge so closely that moving it changes the right answer, too.
    Edge,
    /// A hit is missed, or one behind it is returned.
    Lost,
    /// There is no such hit.
    Invented,
    /// The hit is there, but on another primitive.
    WrongId,
}

impl Difference {
    /// All of them, with their names in records and tables.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::LastBits, "last_bits"),
        (Self::Edge, "at_edges"),
        (Self::Lost, "lost"),
        (Self::Invented, "invented"),
        (Self::WrongId, "wrong_id"),
    ];

    /// Between an answer and the right one, which are not equal.
    pub fn of_hits<S: Scalar>(ray: &Ray<S>, said: &Hit<S>, right: &Hit<S>) -> Self {
        match (said.is_hit(), right.is_hit()) {
            (false, _) => Self::Lost,
            (true, false) => Self::Invented,
            _ if is_apart(said, right, ray) && said.t > right.t && said.id != right.id => {
                Self::Lost
            }
            _ if is_apart(said, right, ray) => Self::Invented,
            _ if said.id != right.id => Self::WrongId,
            _ => Self::LastBits,
        }
    }

    /// Between an answer about an occlusion and the right one.
    pub fn of_occlusion(said: bool) -> Self {
        if said { Self::Invented } else { Self::Lost }
    }
}

/// An answer that differs from ours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// Index of the ray in the round.
    pub ray: usize,
    /// How it differs; none where the structure panicked, or only an oracle sees it.
    pub difference: Option<Difference>,
    /// True if it is wrong. Last bits and edges are so only of our own primitive tests.
    pub is_wrong: bool,
    /// The answer and the right one; empty if it is not wrong.
    pub what: String,
}

impl Mismatch {
    pub fn wrong(ray: usize, difference: Option<Difference>, what: String) -> Self {
        Self { ray, difference, is_wrong: true, what }
    }

    /// A difference that is none of the structure's faults.
    pub fn tolerated(ray: usize, difference: Difference) -> Self {
        Self { ray, difference: Some(difference), is_wrong: false, what: String::new() }
    }
}
