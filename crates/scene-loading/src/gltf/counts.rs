//! What of a glTF scene is left out, counted for warnings.

/// How many of each kind.
#[derive(Debug, Default)]
pub(super) struct Counts {
    pub without_area: usize,
    pub points_and_lines: usize,
    pub empty: usize,
    pub without_positions: usize,
    pub incomplete: usize,
    pub hidden: usize,
    pub unused_vertices: usize,
    pub normals: usize,
    pub texcoords: usize,
    pub coloured: usize,
}

impl Counts {
    /// A text for each kind of which there is any.
    pub fn warnings(&self) -> impl Iterator<Item = String> + use<> {
        [
            (self.without_area, "triangles without area left out"),
            (self.points_and_lines, "meshes of points or lines left out"),
            (self.empty, "primitives without a triangle left out"),
            (self.without_positions, "primitives without positions left out"),
            (self.incomplete, "primitives whose last triangle lacks corners, which is left out"),
            (self.hidden, "meshes that are scaled to nothing or not visible left out"),
            (self.unused_vertices, "vertices are not finite; no triangle uses them"),
            (self.normals, "normals that are not finite left out"),
            (self.texcoords, "texture coordinates that are not finite are taken as 0"),
            (self.coloured, "primitives with vertex colours (COLOR_0), which are not shown"),
        ]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"))
    }
}
