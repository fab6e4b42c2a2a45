//! The results of a scene.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::rays::order::distinct;
use crate::record::row::RowRecord;

/// A scene's results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct SceneRecord {
    /// Name.
    pub name: String,
    /// Hash of the source.
    pub sha256: String,
    /// Where it comes from.
    pub source: String,
    /// Under which licence, where known.
    pub licence: Option<String>,
    /// Number of primitives.
    pub primitives: u64,
    /// Bytes of the primitives, without structures.
    pub geometry_bytes: u64,
    /// Whether all of them are triangles at rest: blocks of triangles serve such scenes alone. None
    /// in records from before, and of scenes that were not loaded.
    #[serde(default)]
    pub only_triangles: Option<bool>,
    /// What the loader noticed.
    pub warnings: Vec<String>,
    /// Rays of each kind; those in shuffled order by `KIND-shuffled`, here and in all rows.
    pub rays: BTreeMap<String, u64>,
    /// How answers were judged.
    pub oracle: OracleRecord,
    /// One for each structure and setting.
    pub rows: Vec<RowRecord>,
    /// Programs outside, merged in later: in no ratio, no mean and no comparison.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub foreign: Vec<RowRecord>,
    /// Largest resident set while the scene was measured, bytes.
    pub peak_rss_bytes: Option<u64>,
}

/// How the answers of a scene were judged.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
pub struct OracleRecord {
    /// The row whose answers all others are compared with; none when the oracle confirmed none.
    pub reference: Option<String>,
    /// Structures that the oracle refused as reference, with an example each.
    pub refused: Vec<String>,
    /// Rays of the reference that were compared with f64 brute force.
    pub checked: u64,
    /// Of those, borderline rays: rounding alone decides their answer (see `oracle.rs`).
    pub borderline: u64,
    /// The same for each kind of ray: checked, borderline.
    pub by_kind: BTreeMap<String, [u64; 2]>,
}

impl SceneRecord {
    /// Rays of all kinds, each once.
    pub fn distinct_rays(&self) -> u64 {
        distinct(&self.rays).map(|(_, n)| n).sum()
    }
}
