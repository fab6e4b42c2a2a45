//! Scenes of rigid parts: their meshes stay, their placements move.

use crate::animation::generated::mesh::Mesh;
use crate::scene::{Instance, Primitive, Scene, Shape};
use glam::{DAffine3, DVec3};

/// A scene without primitives, and the parts that it will have.
pub(super) struct Stage {
    pub scene: Scene,
    meshes: Vec<Mesh>,
    /// Mesh and material of each.
    parts: Vec<[u32; 2]>,
}

impl Stage {
    pub fn new(scene: Scene) -> Self {
        Self { scene, meshes: Vec::new(), parts: Vec::new() }
    }

    /// Adds a mesh and returns its index.
    pub fn mesh(&mut self, mesh: Mesh) -> u32 {
        self.meshes.push(mesh);
        self.meshes.len() as u32 - 1
    }

    /// Adds a part of that mesh.
    pub fn part(&mut self, mesh: u32, material: u32) {
        self.parts.push([mesh, material]);
    }

    /// Adds a part of a mesh of its own.
    pub fn part_of(&mut self, mesh: Mesh, material: u32) {
        let mesh = self.mesh(mesh);
        self.part(mesh, material);
    }

    /// Number of parts of the scene.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// The scene with its parts where they are said to be, in their order; those without a
    /// placement stand as they are.
    pub fn placed(&self, placements: impl IntoIterator<Item = DAffine3>) -> Scene {
        let mut scene = self.scene.clone();
        let sum = |count: fn(&Mesh) -> usize| {
            self.parts.iter().map(|part| count(&self.meshes[part[0] as usize])).sum()
        };
        scene.vertices.reserve_exact(sum(|mesh| mesh.vertices.len()));
        scene.normals.reserve_exact(sum(|mesh| mesh.normals.len()));
        scene.primitives.reserve_exact(sum(|mesh| mesh.triangles.len()));
        let mut placements = placements.into_iter();
        for &part in &self.parts {
            let placement = placements.next().unwrap_or(DAffine3::IDENTITY);
            push(&mut scene, part, &self.meshes[part[0] as usize], placement);
        }
        scene
    }
}

fn push(scene: &mut Scene, [object, material]: [u32; 2], mesh: &Mesh, placement: DAffine3) {
    let first = scene.primitives.len() as u32;
    let [first_v, first_n] = [scene.vertices.len(), scene.normals.len()].map(|n| n as u32);
    scene.vertices.extend(mesh.vertices.iter().map(|&v| placement.transform_point3(v)));
    scene.normals.extend(mesh.normals.iter().map(|&n| placement.transform_vector3(n)));
    let shape = |t: &[u32; 3]| {
        let v = t.map(|i| first_v + i);
        if mesh.normals.is_empty() {
            Shape::Triangle { v }
        } else {
            Shape::Patch { v, n: t.map(|i| first_n + i) }
        }
    };
    scene.primitives.extend(mesh.triangles.iter().map(|t| Primitive { shape: shape(t), material }));
    let count = mesh.triangles.len() as u32;
    scene.instances.push(Instance { object, first, count, placement });
}

/// Makes frames, in any order.
pub(super) type Frames = Box<dyn FnMut(u32) -> Scene + Send>;

/// Frames per second.
pub(super) const RATE: u32 = 25;

/// When a frame is, in seconds.
pub(super) fn seconds(frame: u32) -> f64 {
    f64::from(frame) / f64::from(RATE)
}

/// A number in [0, 1): of thing `i` the one called `what`.
pub(super) fn unit(i: u64, what: u64) -> f64 {
    (mixed(i.wrapping_mul(64).wrapping_add(what)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A number in [low, high).
pub(super) fn between(low: f64, high: f64, i: u64, what: u64) -> f64 {
    low + (high - low) * unit(i, what)
}

/// Three numbers in [-1, 1): those called `what` and the two behind it.
pub(super) fn vector(i: u64, what: u64) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| between(-1.0, 1.0, i, what + k)))
}

/// A whole number from 0 to `below` - 1.
pub(super) fn random_below(below: u64, i: u64, what: u64) -> u64 {
    mixed(i.wrapping_mul(64).wrapping_add(what)) % below
}

fn mixed(i: u64) -> u64 {
    let z = i.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A state, where it began, and how many steps it took.
pub(super) struct Replay<S> {
    first: S,
    state: S,
    steps: u32,
}

impl<S: Clone> Replay<S> {
    pub fn new(first: S) -> Self {
        Self { state: first.clone(), first, steps: 0 }
    }

    /// The state after so many steps.
    pub fn after(&mut self, steps: u32, step: impl Fn(&mut S)) -> &S {
        if steps < self.steps {
            self.state = self.first.clone();
            self.steps = 0;
        }
        while self.steps < steps {
            step(&mut self.state);
            self.steps += 1;
        }
        &self.state
    }
}
