//! Numbers of shapes that generators make at a size, without making them.
//!
//! The formulas follow from how each generator recurses; a test compares them with what is
//! generated.

/// Shapes by kind, as far as counts of triangles depend on it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ShapeCounts {
    pub spheres: u64,
    /// Cones and cylinders, none of which has a tip.
    pub cones: u64,
    /// Polygons, triangles and patches.
    pub flat: u64,
    /// Triangles that those are cut into.
    pub flat_triangles: u64,
}

impl ShapeCounts {
    /// Primitives of the scene as generated.
    pub fn primitives(self) -> u64 {
        self.spheres + self.cones + self.flat
    }

    /// Triangles of the scene once it is tessellated, see [`crate::tessellate`]; with a number too
    /// large for that, the largest there is.
    pub fn tessellated(self, resolution: u32) -> u64 {
        let n = u64::from(resolution);
        let of_spheres = self.spheres.saturating_mul(n.saturating_mul(n).saturating_mul(12));
        of_spheres
            .saturating_add(self.cones.saturating_mul(8 * n))
            .saturating_add(self.flat_triangles)
    }
}

fn triangles(n: u64) -> ShapeCounts {
    ShapeCounts { flat: n, flat_triangles: n, ..ShapeCounts::default() }
}

/// One square, as the ground or the wall.
const SQUARE: ShapeCounts = ShapeCounts { spheres: 0, cones: 0, flat: 1, flat_triangles: 2 };

/// Nine children a sphere.
pub(super) fn balls(size: u32) -> ShapeCounts {
    ShapeCounts { spheres: (9_u64.pow(size + 1) - 1) / 8, ..SQUARE }
}

/// A gear has two faces of 144 vertices and 144 squares between them.
pub(crate) fn gears(size: u32) -> ShapeCounts {
    let gears = u64::from(size).pow(3);
    let (flat, flat_triangles) = (146 * gears + 1, (2 * 142 + 2 * 144) * gears + 2);
    ShapeCounts { flat, flat_triangles, ..ShapeCounts::default() }
}

/// A sphere at each node, a cylinder along each edge.
pub(super) fn lattice(size: u32) -> ShapeCounts {
    let n = u64::from(size);
    let (spheres, cones) = ((n + 1).pow(3), 3 * n * (n + 1).pow(2));
    ShapeCounts { spheres, cones, ..ShapeCounts::default() }
}

/// Two triangles a square, four spheres.
pub(super) fn mount(size: u32) -> ShapeCounts {
    ShapeCounts { spheres: 4, ..triangles(2 * 4_u64.pow(size)) }
}

/// Six rings of five in each of the squared clusters of a layer.
pub(super) fn rings(size: u32) -> ShapeCounts {
    let n = u64::from(size);
    let each = 5 * n * (n + 1) * (2 * n + 1);
    ShapeCounts { spheres: each, cones: each, ..SQUARE }
}

/// 32 patches, of which eight lose a row of triangles at their tips; the board.
pub(super) fn teapot(size: u32) -> ShapeCounts {
    let n = u64::from(size);
    let patches = 64 * n * n - 8 * n;
    let (flat, flat_triangles) = (patches + n * n, patches + 2 * n * n);
    ShapeCounts { flat, flat_triangles, ..ShapeCounts::default() }
}

/// Four pyramids a pyramid.
pub(super) fn tetra(size: u32) -> ShapeCounts {
    triangles(4_u64.pow(size))
}

/// Two branches a branch, a sphere at the end of each.
pub(super) fn tree(size: u32) -> ShapeCounts {
    let branches = (1 << (size + 1)) - 1;
    ShapeCounts { spheres: branches, cones: branches, ..SQUARE }
}

/// Eight faces of n squared triangles.
pub(super) fn hare(size: u32) -> ShapeCounts {
    triangles(8 * u64::from(size).pow(2))
}

/// The hare, eight triangles of grass, 28 rows of 141 risers and treads.
pub(super) fn stadium(size: u32) -> ShapeCounts {
    triangles(8 * u64::from(size).pow(2) + 8 + 28 * 141 * 4)
}

/// Sticks of twelve triangles.
pub(super) fn sticks(size: u32) -> ShapeCounts {
    triangles(12 * u64::from(size).pow(2))
}

#[cfg(test)]
mod tests {
    use crate::procedural::generators;
    use crate::scene::Shape;
    use crate::tessellate::{TessellationOptions, tessellate};

    #[test]
    fn generated_scenes_have_the_predicted_counts() {
        for family in generators() {
            for size in 1..=4 {
                let counts = (family.count)(size);
                let scene = (family.generate)(size);
                let [mut spheres, mut cones] = [0; 2];
                for primitive in &scene.primitives {
                    spheres += u64::from(matches!(primitive.shape, Shape::Sphere(_)));
                    cones += u64::from(matches!(primitive.shape, Shape::Cone(_)));
                }
                let found = [spheres, cones, scene.primitives.len() as u64];
                let expected = [counts.spheres, counts.cones, counts.primitives()];
                assert_eq!(found, expected, "{}:{size}", family.name);
                if size == 2 {
                    let flat = tessellate(&scene, &TessellationOptions { resolution: 2 }).unwrap();
                    let found = flat.primitives.len() as u64;
                    assert_eq!(found, counts.tessellated(2), "{}:{size}", family.name);
                }
            }
            // the largest is within the limit that the table promises
            let most = (family.count)(family.max_size).primitives();
            assert!((4_000_000..22_000_000).contains(&most), "{}: {most}", family.name);
        }
    }
}
