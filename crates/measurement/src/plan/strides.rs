//! The stride of each row (every k-th ray is issued to it), as in an earlier record.
//!
//! A run thins the rays of slow rows by what a pilot costs, which differs from run to run. What is
//! compared with an earlier record must be asked that record's rays, or neither counters nor times
//! could be compared.

use std::collections::BTreeMap;

use crate::rays::order::{distinct, kind_of};
use crate::record::{AnsweredRays, RowRecord, RunRecord, SceneRecord};

/// Strides by scene and label of the row; none but of the rows of a record.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FixedStrides(BTreeMap<(String, String), RowStrides>);

/// Strides of the rays that are compared, and of those that are timed; none where the record does
/// not say.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RowStrides {
    pub checked: Option<usize>,
    pub timed: Option<usize>,
}

impl FixedStrides {
    /// Strides of a record; `lightly` multiplies the stride of checked rays.
    pub fn of(record: &RunRecord, lightly: usize) -> Self {
        let mut strides = BTreeMap::new();
        for scene in &record.scenes {
            for row in &scene.rows {
                let checked = checked(scene, row).map(|stride| stride.saturating_mul(lightly));
                let timed = row.verdict.is_timed().then_some(row.stride as usize);
                let of_row = RowStrides { checked, timed };
                strides.insert((scene.name.clone(), row.label()), of_row);
            }
        }
        Self(strides)
    }

    pub fn of_row(&self, scene: &str, label: &str) -> RowStrides {
        self.0.get(&(scene.to_owned(), label.to_owned())).copied().unwrap_or_default()
    }
}

/// The power of two that leaves so many rays as were counted.
fn checked(scene: &SceneRecord, row: &RowRecord) -> Option<usize> {
    let counted = row.work.as_ref()?.rays;
    let is_asked = |name: &str| row.answers == AnsweredRays::AllRays || kind_of(name) == "shadow";
    let all = || distinct(&scene.rays).filter(|(name, _)| is_asked(name)).map(|(_, n)| n);
    let left = |stride: u64| all().map(|n| n.div_ceil(stride)).sum::<u64>();
    let stride = (0..40).map(|power| 1u64 << power).find(|&stride| left(stride) == counted)?;
    Some(stride as usize)
}
