//! Triangles as vertices and indices, for plugins that ask for them.

use std::collections::HashMap;

/// Vertices, each once, and three of them for each triangle.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct IndexedMesh {
    pub(crate) vertices: Vec<[f32; 3]>,
    pub(crate) indices: Vec<[u32; 3]>,
}

impl IndexedMesh {
    /// Vertices that agree in all bits are one; in the order in which triangles have them first.
    pub(crate) fn of(triangles: &[[[f32; 3]; 3]]) -> Self {
        let mut places: HashMap<[u32; 3], u32> = HashMap::with_capacity(triangles.len());
        let mut vertices = Vec::new();
        let mut index = |corner: &[f32; 3]| {
            *places.entry(corner.map(f32::to_bits)).or_insert_with(|| {
                vertices.push(*corner);
                (vertices.len() - 1) as u32
            })
        };
        let indices = triangles.iter().map(|[a, b, c]| [index(a), index(b), index(c)]).collect();
        Self { vertices, indices }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_vertices_are_one() {
        let [a, b, c, d] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0]];
        let both = IndexedMesh::of(&[[a, b, c], [c, b, d]]);
        // zeros of both signs are two
        assert_eq!(both.vertices.len(), 4);
        assert_eq!(both.indices, [[0, 1, 2], [2, 1, 3]]);
    }
}
