//! The `.bin` files of tinybvh's test scenes (github.com/jbikker/tinybvh, `testdata/*.bin`): the
//! number of triangles as a little-endian u32, then three corners for each of them, 16 bytes a
//! corner: x, y, z as f32, and a word of colour, which is left out. Corners in the same place
//! become one vertex.

use std::path::Path;

use crate::error::{FilePlace, LoadError};
use crate::mesh::{TriangleList, coordinate};
use crate::progress;
use crate::scene::Scene;

/// Bytes of a corner.
const CORNER: usize = 16;

/// Bytes of a triangle.
const TRIANGLE: usize = 3 * CORNER;

/// Parses such a file. `path` gives the scene its name and appears in errors, with the byte. Scenes
/// have no lights, one material, and a camera that frames them.
///
/// # Errors
/// [`LoadError::Syntax`] where the length is not what the number says (other formats end in `.bin`,
/// too), [`LoadError::NotFinite`], [`LoadError::OutOfRange`], [`LoadError::CountTooLarge`],
/// [`LoadError::NoPrimitives`].
pub fn parse_triangle_soup(path: &Path, bytes: &[u8]) -> Result<Scene, LoadError> {
    let expected = "a number n of triangles in the first 4 bytes, and 48 n bytes behind them";
    let fail = || {
        let found = format!("{} bytes", bytes.len());
        LoadError::syntax(FilePlace::byte(path, 0), &found, expected)
    };
    let (&count, data) = bytes.split_first_chunk::<4>().ok_or_else(fail)?;
    let count = usize::try_from(u32::from_le_bytes(count)).unwrap_or(usize::MAX);
    if count.checked_mul(TRIANGLE) != Some(data.len()) {
        return Err(fail());
    }
    let mut triangles = TriangleList::new(path);
    progress::begin(count);
    for (i, record) in data.chunks_exact(TRIANGLE).enumerate() {
        progress::step(i);
        let at = 4 + i * TRIANGLE;
        let place = || FilePlace::byte(path, at);
        let mut corners = [[0.0; 3]; 3];
        for (position, corner) in corners.iter_mut().zip(record.chunks_exact(CORNER)) {
            for (value, &bytes) in position.iter_mut().zip(corner.as_chunks::<4>().0) {
                *value = coordinate(f64::from(f32::from_le_bytes(bytes)), "a corner", place)?;
            }
        }
        triangles.add(corners, place)?;
    }
    progress::end();
    triangles.finish(path)
}
