//! The cases of the catalogue.

use accel_core::primitives::PrimitiveError;

use super::round::Round;
use statistics::random::Random;

/// Draws a round of at most so many rays.
pub type Draw<S> = fn(&mut Random, usize) -> Result<Round<S>, PrimitiveError>;

/// Runner of a case.
#[derive(Debug)]
pub struct CaseRunner {
    /// Rounds in single precision.
    pub single: Draw<f32>,
    /// Rounds in double precision.
    pub double: Draw<f64>,
    /// Structures with settings of the case's own, as labels; all that are asked for when there are
    /// none.
    pub rows: &'static [&'static str],
}

/// One line of the catalogue.
#[derive(Debug)]
pub struct Case {
    pub id: &'static str,
    /// Description of the difficulty.
    pub summary: &'static str,
    /// The oracle that decides which answer is right.
    pub oracle: &'static str,
    /// Runner of a case.
    pub ask: CaseRunner,
    /// One ray of so many asked for is drawn: for scenes that make rays dear.
    pub share: usize,
}

/// A case whose rounds `$draw` makes in both precisions.
#[macro_export]
macro_rules! case {
    ($id:literal, $oracle:literal, $draw:path, $summary:literal) => {
        $crate::case!($id, $oracle, $draw, $summary, 1, &[])
    };
    ($id:literal, $oracle:literal, $draw:path, $summary:literal, $share:literal, $rows:expr) => {
        $crate::verify::registry::Case {
            id: $id,
            summary: $summary,
            oracle: $oracle,
            ask: $crate::verify::registry::CaseRunner { single: $draw, double: $draw, rows: $rows },
            share: $share,
        }
    };
}

/// Cases of a kind.
#[derive(Debug)]
pub struct Group {
    pub name: &'static str,
    pub cases: &'static [Case],
}
