//! A frustum's way through a k-d tree: from the root, the near child first.

use std::ops::ControlFlow;

use crate::query::region::{Frustum, FrustumTraversal};
use crate::structures::kd_tree::KdTree;
use crate::structures::kd_tree::subdivide::Node;

impl FrustumTraversal for KdTree<f64> {
    fn traverse_frustum(
        &self,
        frustum: &Frustum,
        cell: &mut dyn FnMut(&[u32], f64) -> ControlFlow<()>,
    ) {
        let root = self.bounds.expanded(frustum.tolerance());
        if !frustum.meets_box(&root) {
            return;
        }
        let direction = frustum.direction();
        // cells that wait, each with the least depth of itself and of those below it
        let mut stack = vec![(0u32, root, frustum.least_depth(&root))];
        while let Some((index, bounds, depth)) = stack.pop() {
            let node = self.cells.nodes[index as usize];
            let axis = (node.link & 3) as usize;
            if node.link & 3 == Node::<f64>::LEAF {
                let ids = self.cells.lists.at((node.link >> 2) as usize);
                if !ids.is_empty() && cell(ids, depth).is_break() {
                    return;
                }
                continue;
            }
            let (mut lower, mut upper) = (bounds, bounds);
            lower.max[axis] = node.plane + frustum.tolerance();
            upper.min[axis] = node.plane - frustum.tolerance();
            let child = node.link >> 2;
            let mut children = [(child + 1, upper), (child, lower)];
            if direction[axis] < 0.0 {
                children.reverse();
            }
            // the far child waits below the near one
            let mut below = stack.last().map_or(f64::INFINITY, |s| s.2);
            for (index, bounds) in children {
                if frustum.meets_box(&bounds) {
                    below = below.min(frustum.least_depth(&bounds));
                    stack.push((index, bounds, below));
                }
            }
        }
    }
}
