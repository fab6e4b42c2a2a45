//! Trees of obvhs in words, as the shaders read them.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::triangle::Triangle;
use peer::Scene;

/// Levels of the deepest tree: each of the thousands of rays in flight has a stack.
const MOST_LEVELS: usize = 511;

/// A tree, and the triangles in the order of its leaves.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    /// Eight words a binary node, twenty a wide one.
    pub(crate) nodes: Vec<u32>,
    /// Twelve words each: the corners with a word behind each, which are the id, 1 where shadow
    /// rays pass, and 0.
    pub(crate) triangles: Vec<u32>,
    pub(crate) inner_nodes: u64,
    pub(crate) leaves: u64,
    /// Levels of inner nodes; a stack takes one child, or one group of them, for each.
    pub(crate) levels: usize,
}

impl Tree {
    /// Builds with obvhs's preset `medium`, which splits no triangles.
    ///
    /// # Errors
    /// That the tree is too deep.
    pub(crate) fn build(scene: &Scene<'_>, is_wide: bool) -> Result<Self, String> {
        let corners = |triangle: &peer::Triangle| {
            let [v0, v1, v2] = triangle.map(Vec3A::from_array);
            Triangle { v0, v1, v2 }
        };
        let triangles: Vec<Triangle> = scene.triangles.iter().map(corners).collect();
        let (preset, time) = (BvhBuildParams::medium_build(), &mut Duration::default());
        let mut tree = Self::default();
        let ids = if is_wide {
            let built = build_cwbvh_from_tris(&triangles, preset, time);
            tree.nodes = bytemuck::cast_slice(&built.nodes).to_vec();
            tree.count(|index| {
                let node = &built.nodes[index as usize];
                let all = (0..8).filter(|child| !node.is_child_empty(*child));
                let child = |i| (!node.is_leaf(i)).then(|| node.child_node_index(i));
                Some(all.map(child).collect())
            });
            built.primitive_indices
        } else {
            let built = build_bvh2_from_tris(&triangles, preset, time);
            let words = |node: &Bvh2Node| {
                let [a, b] =
                    [node.aabb().min, node.aabb().max].map(|p| p.to_array().map(f32::to_bits));
                [a[0], a[1], a[2], node.prim_count, b[0], b[1], b[2], node.first_index]
            };
            tree.nodes = built.nodes.iter().flat_map(words).collect();
            tree.count(|index| {
                let node = &built.nodes[index as usize];
                let children = [0, 1].map(|child| Some(node.first_index + child));
                (!node.is_leaf()).then(|| children.to_vec())
            });
            built.primitive_indices
        };
        let words = |id: &u32| {
            let [a, b, c] = scene.triangles[*id as usize].map(|corner| corner.map(f32::to_bits));
            let passes = u32::from(scene.is_transmissive(*id as usize));
            [a[0], a[1], a[2], *id, b[0], b[1], b[2], passes, c[0], c[1], c[2], 0]
        };
        tree.triangles = ids.iter().flat_map(words).collect();
        if tree.levels > MOST_LEVELS {
            return Err(format!("the tree has {} levels, more than {MOST_LEVELS}", tree.levels));
        }
        Ok(tree)
    }

    /// Counts nodes, by the children of a node; none of a leaf, and `None` for a child without a
    /// node.
    fn count(&mut self, children: impl Fn(u32) -> Option<Vec<Option<u32>>>) {
        let mut waiting = vec![(Some(0), 0)];
        while let Some((node, level)) = waiting.pop() {
            if let Some(children) = node.and_then(&children) {
                self.inner_nodes += 1;
                self.levels = self.levels.max(level + 1);
                waiting.extend(children.into_iter().map(|child| (child, level + 1)));
            } else {
                self.leaves += 1;
            }
        }
    }
}
