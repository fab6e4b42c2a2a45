//! New boxes for a tree whose primitives have moved.
//!
//! Papers: G. van den Bergen, "Efficient Collision Detection of Complex Deformable Models using
//! AABB Trees", Journal of Graphics Tools 2(4), 1997 (refitting, from the leaves up); C.
//! Lauterbach, S.-E. Yoon, D. Tuft, D. Manocha, "RT-DEFORM: Interactive Ray Tracing of Dynamic
//! Scenes using BVHs", RT 2006 (to build anew once boxes have grown too much). Deviation from the
//! latter: what is compared is the tree's expected cost, not the ratio of the areas of parents and
//! children.

use obvhs::aabb::Aabb;

use super::collapse::Costs;
use super::node::{LEAF, Node, WIDTH};
use super::{WideBvh, WideBvhConfig};
use crate::bvh::items::BoxScale;
use crate::geometry::scalar::Scalar;
use crate::params::config::Settings;
use crate::primitives::{IdSet, Primitives, TriangleBlock};

impl<S: Scalar> WideBvh<S> {
    /// Fits the boxes and blocks to primitives of which some stand elsewhere now; the tree stays.
    /// Then its expected cost; none where the lists would be of another kind, and nothing was done.
    pub(super) fn refit(
        &mut self,
        prims: &dyn Primitives<S>,
        settings: &Settings<WideBvhConfig>,
        moved: &[u32],
    ) -> Option<f64> {
        let scale = BoxScale::of_set(prims, settings.padding(prims));
        let moved = IdSet::of(moved);
        if !self.lists.refresh(prims, &moved) {
            return None;
        }
        let is_same = scale.serves(&self.setup);
        self.setup = scale.setup;
        let mut own = vec![Aabb::empty(); self.nodes.len()];
        let mut ids = Vec::new();
        let mut cost = Cost::new(settings.costs);
        // children have higher numbers than their parents
        for number in (0..self.nodes.len()).rev() {
            let node = &mut self.nodes[number];
            for k in 0..WIDTH {
                let Some(before) = node.child_box(k) else { continue };
                let child = node.children[k];
                let bounds = if child & LEAF == 0 {
                    own[child as usize]
                } else {
                    self.lists.ids(child & !LEAF, &mut ids);
                    let bounds = if is_same && !ids.iter().any(|&id| moved.contains(id)) {
                        Aabb::new(before[0].into(), before[1].into())
                    } else {
                        scale.around(prims, &ids)
                    };
                    cost.leaf(&bounds, ids.len());
                    bounds
                };
                node.set_box(k, bounds.min.to_array(), bounds.max.to_array());
                own[number] = own[number].union(&bounds);
            }
            cost.node(&own[number]);
        }
        Some(cost.of_ray(own.first()))
    }

    /// Expected cost of a ray that meets the scene.
    pub(super) fn expected_cost(&self, costs: Costs) -> f64 {
        let mut cost = Cost::new(costs);
        let (mut ids, mut root) = (Vec::new(), None);
        for node in &self.nodes {
            let mut all = Aabb::empty();
            for (k, bounds) in boxes_of(node) {
                all = all.union(&bounds);
                if node.children[k] & LEAF != 0 {
                    self.lists.ids(node.children[k] & !LEAF, &mut ids);
                    cost.leaf(&bounds, ids.len());
                }
            }
            cost.node(&all);
            root.get_or_insert(all);
        }
        cost.of_ray(root.as_ref())
    }
}

/// The expected cost of a tree, as `collapse.rs` counts: visits to nodes and blocks.
struct Cost {
    node: f64,
    sum: f64,
}

impl Cost {
    fn new(costs: Costs) -> Self {
        Self { node: f64::from(costs.node), sum: 0.0 }
    }

    fn leaf(&mut self, bounds: &Aabb, primitives: usize) {
        let blocks = primitives.div_ceil(TriangleBlock::<f32>::LANES);
        self.sum += f64::from(bounds.half_area()) * blocks as f64;
    }

    fn node(&mut self, bounds: &Aabb) {
        self.sum += f64::from(bounds.half_area()) * self.node;
    }

    /// Cost of a ray that meets the root's box.
    fn of_ray(&self, root: Option<&Aabb>) -> f64 {
        let area = root.map_or(0.0, |root| f64::from(root.half_area()));
        if area > 0.0 { self.sum / area } else { 1.0 }
    }
}

/// The boxes of a node's children.
fn boxes_of(node: &Node) -> impl Iterator<Item = (usize, Aabb)> + '_ {
    (0..WIDTH).filter_map(|k| {
        let [low, high] = node.child_box(k)?;
        Some((k, Aabb::new(low.into(), high.into())))
    })
}
