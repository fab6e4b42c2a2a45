//! Content of AFF files at rest: primitives in the spaces of their braces.

use std::ops::Range;
use std::path::PathBuf;

use glam::{DAffine3, DMat3, DMat4, DVec3};

use crate::aff::motion::{AnimatedPatch, Motions};
use crate::error::{FilePlace, LoadError, NOT_FINITE};
use crate::mesh::cofactor;
use crate::pbrt::state::uniform_scale;
use crate::scene::{Camera, Instance, Light, Scene, Shape};

/// A scene that moves.
#[derive(Default)]
pub(super) struct World {
    pub path: PathBuf,
    /// Materials, background, view; primitives in the spaces of their branches.
    pub rest: Scene,
    /// True if a file says so.
    pub has_view: bool,
    /// Transforms; the first is the world, the others come behind those that they are in.
    pub branches: Vec<Branch>,
    /// Runs of primitives in one branch, in order.
    pub parts: Vec<PrimitiveRange>,
    /// Lights and the branches that they are in.
    pub lights: Vec<(usize, Light)>,
    /// Triangles that are animated corner by corner.
    pub patches: Vec<AnimatedPatch>,
    pub motions: Motions,
    /// First and last second, number of frames.
    pub clip: Option<(f64, f64, u32)>,
}

/// A pair of braces.
pub(super) struct Branch {
    pub parent: usize,
    pub step: Step,
}

/// From the space within the braces to that around them.
pub(super) enum Step {
    Fixed(DAffine3),
    Named(String),
}

pub(super) struct PrimitiveRange {
    pub branch: usize,
    /// The same for runs that several inclusions of a file make.
    pub object: u32,
    pub origin: RunOrigin,
    /// Its corners move by themselves.
    pub is_soft: bool,
    pub primitives: Range<usize>,
    pub vertices: Range<usize>,
    pub normals: Range<usize>,
    pub spheres: Range<usize>,
    pub cones: Range<usize>,
    pub place: FilePlace,
}

/// Where a run of primitives is from: inclusion, file, and run within it.
#[derive(Clone, Copy)]
pub(super) struct RunOrigin {
    pub inclusion: usize,
    pub file: usize,
    pub number: usize,
}

/// Placement of a branch.
#[derive(Clone, Copy)]
struct Placement {
    to_world: DAffine3,
    is_visible: bool,
    /// It keeps its size and sense throughout.
    is_steady: bool,
}

impl World {
    /// The scene at a time.
    ///
    /// # Errors
    /// [`LoadError::OutOfRange`] where a sphere or a cone is scaled by other than one factor,
    /// [`LoadError::NotFinite`] where a place is.
    pub fn at(&self, time: f64) -> Result<Scene, LoadError> {
        let placements = self.placements(time);
        let mut scene = self.rest.clone();
        scene.camera = self.camera(time)?;
        for (branch, light) in &self.lights {
            let to_world = placement(&placements, *branch).to_world;
            let position = to_world.transform_point3(light.position);
            if !position.is_finite() {
                let place = FilePlace::file(&self.path);
                return Err(LoadError::not_finite(place, "the place of a light", NOT_FINITE));
            }
            scene.lights.push(Light::point(position, light.color));
        }
        for patch in &self.patches {
            patch.set(time, &mut scene);
        }
        for part in &self.parts {
            place(part, placement(&placements, part.branch), &mut scene)?;
        }
        Ok(scene)
    }

    fn placements(&self, time: f64) -> Vec<Placement> {
        let mut placements: Vec<Placement> = Vec::with_capacity(self.branches.len());
        for branch in &self.branches {
            let around = placement(&placements, branch.parent);
            let (step, motion) = match &branch.step {
                Step::Fixed(step) => (*step, None),
                Step::Named(name) => {
                    let motion = self.motions.get(name);
                    (motion.map_or(DAffine3::IDENTITY, |motion| motion.at(time)), motion)
                }
            };
            placements.push(Placement {
                to_world: around.to_world * step,
                is_visible: around.is_visible && motion.is_none_or(|m| m.is_visible(time)),
                is_steady: around.is_steady && motion.is_none_or(|m| !m.is_unsteady()),
            });
        }
        placements
    }

