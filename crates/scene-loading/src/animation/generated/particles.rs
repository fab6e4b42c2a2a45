//! `particles`: small tetrahedra that drift in a flow, each on its own.
//!
//! The flow is Arnold's, Beltrami's and Childress' (ABC): its curl is along the velocity
//! everywhere, and it neither gathers nor thins what drifts in it. T. Dombre et al., "Chaotic
//! streamlines in the ABC flows", Journal of Fluid Mechanics 167, 1986. Steps of 10 ms by the
//! midpoint rule.

use glam::DVec3;

use crate::animation::generated::stage::{self, Frames, Replay};
use crate::procedural::parts::{Z_UP, matte, stage, view};

/// Steps of a frame, and their length in seconds.
const STEPS: u32 = 4;
const STEP: f64 = 0.01;

/// Four triangles a tetrahedron.
pub(super) fn count(size: u32) -> u64 {
    4 * u64::from(size).pow(3)
}

/// Corners of a tetrahedron, and its faces.
const CORNERS: [DVec3; 4] = [
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, -1.0, -1.0),
    DVec3::new(-1.0, 1.0, -1.0),
    DVec3::new(-1.0, -1.0, 1.0),
];
const FACES: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];

pub(super) fn frames(size: u32) -> Frames {
    let view = view([2.4, -3.6, 1.9], [0.0; 3], Z_UP, 45.0, 0.0);
    let mut still = stage(view, &[[3.0, -4.0, 5.0], [-4.0, -1.0, 2.0]]);
    let kinds = [[0.85, 0.5, 0.15], [0.2, 0.5, 0.8], [0.8, 0.8, 0.75]];
    let kinds = kinds.map(|color| still.push_material(matte(color)));
    let half = 0.25 / f64::from(size);
    let mut drift = Replay::new(start(size));
    Box::new(move |frame| {
        let particles = drift.after(frame, |all| {
            for _ in 0..STEPS {
                all.iter_mut().for_each(|p| *p += STEP * flow(*p + 0.5 * STEP * flow(*p)));
            }
        });
        let mut scene = still.clone();
        scene.vertices.reserve_exact(4 * particles.len());
        scene.primitives.reserve_exact(4 * particles.len());
        for (i, &p) in particles.iter().enumerate() {
            scene.push_mesh(kinds[i % kinds.len()], CORNERS.map(|corner| p + half * corner), FACES);
        }
        scene
    })
}

/// `size` cubed places in a cube from -1 to 1.
fn start(size: u32) -> Vec<DVec3> {
    let n = u64::from(size);
    let place = |i: u64| {
        let cell = [i % n, i / n % n, i / n / n].map(|k| k as f64 + 0.5);
        (DVec3::from_array(cell) + 0.4 * stage::vector(i, 0)) * (2.0 / n as f64) - DVec3::ONE
    };
    (0..n * n * n).map(place).collect()
}

/// Velocity at a point, units per second.
fn flow(p: DVec3) -> DVec3 {
    let [x, y, z] = (2.5 * p).to_array();
    let [a, b, c] = [0.36, 0.3, 0.16];
    DVec3::new(a * z.sin() + c * y.cos(), b * x.sin() + a * z.cos(), c * y.sin() + b * x.cos())
}
