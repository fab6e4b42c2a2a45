//! New boxes for a tree whose primitives have moved.
//!
//! Papers: G. van den Bergen, "Efficient Collision Detection of Complex Deformable Models using AABB Trees",
//! Journal of Graphics Tools 2(4), 1997 (refitting, from the leaves up); C. Lauterbach, S.-E. Yoon, D. Tuft,
//! D. Manocha, "RT-DEFORM: Interactive Ray Tracing of Dynamic Scenes using BVHs", RT 2006 (to build anew once boxes
//! have grown too much). Deviation from the latter: what is compared is the tree's expected cost, not the ratio
//! of the areas of parents and children.

use obvhs::aabb::Aabb;

use super::collapse::{Costs, WIDTH};
use super::node::{LEAF, Node};
use super::{WideBvh, padding_of};
use crate::geometry::scalar::Scalar;
use crate::params::Params;
use crate::primitives::{PrimSet, TriangleBlock};
use crate::structure::BuildError;
use crate::structures::obvhs::items;

impl<S: Scalar> WideBvh<S> {
    /// Fits the boxes and blocks to primitives that stand elsewhere now; the tree stays. False where their lists
    /// would be of another kind, and nothing was done.
    pub(super) fn refit<P: PrimSet<S>>(
        &mut self,
        prims: &P,
        params: &Params,
    ) -> Result<bool, BuildError> {
        let (boxes, setup) = items::boxes(prims, params.structure(), padding_of(params))?;
        if !self.lists.refresh(prims) {
            return Ok(false);
        }
        self.setup = setup;
        let mut own = vec![Aabb::empty(); self.nodes.len()];
        let mut ids = Vec::new();
        // children have higher numbers than their parents
        for number in (0..self.nodes.len()).rev() {
            let node = &mut self.nodes[number];
            for k in 0..WIDTH {
                if node.child_box(k).is_none() {
                    continue;
                }
                let child = node.children[k];
                let bounds = if child & LEAF == 0 {
                    own[child as usize]
                } else {
                    self.lists.ids(child & !LEAF, &mut ids);
                    ids.iter().fold(Aabb::empty(), |all, &id| all.union(&boxes[id as usize]))
                };
                node.set_box(k, bounds.min.to_array(), bounds.max.to_array());
                own[number] = own[number].union(&bounds);
            }
        }
        Ok(true)
    }

    /// What a ray that meets the scene costs, as `collapse.rs` counts: the expected visits to nodes and blocks.
    pub(super) fn expected_cost(&self, costs: Costs) -> f64 {
        let (mut sum, mut root) = (0.0, 0.0);
        let mut ids = Vec::new();
        for (number, node) in self.nodes.iter().enumerate() {
            let mut all = Aabb::empty();
            for (k, bounds) in boxes_of(node) {
                all = all.union(&bounds);
                if node.children[k] & LEAF != 0 {
                    self.lists.ids(node.children[k] & !LEAF, &mut ids);
                    let blocks = ids.len().div_ceil(TriangleBlock::<f32>::LANES);
                    sum += f64::from(bounds.half_area()) * blocks as f64;
                }
            }
            let area = f64::from(all.half_area());
            sum += area * f64::from(costs.node);
            if number == 0 {
                root = area;
            }
        }
        if root > 0.0 { sum / root } else { 1.0 }
    }
}

/// The boxes of a node's children.
fn boxes_of(node: &Node) -> impl Iterator<Item = (usize, Aabb)> + '_ {
    (0..WIDTH).filter_map(|k| {
        let [low, high] = node.child_box(k)?;
        Some((k, Aabb::new(low.into(), high.into())))
    })
}
