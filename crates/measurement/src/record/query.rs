//! How a row is asked: ray by ray, or a batch at a time.
//!
//! A call that has several rays go side by side, or prepares several at once, hides the time that
//! each of them waits for; one ray alone cannot. The two are different questions, so tables say
//! which one a row answered. It is read off what was built over the scene, not off names or
//! settings: a structure may have its batches for triangles alone.

use serde::{Deserialize, Serialize};

/// How a row answered the rays of a scene.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub enum Query {
    /// Each ray was traversed to its end before the next one began.
    #[default]
    #[serde(rename = "one ray")]
    OneRay,
    /// A whole batch in one call, its rays together.
    #[serde(rename = "batch")]
    Batch,
}

impl Query {
    pub fn name(self) -> &'static str {
        match self {
            Self::OneRay => "one ray",
            Self::Batch => "batch",
        }
    }

    /// Of a row over several scenes, in that many of which it answered batches.
    pub fn over_scenes(batch_scenes: u64, scenes: u64) -> String {
        match batch_scenes {
            0 => Self::OneRay.name().to_owned(),
            all if all == scenes => Self::Batch.name().to_owned(),
            some => format!("batch in {some} of {scenes}"),
        }
    }
}

/// What stands below tables that have rows of both.
pub const NOTE: &str = "query: batch rows answer many rays together in one call; all others, \
                        including the reference, get rays one by one.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixed_queries_name_the_number_of_batch_scenes() {
        assert_eq!(Query::over_scenes(0, 3), "one ray");
        assert_eq!(Query::over_scenes(3, 3), "batch");
        assert_eq!(Query::over_scenes(1, 3), "batch in 1 of 3");
        assert_eq!(Query::over_scenes(0, 0), "one ray");
    }
}
