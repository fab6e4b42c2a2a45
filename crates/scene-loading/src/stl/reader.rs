//! The scene that an STL file becomes, triangle by triangle.

use std::path::Path;

use glam::DVec3;

use crate::error::{FilePlace, LoadError};
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::{FaceCounts, Mesh, Welder, is_usable};
use crate::scene::{Scene, Warning};

pub(super) struct Reader<'a> {
    pub path: &'a Path,
    pub mesh: Mesh,
    pub scene: Scene,
    pub welder: Welder,
    pub counts: FaceCounts,
}

impl Reader<'_> {
    pub fn add(
        &mut self,
        corners: [[f64; 3]; 3],
        place: impl Fn() -> FilePlace,
    ) -> Result<(), LoadError> {
        let size = self.scene.vertices.len().max(self.scene.primitives.len()) + 3;
        limits::check(size, MAX_ELEMENTS, "the number of vertices or triangles", &place)?;
        if !corners.as_flattened().iter().all(|&value| is_usable(value)) {
            self.counts.unusable(place);
            return Ok(());
        }
        let corners = corners.map(DVec3::from_array);
        let corners = corners.map(|corner| self.welder.vertex(corner, &mut self.scene));
        self.mesh.add(&corners, &mut self.scene, &mut self.counts, place)
    }

    pub fn warn(&mut self, text: String) {
        self.scene.warnings.push(Warning(format!("{}: {text}", self.path.display())));
    }
}
