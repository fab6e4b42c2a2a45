//! Meshes that change their shape: morph targets and skins, section 3.7 of the glTF 2.0
//! specification.
//!
//! Deviations: weights of joints are divided by their sum (by rounding it is not 1); a vertex whose
//! weights are all zero follows its first joint; a mesh whose joints are not in the scene keeps the
//! place of its node.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use ::gltf::accessor::Dimensions;
use ::gltf::{Accessor, Mesh, Node, Primitive, Semantic, Skin};
use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3};

use crate::error::LoadError;
use crate::gltf::clip::Pose;
use crate::gltf::container::OpenedFile;
use crate::limits::{self, MAX_ELEMENTS};
use crate::mesh::cofactor;

/// The most vertices that morph targets and sets of joints move, in all meshes of a scene: a file
/// can name the same data many times.
const MAX_MOVED: usize = 8 * MAX_ELEMENTS;

/// The most joints of all skins of a scene.
const MAX_JOINTS: usize = 1 << 20;

/// Deforms the primitives of a scene.
pub(crate) struct Deformer<'a> {
    file: &'a OpenedFile,
    pose: Option<&'a Pose>,
    /// Placements of the nodes of the scene by number.
    pub joints: HashMap<usize, DMat4>,
    /// Matrices of the skins used so far.
    skins: BTreeMap<usize, SkinMatrices>,
    moved: usize,
    skinned: usize,
}

/// From a mesh's space to the world, by joints; none where a joint is not in the scene.
type SkinMatrices = Option<Rc<[DMat4]>>;

/// Vertices as they are in a frame.
pub(crate) struct DeformedMesh {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    /// For vertices that joints brought to the world: whether that of the first one mirrors.
    pub is_mirrored: Option<bool>,
}

/// A vector of a file.
pub(super) fn wide(v: &[f32; 3]) -> DVec3 {
    Vec3::from_array(*v).as_dvec3()
}

/// True when a mesh at a node may change its shape.
pub(crate) fn is_soft(node: &Node<'_>, mesh: &Mesh<'_>) -> bool {
    node.skin().is_some() || mesh.primitives().any(|p| p.morph_targets().len() > 0)
}

/// The sets of joints and weights of a primitive.
fn joint_sets<'a>(primitive: &Primitive<'a>) -> impl Iterator<Item = (Accessor<'a>, Accessor<'a>)> {
    (0..).map_while(|set| {
        Some((primitive.get(&Semantic::Joints(set))?, primitive.get(&Semantic::Weights(set))?))
    })
}

impl<'a> Deformer<'a> {
    pub fn new(file: &'a OpenedFile, pose: Option<&'a Pose>) -> Self {
        Self { file, pose, joints: HashMap::new(), skins: BTreeMap::new(), moved: 0, skinned: 0 }
    }

    /// The vertices of a primitive, none where they are as the file has them; and why it does not
    /// follow its skin, if so.
    pub fn deformed(
        &mut self,
        node: &Node<'_>,
        primitive: &Primitive<'_>,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(Option<DeformedMesh>, Option<&'static str>), LoadError> {
        let weights = self.weights(node, primitive);
        let (matrices, unbent) = match node.skin() {
            None => (None, None),
            Some(_) if joint_sets(primitive).next().is_none() => {
                (None, Some("has no JOINTS_0 and WEIGHTS_0"))
            }
            Some(skin) => match self.matrices(&skin)? {
                None => (None, Some("has joints that are not in the scene")),
                matrices => (matrices, None),
            },
        };
        if matrices.is_none() && weights.iter().all(|&weight| weight == 0.0) {
            return Ok((None, unbent));
        }
        let targets = weights.iter().filter(|&&weight| weight != 0.0).count();
        let sets = matrices.iter().flat_map(|_| joint_sets(primitive)).count();
        self.moved = self.moved.saturating_add(positions.len().saturating_mul(targets + sets));
        let what = "the number of vertices that morph targets and joints move";
        limits::check(self.moved, MAX_MOVED, what, || self.file.place())?;
        let [positions, normals] = [positions, normals].map(|all| all.iter().map(wide).collect());
        let mut deformed = DeformedMesh { positions, normals, is_mirrored: None };
        self.morph(primitive, &weights, &mut deformed)?;
        if let (Some(matrices), Some(skin)) = (matrices, node.skin()) {
            let object = format!("skin {}", skin.index());
            self.bend(&object, &matrices, primitive, &mut deformed)?;
        }
        Ok((Some(deformed), unbent))
    }

    /// The weights of the morph targets: those of the pose, of the node, or of the mesh.
    fn weights(&self, node: &Node<'_>, primitive: &Primitive<'_>) -> Vec<f64> {
        let count = primitive.morph_targets().len();
        let animated = self.pose.and_then(|pose| pose.of(node.index())?.weights.as_deref());
        let usual = || node.weights().or(node.mesh().and_then(|mesh| mesh.weights()));
        match animated {
            Some(weights) => weights.iter().copied().take(count).collect(),
            None => usual().into_iter().flatten().map(|&w| f64::from(w)).take(count).collect(),
        }
    }

