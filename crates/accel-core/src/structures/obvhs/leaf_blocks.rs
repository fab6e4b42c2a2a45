//! The triangles of obvhs's leaves as blocks, in the order of the leaves: `kernel=block`.
//!
//! The trees stay the library's, but for where leaves say that their primitives are: there the
//! numbers of blocks stand, so that nothing lies between a node and its triangles.

use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;

use crate::geometry::scalar::Scalar;
use crate::memory::Limits;
use crate::memory::OutOfMemory;
use crate::primitives::{PrimSet, TriangleBlock, blocks};
use crate::structures::obvhs::adapter::AdapterConfig;
use crate::structures::obvhs::items::Groups;

/// Triangles in a block.
const LANES: u32 = TriangleBlock::<f32>::LANES as u32;

/// Returns whether leaves become blocks: where it is asked for and each box is that of a triangle.
pub(crate) fn serve<S: Scalar, P: PrimSet<S>>(
    prims: &P,
    groups: &Groups,
    config: &AdapterConfig,
) -> bool {
    let is_wanted = config.is_block;
    // the places of all blocks have numbers, even were there one triangle in each
    let is_few = prims.len() <= (u32::MAX / LANES) as usize;
    is_wanted && is_few && matches!(groups, Groups::Single) && blocks::serve(prims)
}

/// Checks that memory has room for so many blocks, one per leaf or node at least.
pub(crate) fn fit<S: Scalar>(blocks: usize, limits: Limits) -> Result<(), OutOfMemory> {
    limits.fits((blocks * size_of::<TriangleBlock<S>>()) as u128)
}

/// The blocks of a binary tree, whose leaves then begin at the number of a block: theirs follow,
/// each saying whether there is another ([`TriangleBlock::has_next`]).
pub(crate) fn of_binary<S: Scalar, P: PrimSet<S>>(
    bvh: &mut Bvh2,
    prims: &P,
) -> Vec<TriangleBlock<S>> {
    let ids = std::mem::take(&mut bvh.primitive_indices);
    let mut all = Vec::with_capacity(bvh.nodes.len() / 2 + 1);
    for leaf in bvh.nodes.iter_mut().filter(|node| node.is_leaf()) {
        let first = leaf.first_index as usize;
        leaf.first_index = all.len() as u32;
        blocks::push_list(prims, &ids[first..first + leaf.prim_count as usize], &mut all);
    }
    all
}

/// The blocks of an eight-wide tree. The triangles of a node's leaves, up to 24, share up to three:
/// its first primitive is then eight times the number of its first block, and a primitive's place
/// among them, as the traversal has it, tells its block ([`block_of`]).
pub(crate) fn of_wide<S: Scalar, P: PrimSet<S>>(
    bvh: &mut CwBvh,
    prims: &P,
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
    use crate::params::config::Settings;
    use crate::primitives::TriangleSet;
    use crate::structures::obvhs::builder;
    use crate::structures::obvhs::items::items;

    fn triangles(n: usize) -> TriangleSet<f32> {
        let part = |i: usize, by: f64| (i as f64 * by).fract() as f32;
        let at = |i| [part(i, 0.754_877), part(i, 0.569_84), part(i, 0.438_28)];
        let near = |a: [f32; 3], i| std::array::from_fn(|k| a[k] + 0.05 * at(i)[k]);
        let triangle =
            |i: usize| [at(3 * i), near(at(3 * i), 3 * i + 1), near(at(3 * i), 3 * i + 2)];
        TriangleSet::new((0..n).map(triangle).collect(), |_| false).unwrap()
    }

    /// The ids that a tree's leaves name, leaf by leaf.
    fn named(ids: impl Iterator<Item = Vec<u32>>) -> Vec<Vec<u32>> {
        ids.map(|mut ids| {
            ids.sort_unstable();
            ids
        })
        .collect()
    }

    fn in_block(block: &TriangleBlock<f32>) -> Vec<u32> {
        let (ids, n) = block.ids();
        ids[..n].to_vec()
    }

    #[test]
    fn leaves_name_their_triangles() {
        let set = triangles(5000);
        let params = crate::structures::obvhs::bvh2::INFO.defaults();
        let settings = Settings::<AdapterConfig>::of(&params);
        let boxes = items(&set, &settings).unwrap().boxes;
        let preset = settings.preset;
        let ids = builder::binary(&boxes, &preset, true);
        let mut tree = ids.clone();
        let blocks = of_binary(&mut tree, &set);
        let leaves = |tree: &Bvh2| tree.nodes.clone().into_iter().filter(|n| n.is_leaf());
        let expected = named(leaves(&ids).map(|leaf| {
            let first = leaf.first_index as usize;
            ids.primitive_indices[first..first + leaf.prim_count as usize].to_vec()
        }));
        let of_leaf = |tree: &Bvh2| {
            named(leaves(tree).map(|leaf| {
                let rest = &blocks[leaf.first_index as usize..];
                let n = 1 + rest.iter().take_while(|block| block.has_next()).count();
                rest[..n].iter().flat_map(in_block).collect()
            }))
        };
        assert!(of_leaf(&tree) == expected);
        assert_eq!(references(&blocks), 5000);
        // planted fault
        let leaf = tree.nodes.iter().position(|node| node.is_leaf()).unwrap();
        tree.nodes[leaf].first_index += 1;
        assert!(of_leaf(&tree) != expected);
    }

    #[test]
    fn places_of_nodes_name_their_triangles() {
        let set = triangles(5000);
        let params = crate::structures::obvhs::cwbvh::INFO.defaults();
        let settings = Settings::<AdapterConfig>::of(&params);
        let boxes = items(&set, &settings).unwrap().boxes;
        let ids = builder::eight_wide(&boxes, &settings.preset, true).unwrap();
        let mut tree = ids.clone();
        let blocks = of_wide(&mut tree, &set);
        let mut bits_of_all = 0;
        for (node, own) in tree.nodes.iter().zip(&ids.nodes) {
            for place in 0..primitives(own) as u32 {
                let first = node.primitive_base_idx;
                let (block, bits) = block_of(first + place, first);
                let id = ids.primitive_indices[(own.primitive_base_idx + place) as usize];
                assert_eq!(in_block(&blocks[block])[(place % LANES) as usize], id);
                assert!(bits >> place & 1 == 1 && bits.count_ones() <= LANES);
                bits_of_all |= bits;
            }
        }
        assert_eq!((bits_of_all, references(&blocks)), (0xff_ffff, 5000));
    }
}
