//! The direction cube: which face of it a direction meets, and where.
//!
//! A face is named by its axis and sign. On it, a direction with components (x, y, z), z along
//! the axis, is at (u, v) = (x / z, y / z), both in [-1, 1]; its depth is z. Depths along a
//! direction order as distances do and need no square root. A direction on an edge of the cube
//! belongs to either face.

use glam::DVec3;

use crate::geometry::far_ray;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::occluders::light_buffer::face_tree::Face;
use crate::occluders::light_buffer::margins::Margins;
use crate::primitives::Primitives;

/// Faces of a cube.
pub(super) const FACES: usize = 6;

/// Point at which a direction meets the cube.
#[derive(Debug, Clone, Copy)]
pub(super) struct CubePoint<S> {
    pub(super) face: usize,
    pub(super) at: [S; 2],
    /// Length along the axis of the face.
    pub(super) depth: S,
}

/// A light and what it sees.
pub(super) struct Cube<S: Scalar> {
    pub(super) position: Vec3<S>,
    pub(super) faces: [Face<S>; FACES],
}

/// The cubes of all lights, for rays that run from the scene to one of them.
pub(super) struct Cubes<S: Scalar> {
    pub(super) all: Vec<Cube<S>>,
    /// Largest distance on an axis from the end of a ray to its light.
    end: S,
    reach: S,
}

impl<S: Scalar> Cubes<S> {
    pub(super) fn new(prims: &dyn Primitives<S>, margins: &Margins) -> Self {
        let reach = far_ray::reach(prims.magnitude());
        Self { all: Vec::new(), end: S::from_f64(margins.end), reach }
    }

    /// Point at which a ray, seen from its light, meets a face; `None` if the buffer has no answer
    /// for it: where it does not run to the light.
    #[inline(always)]
    pub(super) fn place(&self, ray: &Ray<S>, light: u32) -> Option<(CubePoint<S>, &Face<S>)> {
        let cube = self.all.get(light as usize)?;
        let from_light = ray.origin - cube.position;
        let place = place(from_light);
        // NaN fails every one of these
        let is_aimed = is_within::<S>(from_light + ray.direction * ray.t_max, self.end)
            & is_within::<S>(ray.origin, self.reach)
            & (place.depth > self.end * S::from_f64(4.0))
            & (ray.t_min >= S::ZERO);
        if is_aimed { Some((place, cube.faces.get(place.face)?)) } else { None }
    }
}

/// Returns whether no component is larger than `limit`; false for NaN.
#[inline(always)]
fn is_within<S: Scalar>(v: Vec3<S>, limit: S) -> bool {
    let [x, y, z] = v.to_array();
    (x.abs() <= limit) & (y.abs() <= limit) & (z.abs() <= limit)
}

/// Point at which `v` meets the cube; u and v are NaN for a zero vector.
#[inline(always)]
pub(super) fn place<S: Scalar>(v: Vec3<S>) -> CubePoint<S> {
    let [x, y, z] = v.to_array();
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let (axis, along, across) = if ax >= ay && ax >= az {
        (0, x, [y, z])
    } else if ay >= az {
        (1, y, [z, x])
    } else {
        (2, z, [x, y])
    };
    let depth = along.abs();
    let inverse = S::ONE / depth;
    let face = axis * 2 + usize::from(along < S::ZERO);
    CubePoint { face, at: [across[0] * inverse, across[1] * inverse], depth }
}

/// `v` in the frame of a face: x and y along u and v, z along the axis.
pub(super) fn in_frame(face: usize, v: DVec3) -> DVec3 {
    let sign = if face % 2 == 1 { -1.0 } else { 1.0 };
    match face / 2 {
        0 => DVec3::new(v.y, v.z, v.x * sign),
        1 => DVec3::new(v.z, v.x, v.y * sign),
        _ => DVec3::new(v.x, v.y, v.z * sign),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_lookups_find_the_same_face() {
        // HARD_CASES Gr11: diagonals of the cube among them
        let values = [-1.0, -0.5, -0.0, 0.0, 0.25, 1.0];
        let mut faces = [0; FACES];
        for x in values {
            for y in values {
                for z in values {
                    let v = DVec3::new(x, y, z);
                    if v == DVec3::ZERO {
                        assert!(place::<f64>(v).at[0].is_nan());
                        continue;
                    }
                    let p = place::<f64>(v);
                    let local = in_frame(p.face, v);
                    assert_eq!(p.depth, local.z, "{v}");
                    assert_eq!(p.at, [local.x / local.z, local.y / local.z], "{v}");
                    assert!(p.at.iter().all(|c| c.abs() <= 1.0), "{v}");
                    faces[p.face] += 1;
                }
            }
        }
        assert!(faces.iter().all(|&n| n > 10), "{faces:?}");
    }
}
