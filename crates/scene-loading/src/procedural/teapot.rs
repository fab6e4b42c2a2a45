//! `teapot`: Newell's teapot in triangular patches with normals, on a checkerboard.
//!
//! Figures and order: `teapot.c` of SPD 3.14; the control points are in [`super::teapot_patches`].
//! A patch in power form is `[s^3 s^2 s 1] M G M^T [t^3 t^2 t 1]^T` with the Bézier basis `M`,
//! which is symmetric (J. D. Foley et al., "Computer Graphics: Principles and Practice", 1990,
//! section 11.3).

use glam::{DMat4, DVec3, DVec4};

use super::parts::{Z_UP, glossy, stage, view};
use super::teapot_patches::{CONTROL_POINTS, PATCHES};
use crate::scene::{Primitive, Scene, Shape};

/// The cubic Bézier basis in power form.
const BEZIER: DMat4 = DMat4::from_cols(
    DVec4::new(-1.0, 3.0, -3.0, 1.0),
    DVec4::new(3.0, -6.0, 3.0, 0.0),
    DVec4::new(-3.0, 3.0, 0.0, 0.0),
    DVec4::new(1.0, 0.0, 0.0, 0.0),
);

/// Points so close to the pot's axis are at the tip of the lid or the middle of the bottom, where
/// the parametrisation is singular.
const ON_AXIS: f64 = 0.0001;

/// Generates the pot with `size` by `size` quadrilaterals per patch and as many squares of board.
pub(super) fn generate(size: u32) -> Scene {
    let view = view([4.86, 7.2, 5.4], [0.0; 3], Z_UP, 45.0, 1.0);
    let mut scene = stage(view, &[[-3.1, 9.8, 12.1], [11.3, 5.1, 8.8]]);
    for (color, odd) in [(1.0, 1), (0.5, 0)] {
        let material = scene.push_material(glossy([color; 3], 0.5, 0.5, 30.0));
        push_squares(&mut scene, material, size, odd);
    }
    let material = scene.push_material(glossy([1.0, 0.5, 0.1], 0.75, 0.25, 37.0));
    for patch in &PATCHES {
        push_patch(&mut scene, material, size, &PowerForm::new(patch));
    }
    scene
}

/// Adds the squares of the board for which column plus row is odd (`odd` = 1) or even (0).
fn push_squares(scene: &mut Scene, material: u32, size: u32, odd: u32) {
    let at = |i: u32| 4.0 * (2.0 * f64::from(i) / f64::from(size) - 1.0);
    for x in 0..size {
        for y in (0..size).filter(|y| (x + y) % 2 == odd) {
            let square = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
                .map(|(x, y)| DVec3::new(at(x), at(y), 0.0));
            scene.push_polygon(material, &square);
        }
    }
}

/// Adds the triangles of one patch, which share its grid of vertices and normals. Triangles with
/// two corners on the pot's axis are degenerate and left out.
fn push_patch(scene: &mut Scene, material: u32, size: u32, form: &PowerForm) {
    let first_v = scene.vertices.len() as u32;
    let first_n = scene.normals.len() as u32;
    let step = |i: u32| f64::from(i) / f64::from(size);
    for s in 0..=size {
        for t in 0..=size {
            let (point, normal) = form.evaluate(step(s), step(t));
            scene.vertices.push(point);
            scene.normals.push(normal);
        }
    }
    for s in 0..size {
        for t in 0..size {
            let here = s * (size + 1) + t;
            let across = here + size + 1;
            for corners in [[here, here + 1, across + 1], [across + 1, across, here]] {
                let v = corners.map(|i| first_v + i);
                if v.iter().filter(|&&i| is_on_axis(scene.vertices[i as usize])).count() < 2 {
                    let shape = Shape::Patch { v, n: corners.map(|i| first_n + i) };
                    scene.primitives.push(Primitive { shape, material });
                }
            }
        }
    }
}

fn is_on_axis(p: DVec3) -> bool {
    p.x.abs() <= ON_AXIS && p.y.abs() <= ON_AXIS
}

/// `M G M^T` of a patch, for each of x, y and z.
struct PowerForm([DMat4; 3]);

impl PowerForm {
    fn new(patch: &[usize; 16]) -> Self {
        Self(std::array::from_fn(|axis| {
            let control = DMat4::from_cols_array(&patch.map(|i| CONTROL_POINTS[i][axis]));
            BEZIER * (control * BEZIER)
        }))
    }

    /// Position and unit normal at `(s, t)`.
    fn evaluate(&self, s: f64, t: f64) -> (DVec3, DVec3) {
        let (s, ds) = powers(s);
        let (t, dt) = powers(t);
        let form = |s: DVec4, t: DVec4| DVec3::from_array(self.0.map(|m| (m * s).dot(t)));
        let point = form(s, t);
        if is_on_axis(point) {
            // Tip of the lid or middle of the bottom.
            return (point, if point.z > 1.5 { DVec3::Z } else { DVec3::NEG_Z });
        }
        let normal = form(s, dt).cross(form(ds, t));
        let length = normal.length();
        (point, if length > 0.0 { normal / length } else { normal })
    }
}

/// The powers of `x` from the third to the zeroth, and their derivatives.
fn powers(x: f64) -> (DVec4, DVec4) {
    let square = x * x;
    (DVec4::new(square * x, square, x, 1.0), DVec4::new(square * 3.0, x * 2.0, 1.0, 0.0))
}
