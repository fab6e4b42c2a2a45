//! Results of the first pass over an OBJ file.

use glam::DVec3;

use crate::mesh::FirstAndCount;
use crate::scene::Scene;

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
    /// Number of `l` elements.
    pub lines: usize,
    /// Number of `p` elements.
    pub points: usize,
    /// Number of free-form curves and surfaces.
    pub curves: usize,
    /// Number of lines with an unknown keyword, and the first of them.
    pub unknown: usize,
    pub first_unknown: Option<(usize, String)>,
    /// Lines that were not taken literally.
    pub odd: Oddities,
    pub(super) needed: IndexCounts,
}

/// Lines that were left out, or read in another way than some readers do.
#[derive(Debug, Default)]
pub(crate) struct Oddities {
    pub positions: FirstAndCount,
    pub normals: FirstAndCount,
    pub texcoords: FirstAndCount,
    /// Indices of normals and texture coordinates that mean none.
    pub lost_normals: FirstAndCount,
    pub lost_texcoords: FirstAndCount,
    pub early_faces: FirstAndCount,
    pub thin_faces: FirstAndCount,
    pub nameless: FirstAndCount,
    pub kept_apart: FirstAndCount,
}

impl Oddities {
    /// One warning for each kind.
    pub fn warn(&self, scene: &mut Scene) {
        for (tally, what) in [
            (&self.positions, "vertices with a coordinate or weight that is not usable"),
            (&self.normals, "invalid normals: their faces are flat"),
            (&self.texcoords, "invalid texture coordinates: their faces have the plain colour"),
            (&self.lost_normals, "invalid indices of normals: their faces are flat"),
            (&self.lost_texcoords, "invalid indices of texture coordinates"),
            (&self.early_faces, "faces before their vertices: indices count from the file's start"),
            (&self.thin_faces, "faces with fewer than 3 corners left out"),
            (&self.nameless, "usemtl or mtllib without a name"),
            (&self.kept_apart, "comments or names that end in `\\`: they end with their line"),
        ] {
            tally.warn(what, scene);
        }
    }
}

/// Place of a face, its number of corners, and whether all of them have normals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceLine {
    pub line: u32,
    pub corners: u32,
    pub smooth: bool,
}

/// Corner lists that a file can fill.
#[derive(Clone, Copy)]
pub(super) struct CornerLists {
    pub normals: bool,
    pub texcoords: bool,
}

/// One more than the largest index of each kind that a face has.
#[derive(Debug, Default)]
pub(super) struct IndexCounts {
    pub positions: usize,
    pub texcoords: usize,
    pub normals: usize,
}
