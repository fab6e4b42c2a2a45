//! Results of the first pass over an OBJ file, and the corners of its faces: indices of positions,
//! texture coordinates and normals.
//!
//! An index counts from 1 at the start of the file, and may mean what follows only later; a
//! negative one counts backwards from where it stands. That of a position must mean one. An index
//! of a normal or of texture coordinates that means none is counted, and its face is flat or plain.

use glam::DVec3;

use crate::error::{FilePlace, LoadError, shortened};
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::first_and_counts;
use crate::obj::rows::words;
use crate::polygon::ear_clipping::MAX_CORNERS;

/// A corner without normal or texture coordinates.
pub(crate) const NONE: u32 = u32::MAX;

/// Results of the first pass.
#[derive(Debug, Default)]
pub(crate) struct ObjScan {
    /// Every `v`, divided by its weight; NaN where no face can use it.
    pub positions: Vec<DVec3>,
    /// Every `vn`; NaN where it is none.
    pub normals: Vec<DVec3>,
    /// The faces in file order.
    pub faces: Vec<FaceLine>,
    /// For each corner of each face the index of its position, counted from 0.
    pub corners: Vec<u32>,
    /// The same for normals, or `NONE`; empty in files without `vn`.
    pub normal_corners: Vec<u32>,
    /// Texture coordinates in file order, with (0, 0) at the lower left, NaN where they are none;
    /// empty in files without `mtllib`, which cannot have textures.
    pub texcoords: Vec<[f32; 2]>,
    /// For each corner the index of its texture coordinates, or `NONE`; empty where `texcoords`
    /// is.
    pub texcoord_corners: Vec<u32>,
    /// Arguments of `mtllib`, each once, with its first line.
    pub libraries: Vec<(usize, String)>,
    /// Every material name of a `usemtl`, with the line of its first use, in that order.
    pub used: Vec<(usize, String)>,
    /// Every `usemtl`: how many faces come before it, and which of `used` it names, if any.
    pub switches: Vec<(usize, Option<usize>)>,
    /// Number of lines with an unknown keyword, and the first of them.
    pub unknown: usize,
    pub first_unknown: Option<(usize, String)>,
    /// Lines that were not taken literally.
    pub odd: Oddities,
    /// The file may have normals: corners keep their indices of those.
    pub keeps_normals: bool,
    /// The file may have textures: texture coordinates are kept.
    pub keeps_texcoords: bool,
    /// Number of `vt` lines so far.
    pub texcoord_count: usize,
}

first_and_counts! {
    /// Lines that were left out, or read in another way than some readers do.
    struct Oddities {
        positions: "vertices with a coordinate or weight that is not usable",
        normals: "invalid normals: their faces are flat",
        texcoords: "invalid texture coordinates: their faces have the plain colour",
        lost_normals: "invalid indices of normals: their faces are flat",
        lost_texcoords: "invalid indices of texture coordinates",
        early_faces: "faces before their vertices: indices count from the file's start",
        thin_faces: "faces with fewer than 3 corners left out",
        nameless: "usemtl or mtllib without a name",
        kept_apart: "comments or names that end in `\\`: they end with their line",
        lines: "line elements left out",
        points: "point elements left out",
        curves: "free-form curves and surfaces left out",
    }
}

/// Place of a face, its number of corners, and whether all of them have normals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceLine {
    pub line: u32,
    pub corners: u32,
    pub smooth: bool,
}

