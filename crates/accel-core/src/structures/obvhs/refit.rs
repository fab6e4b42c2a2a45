//! New boxes for a binary tree whose primitives have moved: obvhs's `refit_all` from the leaves up,
//! and what the tree is then expected to cost.

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;

/// Fits all boxes to those that `bounds` gives for the leaves, by the number of the leaf's node.
pub(crate) fn refit(bvh: &mut Bvh2, mut bounds: impl FnMut(&Bvh2, usize) -> Aabb) {
    for number in 0..bvh.nodes.len() {
        if bvh.nodes[number].is_leaf() {
            let bounds = bounds(bvh, number);
            bvh.nodes[number].set_aabb(bounds);
        }
    }
    bvh.refit_all();
}

/// Expected visits to nodes and tests of primitives of a ray that meets the scene (J. D. MacDonald,
/// K. S. Booth, "Heuristics for Ray Tracing Using Space Subdivision", The Visual Computer 6(3),
/// 1990), both costing the same.
pub(crate) fn expected_cost(bvh: &Bvh2) -> f64 {
    let area = |node: usize| f64::from(bvh.nodes[node].aabb().half_area());
    let weight = |node: usize| {
        if bvh.nodes[node].is_leaf() { f64::from(bvh.nodes[node].prim_count) } else { 1.0 }
    };
    let sum: f64 = (0..bvh.nodes.len()).map(|node| area(node) * weight(node)).sum();
    match bvh.nodes.first() {
        Some(_) if area(0) > 0.0 => sum / area(0),
        _ => 1.0,
    }
}
