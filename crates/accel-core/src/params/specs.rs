//! Parameters that several structures have, for their lists of parameters. One that differs in a
//! default or a range is written `ParamSpec { default: "...", ..specs::NAME }`.

use crate::params::{ParamKind, ParamSpec};

/// Number of voxels of a grid.
pub const RESOLUTION: ParamSpec = ParamSpec {
    name: "resolution",
    summary: "rule for the number of voxels, or the number itself",
    default: "density",
    kind: ParamKind::Resolution,
};

/// Voxels per primitive of a grid.
pub const DENSITY: ParamSpec = ParamSpec::real("density", "2", 1e-6, 1e6)
    .about("voxels per primitive, D, for the rules that have it");

/// Padded or historical boxes.
pub const BOXES: ParamSpec = ParamSpec::choice("boxes", "padded", &["padded", "historical"])
    .about("boxes of primitives: padded by ulps, or as in 1999");

pub(crate) fn is_historical(boxes: &str) -> bool {
    boxes == "historical"
}

/// Order of ids in a voxel.
pub const ORDER: ParamSpec = ParamSpec::choice("order", "file", &["file", "reverse"])
    .about("order of ids in a voxel: as in the file, or reversed as in 1999");

/// Limit for cells that take memory each.
pub const MAX_CELLS: ParamSpec = ParamSpec::integer("max-cells", "67108864", 1, 1 << 32)
    .about("upper limit for the number of voxels");

/// Another default and another largest limit for cells.
pub(crate) const fn max_cells(default: &'static str, max: u64) -> ParamSpec {
    ParamSpec { default, kind: ParamKind::Integer { min: 1, max }, ..MAX_CELLS }
}

/// The same for references.
pub(crate) const fn max_references(default: &'static str, max: u64) -> ParamSpec {
    ParamSpec { default, kind: ParamKind::Integer { min: 1, max }, ..MAX_REFERENCES }
}

/// Upper limit of references in all voxels.
pub const MAX_REFERENCES: ParamSpec =
    ParamSpec::integer("max-references", "536870912", 1, (1 << 32) - 1)
        .about("upper limit for the references in all voxels together");

/// Rays one by one, or those of a batch side by side.
pub const QUERY: ParamSpec = ParamSpec::choice("query", "one", &["one", "batch"]).about(
    "batch has 32 rays of a batch take their steps side by side; sets with other primitives than \
     triangles are traversed one ray after the other",
);