impl ObjScan {
    /// Adds the face of a row with its corners.
    pub(super) fn add_face(
        &mut self,
        row: &[u8],
        line: usize,
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        let (positions, normals) = (self.positions.len(), self.normals.len());
        let (mut corners, mut smooth, mut is_early) = (0, true, false);
        for corner in words(row) {
            let bad = || LoadError::syntax(place(), corner, "a corner: v, v/vt, v//vn or v/vt/vn");
            let mut parts = corner.split('/');
            let text = parts.next().filter(|text| !text.is_empty()).ok_or_else(bad)?;
            let position = resolve(number(text, "vertex", &place)?, positions)
                .ok_or_else(|| out_of_range(text, positions, &place))?;
            is_early |= position as usize >= positions;
            self.corners.push(position);
            let mut decoration = |what, count| match parts.next() {
                None | Some("") => Ok((NONE, false)),
                Some(text) => {
                    let index = resolve(number(text, what, &place)?, count);
                    Ok::<_, LoadError>((index.unwrap_or(NONE), index.is_none()))
                }
            };
            let (texcoord, no_texcoord) = decoration("texture coordinate", self.texcoord_count)?;
            let (normal, no_normal) = decoration("normal", normals)?;
            if parts.next().is_some() {
                return Err(bad());
            }
            if self.keeps_normals {
                self.normal_corners.push(normal);
            }
            if self.keeps_texcoords {
                self.texcoord_corners.push(texcoord);
                if no_texcoord {
                    self.odd.lost_texcoords.add(&place);
                }
            }
            // of a file without normals no index means one
            if no_normal || (normal != NONE && !self.keeps_normals) {
                self.odd.lost_normals.add(&place);
            }
            smooth &= normal != NONE && self.keeps_normals;
            corners += 1;
            let what = "the number of corners of a face";
            limits::check(corners as usize, MAX_CORNERS, what, &place)?;
        }
        if corners < 3 {
            self.odd.thin_faces.add(place);
            for list in [&mut self.corners, &mut self.normal_corners, &mut self.texcoord_corners] {
                list.truncate(list.len().saturating_sub(corners as usize));
            }
            return Ok(());
        }
        if is_early {
            self.odd.early_faces.add(place);
        }
        let line = u32::try_from(line).unwrap_or(u32::MAX);
        self.faces.push(FaceLine { line, corners, smooth });
        Ok(())
    }

    /// Looks at the indices that were ahead of what they mean, now that all of the file is known.
    ///
    /// # Errors
    /// [`LoadError::IndexOutOfRange`] with the line of the first face without a vertex.
    pub(super) fn check_indices(
        &mut self,
        place: impl Fn(usize) -> FilePlace,
    ) -> Result<(), LoadError> {
        let Self { faces, odd, .. } = self;
        let positions = self.positions.len();
        each_beyond(positions, &mut self.corners, faces, |index, face| {
            let valid = format!("the file has {positions} vertices");
            let place = place(face.line as usize);
            Err(LoadError::bad_index(place, "vertex", *index + 1, valid))
        })?;
        each_beyond(self.normals.len(), &mut self.normal_corners, faces, |index, face| {
            (*index, face.smooth) = (NONE, false);
            odd.lost_normals.add(|| place(face.line as usize));
            Ok(())
        })?;
        each_beyond(self.texcoord_count, &mut self.texcoord_corners, faces, |index, face| {
            *index = NONE;
            odd.lost_texcoords.add(|| place(face.line as usize));
            Ok(())
        })
    }
}

/// An index as it stands; 0 for numbers beyond i64.
fn number(text: &str, what: &str, place: impl Fn() -> FilePlace) -> Result<i64, LoadError> {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return Err(LoadError::syntax(place(), text, format!("an index ({what})")));
    }
    Ok(text.parse().unwrap_or(0))
}

/// Resolves an index to one counted from 0, with `count` elements before it. `None` for 0 and for
/// indices beyond any file.
fn resolve(index: i64, count: usize) -> Option<u32> {
    let size = usize::try_from(index.unsigned_abs()).ok()?;
    let index = if index < 0 { count.checked_sub(size)? } else { size.checked_sub(1)? };
    u32::try_from(index).ok().filter(|_| index < MAX_ELEMENTS)
}

fn out_of_range(text: &str, count: usize, place: impl Fn() -> FilePlace) -> LoadError {
    let valid = match count {
        0 => "the file has no vertex before this line".to_owned(),
        _ => format!("1 to {count}, or -1 to -{count}, are defined before this line"),
    };
    LoadError::bad_index(place(), "vertex", shortened(text), valid)
}

/// Calls a function with each index of a corner that is `count` or more, and its face.
fn each_beyond(
    count: usize,
    corners: &mut [u32],
    faces: &mut [FaceLine],
    mut found: impl FnMut(&mut u32, &mut FaceLine) -> Result<(), LoadError>,
) -> Result<(), LoadError> {
    let is_beyond = |index: u32| index != NONE && index as usize >= count;
    if !corners.iter().any(|&index| is_beyond(index)) {
        return Ok(());
    }
    let mut corners = corners.iter_mut();
    for face in faces {
        let own = corners.by_ref().take(face.corners as usize);
        own.filter(|index| is_beyond(**index)).try_for_each(|index| found(index, face))?;
    }
    Ok(())
}
