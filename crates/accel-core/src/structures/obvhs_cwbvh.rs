//! The compressed 8-wide BVH of the `obvhs` crate.
//!
//! Paper: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017, as implemented by obvhs 0.4. Its builder, node test and
//! traversal are used; primitives are tested by our own sets. See `obvhs_adapter.rs`.

use std::time::Duration;

use glam::UVec2;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};

use super::obvhs_adapter::{
    ALSO_TESTED, BoxRay, Groups, PARAMS, VARIANTS, build_params, is_robust, items, known_defect,
};
use super::{BuildError, Shape, Structure, StructureInfo, refuse_out_of_scale};
use crate::params::Params;
use crate::primitives::PrimSet;
use crate::ray::Ray;
use crate::scalar::Scalar;
use crate::sink::Sink;

/// Registry line.
pub static INFO: StructureInfo = StructureInfo {
    name: "obvhs-cwbvh",
    summary: "compressed 8-wide BVH of the obvhs crate",
    paper: "Ylitie, Karras, Laine 2017; obvhs 0.4",
    deviations: "library code; our primitive tests, our robust ray setup",
    params: PARAMS,
    variants: VARIANTS,
    also_tested: ALSO_TESTED,
    known_defect,
    sampled: false,
};

/// obvhs's traversal stack holds one entry a level and is not checked by it.
const MAX_DEPTH: u32 = 31;

/// obvhs's `CwBvh` over our primitives.
pub struct ObvhsCwBvh<S> {
    bvh: CwBvh,
    groups: Groups,
    robust: bool,
    scalar: std::marker::PhantomData<S>,
}

impl<S: Scalar> Structure<S> for ObvhsCwBvh<S> {
    const DUPLICATES: bool = false;

    fn build<P: PrimSet<S>>(prims: &P, params: &Params) -> Result<Self, BuildError> {
        // obvhs knows f32 alone
        refuse_out_of_scale::<S, f32>(prims.magnitude(), params.structure())?;
        let items = items(prims, params)?;
        let bvh = build_cwbvh(&items.boxes, build_params(params), &mut Duration::default());
        let depth = depth(&bvh);
        if depth > MAX_DEPTH {
            return Err(BuildError::TooLarge {
                structure: params.structure(),
                what: "depth of obvhs's CwBvh",
                needed: u128::from(depth),
                limit: u128::from(MAX_DEPTH),
            });
        }
        let (groups, robust) = (items.groups, is_robust(params));
        Ok(Self { bvh, groups, robust, scalar: std::marker::PhantomData })
    }

    #[inline(always)]
    fn walk<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let mut start =
            if self.robust { BoxRay::robust(ray, true) } else { BoxRay::as_shipped(ray) };
        if self.robust {
            start.ray.tmax = start.bound(sink.t_max());
        }
        let mut ray = start.ray;
        let mut state = self.bvh.new_traversal(ray.direction);
        let mut node;
        'walk: {
            obvhs::traverse!(
                self.bvh,
                node,
                state,
                {
                    sink.inner_step();
                    node.intersect_ray(&ray, state.oct_inv4)
                },
                {
                    sink.elementary_step(false);
                    let item = &self.bvh.primitive_indices[state.primitive_id as usize];
                    if sink.test(self.groups.ids(item)).is_break() {
                        break 'walk;
                    }
                    ray.tmax = start.bound(sink.t_max());
                }
            );
        }
    }

    fn shape(&self) -> Shape {
        let cells = self
            .bvh
            .nodes
            .iter()
            .flat_map(|n| (0..8).map(move |c| (n, c)))
            .filter(|(n, c)| n.is_leaf(*c) && !n.is_child_empty(*c))
            .count();
        let indices = self.bvh.primitive_indices.as_slice();
        Shape {
            inner_cells: self.bvh.nodes.len() as u64,
            cells: cells as u64,
            empty_cells: 0,
            references: indices.iter().map(|i| self.groups.ids(i).len() as u64).sum(),
            resolution: None,
            bytes: (size_of_val(self.bvh.nodes.as_slice()) + size_of_val(indices)) as u64
                + self.groups.bytes(),
            ..Shape::default()
        }
    }
}

/// Levels of nodes.
fn depth(bvh: &CwBvh) -> u32 {
    let mut deepest = 0;
    let mut waiting = if bvh.nodes.is_empty() { vec![] } else { vec![(0u32, 1u32)] };
    while let Some((i, level)) = waiting.pop() {
        deepest = deepest.max(level);
        let node = &bvh.nodes[i as usize];
        waiting.extend((0..node.imask.count_ones()).map(|c| (node.child_base_idx + c, level + 1)));
    }
    deepest
}
