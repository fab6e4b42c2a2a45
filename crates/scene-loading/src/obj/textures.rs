//! The texture coordinates of OBJ faces.

use crate::obj::contents::ObjScan;
use crate::obj::corners::NONE;
use crate::obj::maps::Placement;
use crate::scene::Texcoords;

/// The texture coordinates of one face after the other.
pub(crate) struct FaceTexcoords<'a> {
    texcoords: &'a [[f32; 2]],
    rest: &'a [u32],
    face: &'a [u32],
}

impl<'a> FaceTexcoords<'a> {
    /// Before the first face of a file.
    pub fn new(scan: &'a ObjScan) -> Self {
        Self { texcoords: &scan.texcoords, rest: &scan.texcoord_corners, face: &[] }
    }

    /// Goes to the next face, which has so many corners.
    pub fn next_face(&mut self, corners: usize) {
        (self.face, self.rest) = self.rest.split_at_checked(corners).unwrap_or_default();
    }

    /// Whether all corners of the face have any.
    pub fn are_known(&self) -> bool {
        let is_known = |&i: &u32| {
            i != NONE
                && self.texcoords.get(i as usize).is_some_and(|uv| !uv.iter().any(|x| x.is_nan()))
        };
        !self.face.is_empty() && self.face.iter().all(is_known)
    }

    /// Those of three of its corners in an image that lies as `placement` says, counted from the
    /// upper left: in OBJ files v grows upwards.
    pub fn of(&self, piece: [usize; 3], placement: Option<&Placement>) -> Option<Texcoords> {
        let corner = |i: usize| self.texcoords.get(*self.face.get(i)? as usize);
        let [a, b, c] = piece.map(corner);
        let placed = |[u, v]: [f32; 2]| match placement {
            Some(Placement { scale: [x, y], offset: [right, up] }) => {
                [(u * x + right).clamp(f32::MIN, f32::MAX), (v * y + up).clamp(f32::MIN, f32::MAX)]
            }
            None => [u, v],
        };
        Some([a?, b?, c?].map(|&corner| placed(corner)).map(|[u, v]| [u, 1.0 - v]))
    }
}
