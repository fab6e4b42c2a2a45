//! The primitives of a scene.

use glam::DVec3;

/// Texture coordinates of the three corners of a triangle.
pub type Texcoords = [[f32; 2]; 3];

/// One primitive: its shape and the material it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primitive {
    pub shape: Shape,
    pub material: u32,
}

/// Geometry of a primitive: indices into the scene's arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    Sphere(u32),
    Cone(u32),
    /// A planar polygon, concave ones too: `count` vertices from `first` in `Scene::vertices`.
    Polygon {
        first: u32,
        /// Number of vertices, at least 3.
        count: u32,
    },
    /// A flat triangle: three indices into `Scene::vertices`.
    Triangle {
        v: [u32; 3],
    },
    /// A triangle with a shading normal at each vertex.
    Patch {
        /// Vertex indices into `Scene::vertices`.
        v: [u32; 3],
        /// Normal indices into `Scene::normals`.
        n: [u32; 3],
    },
}

/// A sphere; world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    pub center: DVec3,
    pub radius: f64,
}

/// A truncated cone without caps; a cylinder when the radii are equal.
///
/// As in NFF, it is one-sided: positive radii show the outside, negative radii the inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Centre of the base disc.
    pub base: DVec3,
    /// Radius at the base.
    pub base_radius: f64,
    /// Centre of the apex disc.
    pub apex: DVec3,
    /// Radius at the apex.
    pub apex_radius: f64,
}