    /// Adds the targets by their weights.
    fn morph(
        &self,
        primitive: &Primitive<'_>,
        weights: &[f64],
        deformed: &mut DeformedMesh,
    ) -> Result<(), LoadError> {
        for (target, &weight) in primitive.morph_targets().zip(weights) {
            if weight == 0.0 {
                continue;
            }
            let of_target = [
                (target.positions(), &mut deformed.positions),
                (target.normals(), &mut deformed.normals),
            ];
            for (accessor, all) in of_target {
                let Some(accessor) = accessor.filter(|_| !all.is_empty()) else { continue };
                let index = accessor.index();
                let moves = self.file.buffers.vectors(accessor, "morph target")?;
                if moves.len() != all.len() {
                    let object = format!("accessor {index} (morph target)");
                    let found = format!("{} elements", moves.len());
                    let expected = format!("{}, as many as vertices", all.len());
                    return Err(self.file.buffers.invalid(&object, &found, &expected));
                }
                for (i, (v, by)) in all.iter_mut().zip(&moves).enumerate() {
                    let by = wide(by) * weight;
                    if !by.is_finite() {
                        let found = by.to_array().into_iter().find(|x| !x.is_finite());
                        let found = found.unwrap_or_default();
                        return Err(self.file.buffers.not_finite(index, "morph target", i, found));
                    }
                    *v += by;
                }
            }
        }
        Ok(())
    }

    /// Has the vertices follow the joints; they are in the world then.
    fn bend(
        &self,
        skin: &str,
        matrices: &[DMat4],
        primitive: &Primitive<'_>,
        deformed: &mut DeformedMesh,
    ) -> Result<(), LoadError> {
        let count = deformed.positions.len();
        // of each vertex: weighted sum of its matrices, sum of the weights, first joint
        let mut bonds = vec![(DMat4::ZERO, 0.0, 0); count];
        for (set, (joints, weights)) in joint_sets(primitive).enumerate() {
            let joints = self.file.buffers.joints(joints)?;
            let weights = self.file.buffers.numbers(weights, "weights", Dimensions::Vec4, true)?;
            let weights = weights.as_chunks::<4>().0;
            if joints.len() != count || weights.len() != count {
                let found = format!("joints of {} and weights of {}", joints.len(), weights.len());
                let expected = format!("of {count} vertices");
                return Err(self.file.buffers.invalid(skin, &found, &expected));
            }
            let of_vertices = bonds.iter_mut().zip(joints.iter().zip(weights));
            for (i, ((matrix, sum, first), (joints, weights))) in of_vertices.enumerate() {
                if set == 0 {
                    [*first, ..] = *joints;
                }
                for (&joint, &weight) in joints.iter().zip(weights).filter(|pair| *pair.1 != 0.0) {
                    *matrix += self.joint(skin, matrices, joint, i)? * weight;
                    *sum += weight;
                }
            }
        }
        for (i, (matrix, sum, first)) in bonds.iter_mut().enumerate() {
            *matrix = match *sum {
                sum if sum > 0.0 => *matrix * (1.0 / sum),
                _ => self.joint(skin, matrices, *first, i)?,
            };
        }
        for (p, (matrix, ..)) in deformed.positions.iter_mut().zip(&bonds) {
            *p = matrix.transform_point3(*p);
        }
        for (n, (matrix, ..)) in deformed.normals.iter_mut().zip(&bonds) {
            *n = cofactor(*matrix) * *n;
        }
        let mirrors = |matrix: DMat4| DMat3::from_mat4(matrix).determinant() < 0.0;
        deformed.is_mirrored = Some(bonds.first().is_some_and(|(matrix, ..)| mirrors(*matrix)));
        Ok(())
    }

    fn joint(
        &self,
        skin: &str,
        matrices: &[DMat4],
        joint: u16,
        vertex: usize,
    ) -> Result<DMat4, LoadError> {
        matrices.get(usize::from(joint)).copied().ok_or_else(|| {
            let found = format!("joint {joint} of vertex {vertex}");
            let expected = format!("one of {}, counted from 0", matrices.len());
            self.file.buffers.invalid(skin, &found, &expected)
        })
    }

    fn matrices(&mut self, skin: &Skin<'_>) -> Result<SkinMatrices, LoadError> {
        if let Some(known) = self.skins.get(&skin.index()) {
            return Ok(known.clone());
        }
        let count = skin.joints().len();
        self.skinned += count;
        limits::check(self.skinned, MAX_JOINTS, "the number of joints", || self.file.place())?;
        let mut inverse = Vec::new();
        if let Some(accessor) = skin.inverse_bind_matrices() {
            let what = "inverse bind matrices";
            let numbers = self.file.buffers.numbers(accessor, what, Dimensions::Mat4, false)?;
            let matrices = numbers.as_chunks().0.iter().map(DMat4::from_cols_array);
            inverse = matrices.map(|matrix| DAffine3::from_mat4(matrix).into()).collect();
            if inverse.len() < count {
                let object = format!("skin {}", skin.index());
                let found = format!("{} matrices for {count} joints", inverse.len());
                return Err(self.file.buffers.invalid(&object, &found, "one for each"));
            }
        }
        let matrices = skin.joints().enumerate().map(|(i, joint)| {
            let world = *self.joints.get(&joint.index())?;
            Some(world * inverse.get(i).copied().unwrap_or(DMat4::IDENTITY))
        });
        let matrices: SkinMatrices = matrices.collect();
        self.skins.insert(skin.index(), matrices.clone());
        Ok(matrices)
    }
}
