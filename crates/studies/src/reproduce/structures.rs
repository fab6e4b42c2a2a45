//! The structures of both tables of the paper.

use super::setting::Count;
use super::{adaptive, hug, octrees, recursive, uniform};

/// The structures of both tables as the paper names them, one line each.
pub(super) static STRUCTURES: &[(&str, Count)] = &[
    ("invariants", |scene, _| Ok(scene.invariants(&uniform::count(scene, None)?))),
    ("uniform", uniform::counters),
    ("recursive", recursive::counters),
    ("hug", hug::counters),
    ("adaptive", adaptive::counters),
    ("adaptive-orphan", adaptive::counters),
    (octrees::COLUMNS[0], octrees::counters),
    (octrees::COLUMNS[1], octrees::counters),
    (octrees::COLUMNS[2], octrees::counters),
    (octrees::COLUMNS[3], octrees::counters),
    (octrees::COLUMNS[4], octrees::counters),
];
