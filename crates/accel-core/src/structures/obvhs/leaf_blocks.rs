//! The triangles of a CwBvh's leaves as blocks, in the order of the leaves: `kernel=block`.
//!
//! The tree stays the library's, but for where leaves say that their primitives are: there the
//! numbers of blocks stand, so that nothing lies between a node and its triangles.

use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;

use crate::bvh::items::Groups;
use crate::geometry::scalar::Scalar;
use crate::memory::Limits;
use crate::memory::OutOfMemory;
use crate::primitives::{Primitives, TriangleBlock, blocks};

/// Triangles in a block.
const LANES: u32 = TriangleBlock::<f32>::LANES as u32;

/// Returns whether leaves can become blocks: where each box is that of a triangle.
pub(crate) fn serve<S: Scalar>(prims: &dyn Primitives<S>, groups: &Groups) -> bool {
    // the places of all blocks have numbers, even were there one triangle in each
    let is_few = prims.len() <= (u32::MAX / LANES) as usize;
    is_few && matches!(groups, Groups::Single) && blocks::serve(prims)
}

/// Checks that memory has room for so many blocks, one per leaf or node at least.
pub(crate) fn fit<S: Scalar>(blocks: usize, limits: Limits) -> Result<(), OutOfMemory> {
    limits.fits((blocks * size_of::<TriangleBlock<S>>()) as u128)
}

/// The blocks of an eight-wide tree. The triangles of a node's leaves, up to 24, share up to three:
/// its first primitive is then eight times the number of its first block, and a primitive's place
/// among them, as the traversal has it, tells its block ([`block_of`]).
pub(crate) fn of_wide<S: Scalar>(
    bvh: &mut CwBvh,
    prims: &dyn Primitives<S>,
) -> Vec<TriangleBlock<S>> {
    let ids = std::mem::take(&mut bvh.primitive_indices);
    let mut all = Vec::with_capacity(bvh.nodes.len());
    for node in &mut bvh.nodes {
        let first = node.primitive_base_idx as usize;
        node.primitive_base_idx = all.len() as u32 * LANES;
        blocks::push_list(prims, &ids[first..first + primitives(node)], &mut all);
    }
    all
}

/// Primitives of a node's leaves.
fn primitives(node: &CwBvhNode) -> usize {
    let leaves = (0..8).filter(|child| node.is_leaf(*child) && !node.is_child_empty(*child));
    // three bits for how many, in unary, five for the place of the first
    leaves.map(|child| (node.child_meta[child] >> 5).count_ones() as usize).sum()
}

/// The block of a primitive, and the bits of the block's primitives among those of the node.
#[inline(always)]
pub(crate) fn block_of(primitive: u32, first: u32) -> (usize, u32) {
    let place = primitive - first;
    ((primitive / LANES) as usize, 0xff << (place & !(LANES - 1)))
}

pub(crate) fn references<S: Scalar>(blocks: &[TriangleBlock<S>]) -> u64 {
    blocks.iter().map(|block| block.ids().1 as u64).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::build::agglomerated::agglomerated;
    use crate::bvh::items::{Padding, items_of};
    use crate::params::config::Settings;
    use crate::primitives::TriangleSet;
    use crate::structures::obvhs::builder;

    fn triangles(n: usize) -> TriangleSet<f32> {
        let part = |i: usize, by: f64| (i as f64 * by).fract() as f32;
        let at = |i| [part(i, 0.754_877), part(i, 0.569_84), part(i, 0.438_28)];
        let near = |a: [f32; 3], i| std::array::from_fn(|k| a[k] + 0.05 * at(i)[k]);
        let triangle =
            |i: usize| [at(3 * i), near(at(3 * i), 3 * i + 1), near(at(3 * i), 3 * i + 2)];
        TriangleSet::new((0..n).map(triangle).collect(), |_| false).unwrap()
    }

    #[test]
    fn places_of_nodes_name_their_triangles() {
        let set = triangles(5000);
        let limits = Settings::<()>::of(&crate::structures::obvhs::cwbvh::INFO.defaults()).limits();
        let boxes = items_of(&set, limits, Padding::OfScene).unwrap().boxes;
        let medium = obvhs::BvhBuildParams::medium_build();
        let ids = builder::eight_wide(agglomerated(&boxes, &medium, true), &medium, true).unwrap();
        let mut tree = ids.clone();
        let blocks = of_wide(&mut tree, &set);
        let mut bits_of_all = 0;
        for (node, own) in tree.nodes.iter().zip(&ids.nodes) {
            for place in 0..primitives(own) as u32 {
                let first = node.primitive_base_idx;
                let (block, bits) = block_of(first + place, first);
                let id = ids.primitive_indices[(own.primitive_base_idx + place) as usize];
                assert_eq!(blocks[block].ids().0[(place % LANES) as usize], id);
                assert!(bits >> place & 1 == 1 && bits.count_ones() <= LANES);
                bits_of_all |= bits;
            }
        }
        assert_eq!((bits_of_all, references(&blocks)), (0xff_ffff, 5000));
    }
}
