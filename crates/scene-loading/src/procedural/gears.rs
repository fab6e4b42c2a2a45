//! `gears`: a cube of meshing gears above a reflecting ground, some of them of glass.
//!
//! Figures and order: `gears.c` of SPD 3.14.

use std::f64::consts::PI;

use glam::DVec3;

use super::parts::{Z_UP, glossy, ground, matte, stage, view};
use crate::scene::{Material, Rgb, Scene};

pub(crate) const TEETH: usize = 36;

/// Vertices of a gear's face.
const FACE: usize = 4 * TEETH;

/// Tip circle, in units of the pitch; below 1, so that meshing gears leave a gap.
const TIP: f64 = 0.995;

/// How far the root circle is within the pitch.
const TOOTH_HEIGHT: f64 = 1.0 - 0.9;

/// Root circle, in units of the pitch.
const ROOT: f64 = 1.0 - TOOTH_HEIGHT;

/// Corners of one tooth: on the tip circle or the root circle, at that share of the tooth's angle.
const TOOTH: [(f64, f64); 4] = [(TIP, -0.19), (TIP, 0.19), (ROOT, 0.3), (ROOT, 0.7)];

/// A gear's shape, the same for all gears of a scene.
struct Profile {
    pitch: f64,
    thickness: f64,
}

/// A gear of a scene.
pub(crate) struct Gear {
    pub material: Material,
    /// The middle of its upper face.
    pub center: DVec3,
    /// True if it is turned by half a tooth, as those that it meshes with are not.
    pub is_turned: bool,
}

impl Profile {
    /// Profile of the gears of a scene of this size.
    fn of(size: u32) -> Self {
        Self { pitch: pitch(size), thickness: (1.0 / (2.0 * f64::from(size))).min(0.1) }
    }
}

/// Radius of the pitch circle.
fn pitch(size: u32) -> f64 {
    let n = f64::from(size);
    1.0 / (n - (n - 1.0) * TOOTH_HEIGHT / 2.0)
}

/// Generates `size` cubed gears.
pub(super) fn generate(size: u32) -> Scene {
    let mut scene = empty();
    let floor = scene.push_material(floor());
    scene.push_polygon(floor, &ground(2.0, 0.0));
    let profile = Profile::of(size);
    for Gear { material, center, is_turned } in gears(size) {
        let material = scene.push_material(material);
        push_gear(&mut scene, material, &profile, center, turn(is_turned));
    }
    scene
}

/// The scene without anything in it.
pub(crate) fn empty() -> Scene {
    let view = view([-1.1, -2.1, 2.6], [0.0; 3], Z_UP, 45.0, 1.0);
    #[rustfmt::skip]
    let lights = [
        [2.0, 4.0, 4.0], [-2.0, 4.0, 3.0], [2.0, -2.5, 2.5], [-1.0, -4.0, 2.0],
        [-1.111, -2.121, 2.626],
    ];
    stage(view, &lights)
}

/// The surface of the ground.
pub(crate) fn floor() -> Material {
    glossy([1.0, 0.85, 0.7], 0.3, 0.6, 37.0)
}

/// One gear of a scene of that size, its upper face around the origin.
pub(crate) fn one(size: u32) -> Scene {
    let mut scene = Scene::default();
    push_gear(&mut scene, 0, &Profile::of(size), DVec3::ZERO, turn(false));
    scene
}

/// The gears of a scene, in its order.
pub(crate) fn gears(size: u32) -> impl Iterator<Item = Gear> {
    let n = f64::from(size);
    let pitch = pitch(size);
    let first = DVec3::new(-1.0 + pitch, -1.0 + pitch, 1.0);
    let step = DVec3::new(pitch * (2.0 - TOOTH_HEIGHT), pitch * (2.0 - TOOTH_HEIGHT), -1.0 / n);
    let places =
        (0..size).flat_map(move |z| (0..size).flat_map(move |y| (0..size).map(move |x| [x, y, z])));
    places.map(move |[x, y, z]| Gear {
        material: surface(x, y, z),
        center: first + DVec3::new(x.into(), y.into(), z.into()) * step,
        is_turned: (x + y + z) % 2 == 1,
    })
}

/// By how much a gear is turned, radians: half a tooth or nothing.
pub(crate) fn turn(is_turned: bool) -> f64 {
    PI * f64::from(u8::from(is_turned)) / TEETH as f64
}

/// Every fifth gear or so is of coloured glass, the others are matte.
fn surface(x: u32, y: u32, z: u32) -> Material {
    let matte = matte(color(x, y, z));
    if (x * 4 + y * 2 + z).is_multiple_of(5) {
        Material { diffuse: 0.2, transmittance: 0.8, refraction_index: 1.1, ..matte }
    } else {
        matte
    }
}

/// A colour that differs between neighbours; its largest component is 1.
fn color(x: u32, y: u32, z: u32) -> Rgb {
    let mix = |a: u32, b: u32, c: u32, sevenths: f64| {
        0.01 + (f64::from(a * 3 + b * 2 + c + 1) * sevenths / 7.0).fract()
    };
    let color = [mix(x, y, z, 5.0), mix(y, z, x, 3.0), mix(z, x, y, 2.0)];
    let largest = color.into_iter().fold(0.0, f64::max);
    color.map(|c| c / largest)
}

/// Adds the face above, the flanks and the face below of a gear whose upper face is at `center`.
fn push_gear(scene: &mut Scene, material: u32, profile: &Profile, center: DVec3, turn: f64) {
    let top = outline(profile, center, turn, 1.0);
    scene.push_polygon(material, &top);
    let down = DVec3::new(0.0, 0.0, profile.thickness);
    for (i, &here) in top.iter().enumerate() {
        let next = top[(i + 1) % FACE];
        scene.push_polygon(material, &[here, here - down, next - down, next]);
    }
    let below = center + DVec3::new(0.0, 0.0, -profile.thickness);
    scene.push_polygon(material, &outline(profile, below, turn, -1.0));
}

/// The toothed outline around `center`, against the clock for `sense` = 1, with it for -1.
fn outline(profile: &Profile, center: DVec3, turn: f64, sense: f64) -> [DVec3; FACE] {
    let tooth_angle = sense * (2.0 * PI / TEETH as f64);
    std::array::from_fn(|i| {
        let tooth_start = turn + sense * (2.0 * PI * (i / 4) as f64 / TEETH as f64);
        let (circle, share) = TOOTH[i % 4];
        let radius = circle * profile.pitch;
        let (sin, cos) = (tooth_start + share * tooth_angle).sin_cos();
        DVec3::new(radius * cos, radius * sin, 0.0) + center
    })
}
