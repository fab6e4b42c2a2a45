//! Limits of loaders. They are checked before memory is allocated; errors name file, line and
//! limit. (Limits of a single format are defined with its reader.)

use crate::error::{FilePlace, LoadError};

/// Bytes of one file, after decompression: 2 GiB.
pub const MAX_BYTES: u64 = 2 << 30;

/// Bytes of a JSON scene or set file: 64 MiB. (Parsed, it takes up to 20 times as much.)
pub const MAX_JSON: u64 = 64 << 20;

pub const MAX_ELEMENTS: usize = 64 << 20;

/// Materials, and names of materials.
pub const MAX_MATERIALS: usize = 1 << 20;

pub const MAX_LIGHTS: usize = 1 << 20;

pub const MAX_TEXTURES: usize = 1 << 14;

/// Bytes of a name.
pub const MAX_NAME: usize = 1 << 10;

/// Warnings of one kind that are kept word by word; the others are counted.
pub const MAX_WARNINGS: usize = 100;

/// An error when there are more of something than there may be.
pub(crate) fn check(
    count: usize,
    limit: usize,
    what: &str,
    place: impl FnOnce() -> FilePlace,
) -> Result<(), LoadError> {
    if count <= limit {
        return Ok(());
    }
    Err(LoadError::too_many(place(), what, count as u64, limit as u64))
}
