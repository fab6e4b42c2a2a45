//! Scenes of rigid parts: their meshes stay, their placements move. Also the time and the random
//! numbers of all generated animations.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3};

use crate::procedural::hare::face;
use crate::scene::{Instance, Material, Scene};

/// A scene without primitives, and the parts that it will have.
pub(super) struct Stage {
    pub scene: Scene,
    meshes: Vec<Mesh>,
    /// Mesh and material of each.
    parts: Vec<[u32; 2]>,
    /// So many of them, which come first, do not move.
    at_rest: usize,
}

impl Stage {
    pub fn new(scene: Scene) -> Self {
        Self { scene, meshes: Vec::new(), parts: Vec::new(), at_rest: 0 }
    }

    /// Adds a mesh and returns its index.
    pub fn mesh(&mut self, mesh: Mesh) -> u32 {
        self.meshes.push(mesh);
        self.meshes.len() as u32 - 1
    }

    /// Adds a part of that mesh, which moves.
    pub fn part(&mut self, mesh: u32, material: u32) {
        self.parts.push([mesh, material]);
    }

    /// Adds a part that does not move, before all that do; none for an empty mesh.
    pub fn part_at_rest(&mut self, mesh: Mesh, material: Material) {
        let material = self.scene.push_material(material);
        if !mesh.triangles.is_empty() {
            let mesh = self.mesh(mesh);
            self.part(mesh, material);
            self.at_rest += 1;
        }
    }

    /// The scene with its moving parts where they are said to be, in their order.
    pub fn placed(&self, placements: impl IntoIterator<Item = DAffine3>) -> Scene {
        let mut scene = self.scene.clone();
        let sum = |count: fn(&Mesh) -> usize| {
            self.parts.iter().map(|part| count(&self.meshes[part[0] as usize])).sum()
        };
        scene.vertices.reserve_exact(sum(|mesh| mesh.vertices.len()));
        scene.normals.reserve_exact(sum(|mesh| mesh.normals.len()));
        scene.primitives.reserve_exact(sum(|mesh| mesh.triangles.len()));
        let at_rest = std::iter::repeat_n(DAffine3::IDENTITY, self.at_rest);
        for (&part, placement) in self.parts.iter().zip(at_rest.chain(placements)) {
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
    for triangle in &mesh.triangles {
        let n = (!mesh.normals.is_empty()).then(|| triangle.map(|i| first_n + i));
        scene.push_corners(material, triangle.map(|i| first_v + i), n);
    }
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

/// Triangles over vertices, wound against the clock as seen from outside.
#[derive(Default)]
pub(super) struct Mesh {
    pub vertices: Vec<DVec3>,
    /// Normal of each vertex; empty for flat faces.
    pub normals: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// Corners of an icosahedron, in parts of 1 and of the golden ratio: first and second axis of
/// three, signs.
#[rustfmt::skip]
const CORNERS: [(usize, f64, f64); 12] = [
    (0, -1.0, 1.0), (0, 1.0, 1.0), (0, -1.0, -1.0), (0, 1.0, -1.0), (1, -1.0, 1.0), (1, 1.0, 1.0),
    (1, -1.0, -1.0), (1, 1.0, -1.0), (2, -1.0, 1.0), (2, 1.0, 1.0), (2, -1.0, -1.0),
    (2, 1.0, -1.0),
];

#[rustfmt::skip]
const FACES: [[usize; 3]; 20] = [
    [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2],
    [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5],
    [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
];

impl Mesh {
    /// A smooth ball of radius 1 around the origin: an icosahedron's faces, each cut into `n`
    /// squared triangles and pushed out.
    pub fn ball(n: u32) -> Self {
        let golden = (1.0 + 5_f64.sqrt()) / 2.0;
        let corners = CORNERS.map(|(axis, one, long)| {
            let mut corner = [0.0; 3];
            corner[axis] = one;
            corner[(axis + 1) % 3] = long * golden;
            DVec3::from_array(corner)
        });
        let mut mesh = Self::default();
        // by corners and their shares, so that faces have the vertices on their edges in common
        let mut known: BTreeMap<[(usize, i32); 3], u32> = BTreeMap::new();
        for of in FACES {
            for (a, b, c) in face(n as i32) {
                mesh.triangles.push([a, b, c].map(|[x, y, z]| {
                    let mut key = [(of[0], x), (of[1], y), (of[2], z)]
                        .map(|(corner, share)| if share == 0 { (0, 0) } else { (corner, share) });
                    key.sort_unstable();
                    *known.entry(key).or_insert_with(|| {
                        let at: DVec3 = key.iter().map(|&(i, w)| corners[i] * f64::from(w)).sum();
                        mesh.vertices.push(at.normalize());
                        mesh.vertices.len() as u32 - 1
                    })
                }));
            }
        }
        mesh.normals.clone_from(&mesh.vertices);
        mesh
    }

    /// A block between two corners: 12 triangles.
    pub fn block(min: DVec3, max: DVec3) -> Self {
        let corner = |i: u32| {
            let pick = |bit: u32, low, high| if i & bit == 0 { low } else { high };
            DVec3::new(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z))
        };
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        Self {
            vertices: (0..8).map(corner).collect(),
            normals: Vec::new(),
            triangles: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        }
    }

    /// A quadrangle: two triangles.
    pub fn quadrangle(corners: [DVec3; 4]) -> Self {
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        Self { vertices: corners.to_vec(), normals: Vec::new(), triangles }
    }

    /// Scaled along the axes; keeps its sense.
    pub fn scaled(mut self, by: DVec3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v *= by);
        self.normals.iter_mut().for_each(|n| *n = (*n / by).normalize());
        self
    }

    /// With what lies below z = 0 lowered: a ball becomes a capsule.
    pub fn pulled_down(mut self, by: f64) -> Self {
        self.vertices.iter_mut().filter(|v| v.z < 0.0).for_each(|v| v.z -= by);
        self
    }

    /// With another of its kind.
    pub fn with(mut self, other: &Self) -> Self {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.normals.extend(&other.normals);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| first + i)));
        self
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Six times the volume within, if the mesh is closed and wound one way.
    fn closed(mesh: &Mesh) -> Option<f64> {
        let mut edges = BTreeSet::new();
        for &[a, b, c] in &mesh.triangles {
            if ![(a, b), (b, c), (c, a)].into_iter().all(|edge| edges.insert(edge)) {
                return None;
            }
        }
        let volume = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
            a.dot(b.cross(c))
        };
        let all = edges.iter().all(|&(a, b)| edges.contains(&(b, a)));
        all.then(|| mesh.triangles.iter().map(volume).sum())
    }

    #[test]
    fn balls_capsules_and_blocks_are_closed_and_face_outward() {
        for n in 1..6 {
            let ball = Mesh::ball(n);
            assert_eq!(ball.triangles.len() as u32, 20 * n * n);
            assert_eq!(ball.vertices.len() as u32, 10 * n * n + 2);
            let volume = closed(&ball).unwrap();
            assert!(volume > 15.0 && volume < 25.14, "{n}: {volume}");
            let capsule = closed(&ball.pulled_down(1.0)).unwrap();
            assert!(capsule > volume + 9.0, "{n}: {capsule}");
        }
        let block = Mesh::block(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(closed(&block), Some(36.0));
        // planted fault: a triangle the other way round
        let mut bad = block;
        bad.triangles[3].swap(0, 1);
        assert_eq!(closed(&bad), None);
    }
}