    /// The view, which the keys of the name `camera` move: it looks along -z, y is up.
    fn camera(&self, time: f64) -> Result<Camera, LoadError> {
        let mut camera = self.rest.camera;
        let Some(motion) = self.motions.get("camera") else { return Ok(camera) };
        let ahead = camera.at - camera.from;
        if let Some(track) = &motion.translation {
            camera.from = track.at(time);
        }
        camera.at = camera.from + ahead;
        if let Some(track) = &motion.rotation {
            let turn = track.at(time);
            camera.at = camera.from - turn * DVec3::Z * ahead.length();
            camera.up = turn * DVec3::Y;
        }
        camera.check(|| FilePlace::file(&self.path))?;
        Ok(camera)
    }
}

fn placement(all: &[Placement], branch: usize) -> Placement {
    let world = Placement { to_world: DAffine3::IDENTITY, is_visible: true, is_steady: true };
    all.get(branch).copied().unwrap_or(world)
}

/// Brings a part to where it is. What is not seen is drawn together in one point: it keeps its ids.
fn place(part: &PrimitiveRange, placement: Placement, scene: &mut Scene) -> Result<(), LoadError> {
    let mut to_world = placement.to_world;
    if !placement.is_visible {
        to_world.matrix3 = DMat3::ZERO;
    }
    let vertices = scene.vertices.get_mut(part.vertices.clone()).unwrap_or_default();
    vertices.iter_mut().for_each(|v| *v = to_world.transform_point3(*v));
    if !vertices.iter().all(|v| v.is_finite()) {
        let place = part.place.clone();
        return Err(LoadError::not_finite(place, "a place in the world", NOT_FINITE));
    }
    let of_normals = cofactor(DMat4::from(to_world));
    let normals = scene.normals.get_mut(part.normals.clone()).unwrap_or_default();
    normals.iter_mut().for_each(|n| *n = (of_normals * *n).normalize_or_zero());
    if normals.contains(&DVec3::ZERO) {
        flatten(part, scene);
    }
    if !(part.spheres.is_empty() && part.cones.is_empty()) {
        let hidden = (to_world.matrix3 == DMat3::ZERO).then_some(0.0);
        let scale = hidden.or_else(|| uniform_scale(&DMat4::from(to_world))).ok_or_else(|| {
            let (what, expected) = ("the scale of a sphere or cone", "the same in all directions");
            LoadError::out_of_range(part.place.clone(), what, to_world.matrix3, expected)
        })?;
        for sphere in scene.spheres.get_mut(part.spheres.clone()).unwrap_or_default() {
            sphere.center = to_world.transform_point3(sphere.center);
            sphere.radius *= scale;
        }
        for cone in scene.cones.get_mut(part.cones.clone()).unwrap_or_default() {
            cone.base = to_world.transform_point3(cone.base);
            cone.apex = to_world.transform_point3(cone.apex);
            cone.base_radius *= scale;
            cone.apex_radius *= scale;
        }
    }
    if placement.is_steady && !part.is_soft && to_world.matrix3.determinant() != 0.0 {
        // loaders take at most 64 Mi primitives
        let [first, count] = [part.primitives.start, part.primitives.len()].map(|n| n as u32);
        let (object, placement) = (part.object, to_world);
        scene.instances.push(Instance { object, first, count, placement });
    }
    Ok(())
}

/// Makes triangles of patches that lack a normal.
fn flatten(part: &PrimitiveRange, scene: &mut Scene) {
    for primitive in scene.primitives.get_mut(part.primitives.clone()).unwrap_or_default() {
        let Shape::Patch { v, n } = primitive.shape else { continue };
        let lacks = |&i: &u32| scene.normals.get(i as usize).is_none_or(|n| *n == DVec3::ZERO);
        if n.iter().any(lacks) {
            primitive.shape = Shape::Triangle { v };
        }
    }
}
