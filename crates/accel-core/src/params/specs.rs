//! Parameters that several structures have, for their lists of parameters. One that differs in a
//! default or a range is written `ParamSpec { default: "...", ..specs::NAME }`.

use crate::params::{ParamKind, ParamSpec};

/// How many voxels.
pub const RESOLUTION: ParamSpec = ParamSpec {
    name: "resolution",
    summary: "rule for the number of voxels, or the number itself",
    default: "density",
    kind: ParamKind::Resolution,
};

/// Voxels per primitive.
pub const DENSITY: ParamSpec = ParamSpec {
    name: "density",
    summary: "voxels per primitive, D, for the rules that have it",
    default: "2",
    kind: ParamKind::Real { min: 1e-6, max: 1e6 },
};

/// Padded or historical boxes.
pub const BOXES: ParamSpec = ParamSpec {
    name: "boxes",
    summary: "boxes of primitives: padded by ulps, or as in 1999",
    default: "padded",
    kind: ParamKind::Choice(&["padded", "historical"]),
};

/// Order of ids in a voxel.
pub const ORDER: ParamSpec = ParamSpec {
    name: "order",
    summary: "order of ids in a voxel: as in the file, or reversed as in 1999",
    default: "file",
    kind: ParamKind::Choice(&["file", "reverse"]),
};

/// Limit for cells that take memory each.
pub const MAX_CELLS: ParamSpec = ParamSpec {
    name: "max-cells",
    summary: "upper limit for the number of voxels",
    default: "67108864",
    kind: ParamKind::Integer { min: 1, max: 1 << 32 },
};

/// Limit for references.
pub const MAX_REFERENCES: ParamSpec = ParamSpec {
    name: "max-references",
    summary: "upper limit for the references in all voxels together",
    default: "536870912",
    kind: ParamKind::Integer { min: 1, max: (1 << 32) - 1 },
};
