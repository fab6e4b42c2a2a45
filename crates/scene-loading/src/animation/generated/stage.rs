//! Scenes of rigid parts: their meshes stay, their placements move.

use glam::DAffine3;

use crate::animation::generated::mesh::Mesh;
use crate::scene::{Instance, Material, Primitive, Scene, Shape};

/// A scene without primitives, and the parts that it will have.
pub(super) struct Stage {
    pub scene: Scene,
    meshes: Vec<Mesh>,
    parts: Vec<Part>,
}

/// A mesh that is somewhere.
struct Part {
    mesh: u32,
    material: u32,
}

impl Stage {
    pub fn new(scene: Scene) -> Self {
        Self { scene, meshes: Vec::new(), parts: Vec::new() }
    }

    /// Adds a material and returns its index.
    pub fn material(&mut self, material: Material) -> u32 {
        self.scene.push_material(material)
    }

    /// Adds a mesh and returns its index.
    pub fn mesh(&mut self, mesh: Mesh) -> u32 {
        self.meshes.push(mesh);
        self.meshes.len() as u32 - 1
    }

    /// Adds a part of that mesh.
    pub fn part(&mut self, mesh: u32, material: u32) {
        self.parts.push(Part { mesh, material });
    }

    /// Adds a part of a mesh of its own.
    pub fn part_of(&mut self, mesh: Mesh, material: u32) {
        let mesh = self.mesh(mesh);
        self.part(mesh, material);
    }

    /// How many parts there are.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// The scene with its parts where they are said to be, in their order; those without a
    /// placement stand as they are.
    pub fn placed(&self, placements: impl IntoIterator<Item = DAffine3>) -> Scene {
        let mut scene = self.scene.clone();
        let sum = |count: fn(&Mesh) -> usize| {
            self.parts.iter().map(|part| count(&self.meshes[part.mesh as usize])).sum()
        };
        scene.vertices.reserve_exact(sum(|mesh| mesh.vertices.len()));
        scene.normals.reserve_exact(sum(|mesh| mesh.normals.len()));
        scene.primitives.reserve_exact(sum(|mesh| mesh.triangles.len()));
        let mut placements = placements.into_iter();
        for part in &self.parts {
            let placement = placements.next().unwrap_or(DAffine3::IDENTITY);
            push(&mut scene, part, &self.meshes[part.mesh as usize], placement);
        }
        scene
    }
}

fn push(scene: &mut Scene, part: &Part, mesh: &Mesh, placement: DAffine3) {
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
    let material = part.material;
    scene.primitives.extend(mesh.triangles.iter().map(|t| Primitive { shape: shape(t), material }));
    let count = mesh.triangles.len() as u32;
    scene.instances.push(Instance { object: part.mesh, first, count, placement });
}
