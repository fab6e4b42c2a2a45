//! Vectors of files, and how normals are transformed.

use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3};

/// Matrix that transforms normals: the cofactors, which keep their orientation under mirroring.
pub(crate) fn cofactor(world: DMat4) -> DMat3 {
    let m = DMat3::from_mat4(world);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
        * sign
}

/// A vector of a file.
pub(crate) fn wide(v: &[f32; 3]) -> DVec3 {
    Vec3::from_array(*v).as_dvec3()
}

/// A matrix with the last row 0, 0, 0, 1.
pub(crate) fn affine(matrix: DMat4) -> DMat4 {
    DAffine3::from_mat4(matrix).into()
}
