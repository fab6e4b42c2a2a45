//! Meshes that change their shape: morph targets and skins, section 3.7 of the glTF 2.0 specification.
//!
//! Deviations: weights of joints are divided by their sum (by rounding it is not 1); a vertex whose weights
//! are all zero follows its first joint; joints beyond four a vertex are left out.

use ::gltf::accessor::Dimensions;
use ::gltf::{Mesh, Node, Primitive, Semantic, Skin};
use glam::{DMat4, DVec3};

use crate::error::LoadError;
use crate::gltf::buffers::Buffers;
use crate::gltf::pose::Pose;
use crate::gltf::vectors::{cofactor, wide};

/// What deforms the primitives of a frame.
pub(crate) struct Deformer<'a> {
    pub buffers: &'a Buffers,
    pub pose: &'a Pose,
    /// Where nodes are, by their number.
    pub joints: &'a [Option<DMat4>],
}

/// Vertices as they are in a frame, and where their space is in the world.
pub(crate) struct Deformed {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    pub world: DMat4,
}

/// Joints and their weights, of a vertex.
type Bond = [(u16, f64); 4];

/// True when a mesh at a node may change its shape.
pub(crate) fn is_soft(node: &Node<'_>, mesh: &Mesh<'_>) -> bool {
    node.skin().is_some() || mesh.primitives().any(|p| p.morph_targets().len() > 0)
}

impl Deformer<'_> {
    /// The vertices of a primitive; none where they are rigid.
    pub fn deformed(
        &self,
        node: &Node<'_>,
        primitive: &Primitive<'_>,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        world: DMat4,
    ) -> Result<Option<Deformed>, LoadError> {
        let skin = node.skin();
        if skin.is_none() && primitive.morph_targets().len() == 0 {
            return Ok(None);
        }
        let [positions, normals] = [positions, normals].map(|all| all.iter().map(wide).collect());
        let mut deformed = Deformed { positions, normals, world };
        self.morph(node, primitive, &mut deformed)?;
        if let Some(skin) = skin {
            self.bend(&skin, primitive, &mut deformed)?;
        }
        Ok(Some(deformed))
    }

    /// Adds the targets by their weights.
    fn morph(
        &self,
        node: &Node<'_>,
        primitive: &Primitive<'_>,
        deformed: &mut Deformed,
    ) -> Result<(), LoadError> {
        let animated = self.pose.of(node.index()).and_then(|pose| pose.weights.clone());
        let usual = || node.weights().or(node.mesh().and_then(|mesh| mesh.weights()));
        let weights = animated.unwrap_or_else(|| {
            usual().unwrap_or_default().iter().copied().map(f64::from).collect()
        });
        for (target, weight) in primitive.morph_targets().zip(weights) {
            if weight == 0.0 {
                continue;
            }
            let of_target = [
                (target.positions(), &mut deformed.positions),
                (target.normals(), &mut deformed.normals),
            ];
            for (accessor, all) in of_target {
                let Some(accessor) = accessor.filter(|_| !all.is_empty()) else { continue };
                let object = format!("accessor {} (morph target)", accessor.index());
                let moves = self.buffers.vectors(accessor, "morph target")?;
                if moves.len() != all.len() {
                    let found = format!("{} elements", moves.len());
                    let expected = format!("{}, as many as vertices", all.len());
                    return Err(self.buffers.invalid(&object, &found, &expected));
                }
                all.iter_mut().zip(&moves).for_each(|(v, by)| *v += wide(by) * weight);
            }
        }
        Ok(())
    }

    /// Has the vertices follow the joints; they are in the world then.
    fn bend(
        &self,
        skin: &Skin<'_>,
        primitive: &Primitive<'_>,
        deformed: &mut Deformed,
    ) -> Result<(), LoadError> {
        let object = format!("skin {}", skin.index());
        let matrices = self.matrices(skin)?;
        let bonds = self.bonds(&object, primitive, deformed.positions.len())?;
        for (i, bond) in bonds.iter().enumerate() {
            let mut matrix = DMat4::ZERO;
            for &(joint, weight) in bond.iter().filter(|(_, weight)| *weight != 0.0) {
                let Some(by) = matrices.get(usize::from(joint)) else {
                    let found = format!("joint {joint} of vertex {i}");
                    let expected = format!("one of {}, counted from 0", matrices.len());
                    return Err(self.buffers.invalid(&object, &found, &expected));
                };
                matrix += *by * weight;
            }
            if let Some(p) = deformed.positions.get_mut(i) {
                *p = matrix.transform_point3(*p);
            }
            if let Some(n) = deformed.normals.get_mut(i) {
                *n = cofactor(matrix) * *n;
            }
        }
        deformed.world = DMat4::IDENTITY;
        Ok(())
    }

    /// From the mesh's space to the world, by joints.
    fn matrices(&self, skin: &Skin<'_>) -> Result<Vec<DMat4>, LoadError> {
        let object = format!("skin {}", skin.index());
        let mut inverse = Vec::new();
        if let Some(accessor) = skin.inverse_bind_matrices() {
            let what = "inverse bind matrices";
            let numbers = self.buffers.numbers(accessor, what, Dimensions::Mat4, false)?;
            inverse = numbers.as_chunks().0.iter().map(DMat4::from_cols_array).collect();
            if inverse.len() < skin.joints().len() {
                let found =
                    format!("{} matrices for {} joints", inverse.len(), skin.joints().len());
                return Err(self.buffers.invalid(&object, &found, "one for each"));
            }
        }
        let mut matrices = Vec::new();
        for (i, joint) in skin.joints().enumerate() {
            let Some(Some(world)) = self.joints.get(joint.index()) else {
                let found = format!("node {} as a joint", joint.index());
                return Err(self.buffers.invalid(&object, &found, "a node of the scene"));
            };
            matrices.push(*world * inverse.get(i).copied().unwrap_or(DMat4::IDENTITY));
        }
        Ok(matrices)
    }

    /// The joints of each vertex; their weights add up to 1.
    fn bonds(
        &self,
        skin: &str,
        primitive: &Primitive<'_>,
        vertices: usize,
    ) -> Result<Vec<Bond>, LoadError> {
        let accessors = (primitive.get(&Semantic::Joints(0)), primitive.get(&Semantic::Weights(0)));
        let (Some(joints), Some(weights)) = accessors else {
            let found = "a mesh without JOINTS_0 and WEIGHTS_0";
            return Err(self.buffers.invalid(skin, found, "both"));
        };
        let joints = self.buffers.joints(joints)?;
        let weights = self.buffers.numbers(weights, "weights", Dimensions::Vec4, true)?;
        let weights = weights.as_chunks::<4>().0;
        if joints.len() != vertices || weights.len() != vertices {
            let found = format!("joints of {} and weights of {}", joints.len(), weights.len());
            return Err(self.buffers.invalid(skin, &found, &format!("of {vertices} vertices")));
        }
        let bond = |([a, b, c, d], weights): (&[u16; 4], &[f64; 4])| {
            let sum: f64 = weights.iter().sum();
            let [wa, wb, wc, wd] = match sum > 0.0 {
                true => weights.map(|weight| weight / sum),
                false => [1.0, 0.0, 0.0, 0.0],
            };
            [(*a, wa), (*b, wb), (*c, wc), (*d, wd)]
        };
        Ok(joints.iter().zip(weights).map(bond).collect())
    }
}
