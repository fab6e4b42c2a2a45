//! `teapot`: Newell's teapot in triangular patches with normals, on a checkerboard.
//!
//! Figures and order: `teapot.c` of SPD 3.14. A patch in power form is `[s^3 s^2 s 1] M G M^T [t^3
//! t^2 t 1]^T` with the Bézier basis `M`, which is symmetric (J. D. Foley et al., "Computer Graphics:
//! Principles and Practice", 1990, section 11.3).
//!
//! Control points of 32 bicubic Bézier patches: M. Newell's teapot (University of Utah, 1975) with
//! the bottom that F. Crow added, as listed in F. Crow, "The Origins of the Teapot", IEEE CG&A 7(1),
//! January 1987; in the order of `teapot.c` in E. Haines' Standard Procedural Databases 3.14 (public
//! domain, CC0; <https://github.com/erich666/StandardProceduralDatabases>), which is that of the
//! output. The table has one patch of each set that a symmetry maps onto each other.

use glam::{DMat4, DVec3, DVec4};

use self::Symmetry::{Mirror, Turns, TurnsBack};
use super::parts::{Z_UP, glossy, stage, view};
use crate::scene::Scene;

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
    for (symmetry, patch) in &PATCHES {
        for image in images(*symmetry, patch) {
            push_patch(&mut scene, material, size, &PowerForm::new(&image));
        }
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
                    scene.push_corners(material, v, Some(corners.map(|i| first_n + i)));
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
    fn new(patch: &Patch) -> Self {
        Self(std::array::from_fn(|axis| {
            let control = patch.map(|row| row.map(|point| point[axis]));
            BEZIER * (DMat4::from_cols_array_2d(&control) * BEZIER)
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

/// The control points of a patch, row by row (a row is the first parameter `s` held fixed), z up.
type Patch = [[[f64; 3]; 4]; 4];

/// What maps a patch onto the next ones of its part, about the pot's axis or its middle plane.
#[derive(Clone, Copy)]
enum Symmetry {
    /// Three quarter turns, clockwise as seen from above.
    Turns,
    /// The same the other way round.
    TurnsBack,
    /// The mirror image at y = 0, with the columns in the reverse order.
    Mirror,
}

/// The patch and its images, in the order of the output. None has a negative zero.
fn images(symmetry: Symmetry, patch: &Patch) -> impl Iterator<Item = Patch> {
    let next = move |patch: &Patch| match symmetry {
        Turns => patch.map(|row| row.map(|[x, y, z]| [y, 0.0 - x, z])),
        TurnsBack => patch.map(|row| row.map(|[x, y, z]| [0.0 - y, x, z])),
        Mirror => patch.map(|[a, b, c, d]| [d, c, b, a].map(|[x, y, z]| [x, 0.0 - y, z])),
    };
    let count = if matches!(symmetry, Mirror) { 2 } else { 4 };
    std::iter::successors(Some(*patch), move |patch| Some(next(patch))).take(count)
}

/// One patch of each set, in the teapot's own units (the pot is 3.15 high).
#[rustfmt::skip]
const PATCHES: [(Symmetry, Patch); 10] = [
    // rim
    (Turns, [[[1.4, 0.0, 2.4], [1.4, -0.784, 2.4], [0.784, -1.4, 2.4], [0.0, -1.4, 2.4]],
        [[1.3375, 0.0, 2.53125], [1.3375, -0.749, 2.53125], [0.749, -1.3375, 2.53125], [0.0, -1.3375, 2.53125]],
        [[1.4375, 0.0, 2.53125], [1.4375, -0.805, 2.53125], [0.805, -1.4375, 2.53125], [0.0, -1.4375, 2.53125]],
        [[1.5, 0.0, 2.4], [1.5, -0.84, 2.4], [0.84, -1.5, 2.4], [0.0, -1.5, 2.4]]]),
    // body
    (Turns, [[[1.5, 0.0, 2.4], [1.5, -0.84, 2.4], [0.84, -1.5, 2.4], [0.0, -1.5, 2.4]],
        [[1.75, 0.0, 1.875], [1.75, -0.98, 1.875], [0.98, -1.75, 1.875], [0.0, -1.75, 1.875]],
        [[2.0, 0.0, 1.35], [2.0, -1.12, 1.35], [1.12, -2.0, 1.35], [0.0, -2.0, 1.35]],
        [[2.0, 0.0, 0.9], [2.0, -1.12, 0.9], [1.12, -2.0, 0.9], [0.0, -2.0, 0.9]]]),
    (Turns, [[[2.0, 0.0, 0.9], [2.0, -1.12, 0.9], [1.12, -2.0, 0.9], [0.0, -2.0, 0.9]],
        [[2.0, 0.0, 0.45], [2.0, -1.12, 0.45], [1.12, -2.0, 0.45], [0.0, -2.0, 0.45]],
        [[1.5, 0.0, 0.225], [1.5, -0.84, 0.225], [0.84, -1.5, 0.225], [0.0, -1.5, 0.225]],
        [[1.5, 0.0, 0.15], [1.5, -0.84, 0.15], [0.84, -1.5, 0.15], [0.0, -1.5, 0.15]]]),
    // handle
    (Mirror, [[[-1.6, 0.0, 2.025], [-1.6, -0.3, 2.025], [-1.5, -0.3, 2.25], [-1.5, 0.0, 2.25]],
        [[-2.3, 0.0, 2.025], [-2.3, -0.3, 2.025], [-2.5, -0.3, 2.25], [-2.5, 0.0, 2.25]],
        [[-2.7, 0.0, 2.025], [-2.7, -0.3, 2.025], [-3.0, -0.3, 2.25], [-3.0, 0.0, 2.25]],
        [[-2.7, 0.0, 1.8], [-2.7, -0.3, 1.8], [-3.0, -0.3, 1.8], [-3.0, 0.0, 1.8]]]),
    (Mirror, [[[-2.7, 0.0, 1.8], [-2.7, -0.3, 1.8], [-3.0, -0.3, 1.8], [-3.0, 0.0, 1.8]],
        [[-2.7, 0.0, 1.575], [-2.7, -0.3, 1.575], [-3.0, -0.3, 1.35], [-3.0, 0.0, 1.35]],
        [[-2.5, 0.0, 1.125], [-2.5, -0.3, 1.125], [-2.65, -0.3, 0.9375], [-2.65, 0.0, 0.9375]],
        [[-2.0, 0.0, 0.9], [-2.0, -0.3, 0.9], [-1.9, -0.3, 0.6], [-1.9, 0.0, 0.6]]]),
    // spout
    (Mirror, [[[1.7, 0.0, 1.425], [1.7, -0.66, 1.425], [1.7, -0.66, 0.6], [1.7, 0.0, 0.6]],
        [[2.6, 0.0, 1.425], [2.6, -0.66, 1.425], [3.1, -0.66, 0.825], [3.1, 0.0, 0.825]],
        [[2.3, 0.0, 2.1], [2.3, -0.25, 2.1], [2.4, -0.25, 2.025], [2.4, 0.0, 2.025]],
        [[2.7, 0.0, 2.4], [2.7, -0.25, 2.4], [3.3, -0.25, 2.4], [3.3, 0.0, 2.4]]]),
    (Mirror, [[[2.7, 0.0, 2.4], [2.7, -0.25, 2.4], [3.3, -0.25, 2.4], [3.3, 0.0, 2.4]],
        [[2.8, 0.0, 2.475], [2.8, -0.25, 2.475], [3.525, -0.25, 2.49375], [3.525, 0.0, 2.49375]],
        [[2.9, 0.0, 2.475], [2.9, -0.15, 2.475], [3.45, -0.15, 2.5125], [3.45, 0.0, 2.5125]],
        [[2.8, 0.0, 2.4], [2.8, -0.15, 2.4], [3.2, -0.15, 2.4], [3.2, 0.0, 2.4]]]),
    // lid
    (Turns, [[[0.0, 0.0, 3.15], [0.0, 0.0, 3.15], [0.0, 0.0, 3.15], [0.0, 0.0, 3.15]],
        [[0.8, 0.0, 3.15], [0.8, -0.45, 3.15], [0.45, -0.8, 3.15], [0.0, -0.8, 3.15]],
        [[0.0, 0.0, 2.85], [0.0, 0.0, 2.85], [0.0, 0.0, 2.85], [0.0, 0.0, 2.85]],
        [[0.2, 0.0, 2.7], [0.2, -0.112, 2.7], [0.112, -0.2, 2.7], [0.0, -0.2, 2.7]]]),
    (Turns, [[[0.2, 0.0, 2.7], [0.2, -0.112, 2.7], [0.112, -0.2, 2.7], [0.0, -0.2, 2.7]],
        [[0.4, 0.0, 2.55], [0.4, -0.224, 2.55], [0.224, -0.4, 2.55], [0.0, -0.4, 2.55]],
        [[1.3, 0.0, 2.55], [1.3, -0.728, 2.55], [0.728, -1.3, 2.55], [0.0, -1.3, 2.55]],
        [[1.3, 0.0, 2.4], [1.3, -0.728, 2.4], [0.728, -1.3, 2.4], [0.0, -1.3, 2.4]]]),
    // bottom
    (TurnsBack, [[[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        [[1.425, 0.0, 0.0], [1.425, 0.798, 0.0], [0.798, 1.425, 0.0], [0.0, 1.425, 0.0]],
        [[1.5, 0.0, 0.075], [1.5, 0.84, 0.075], [0.84, 1.5, 0.075], [0.0, 1.5, 0.075]],
        [[1.5, 0.0, 0.15], [1.5, 0.84, 0.15], [0.84, 1.5, 0.15], [0.0, 1.5, 0.15]]]),
];
