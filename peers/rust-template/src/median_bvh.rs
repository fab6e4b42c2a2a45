//! A binary hierarchy of boxes: the longest axis of a node is halved at the median.

use rtbench::accel_core::prelude::*;

config! {
    /// How a tree is built.
    pub struct MedianBvhConfig {
        /// most primitives of a leaf
        leaf: usize = ParamSpec::integer("leaf", "4", 1, 64),
    }
}

/// What tables, `rtbench list` and the parser of settings say of it.
pub static INFO: StructureInfo = StructureInfo {
    params: MedianBvhConfig::PARAMS,
    // what is measured where nothing is said; and what `verify --also-tested` goes through besides
    variants: &["", "leaf=8"],
    also_tested: &["leaf=1", "leaf=64"],
    ..StructureInfo::new("median-bvh", "binary BVH, halved at the median of the longest axis")
};

/// Nodes in the order of a traversal that goes to the first child first.
pub struct MedianBvh<S: Scalar> {
    nodes: Vec<Node<S>>,
    ids: Vec<u32>,
}

struct Node<S: Scalar> {
    bounds: Aabb<S>,
    /// Of a leaf: its first id. Of an inner node: its second child; the first one is the next node.
    first: usize,
    /// Ids of a leaf; 0 for an inner node.
    count: usize,
    /// The axis that was halved.
    axis: usize,
}

impl<S: Scalar> Structure<S> for MedianBvh<S> {
    // no id is in two leaves: mailboxes have nothing to spare
    const DUPLICATES: bool = false;

    type Config = MedianBvhConfig;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<MedianBvhConfig>,
    ) -> Result<Self, BuildError> {
        let structure = settings.structure();
        if prims.is_empty() {
            return Err(BuildError::NoPrimitives { structure });
        }
        // padded boxes: rounding must not lose a hit
        let boxes = BoundsOf::new(prims, BoundsRule::Padded)
            .map_err(|id| BuildError::NonFiniteBounds { structure, id })?;
        let mut ids: Vec<u32> = (0..prims.len() as u32).collect();
        let mut nodes = Vec::new();
        divide(&boxes, settings.leaf, &mut nodes, &mut ids, 0);
        Ok(Self { nodes, ids })
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        // halves: no node lies deeper than 32
        let mut waiting = [0; 64];
        let mut left = 1;
        while left > 0 {
            left -= 1;
            let at = waiting[left];
            let node = &self.nodes[at];
            // no further than the best hit so far, which the sink knows
            if node.bounds.clip(ray.origin, ray.direction, ray.t_min, sink.t_max()).is_none() {
                continue;
            }
            if node.count > 0 {
                sink.elementary_step(false);
                if sink.test(&self.ids[node.first..node.first + node.count]).is_break() {
                    return;
                }
                continue;
            }
            sink.inner_step();
            let (near, far) = match ray.direction.to_array()[node.axis] < S::ZERO {
                true => (node.first, at + 1),
                false => (at + 1, node.first),
            };
            waiting[left] = far;
            waiting[left + 1] = near;
            left += 2;
        }
    }

    fn stats(&self) -> StructureStats {
        let leaves = self.nodes.iter().filter(|node| node.count > 0).count() as u64;
        StructureStats {
            inner_cells: self.nodes.len() as u64 - leaves,
            cells: leaves,
            references: self.ids.len() as u64,
            bytes: (size_of_val(&*self.nodes) + size_of_val(&*self.ids)) as u64,
            ..StructureStats::default()
        }
    }
}

/// Adds the node over these ids, which are those from `first` on, and all nodes below it.
fn divide<S: Scalar>(
    boxes: &BoundsOf<'_, S>,
    leaf: usize,
    nodes: &mut Vec<Node<S>>,
    ids: &mut [u32],
    first: usize,
) {
    let bounds = ids.iter().fold(Aabb::empty(), |all: Aabb<S>, &id| all.union(boxes.of(id)));
    let size = bounds.size().to_array();
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let at = nodes.len();
    nodes.push(Node { bounds, first, count: ids.len(), axis });
    if ids.len() <= leaf {
        return;
    }
    let middle = ids.len() / 2;
    let center = |id: u32| {
        let bounds = boxes.of(id);
        (bounds.min + bounds.max).to_array()[axis].to_f64()
    };
    ids.select_nth_unstable_by(middle, |&a, &b| center(a).total_cmp(&center(b)).then(a.cmp(&b)));
    let (low, high) = ids.split_at_mut(middle);
    divide(boxes, leaf, nodes, low, first);
    (nodes[at].first, nodes[at].count) = (nodes.len(), 0);
    divide(boxes, leaf, nodes, high, first + middle);
}

#[cfg(test)]
mod tests {
    use rtbench::measurement::record::Verdict;
    use rtbench::measurement::settings::{Precision, RunSettings};

    use super::*;

    #[test]
    fn every_answer_is_right() {
        // triangles alone, and primitives of all kinds
        let row = |leaf| INFO.defaults().set("leaf", leaf).unwrap().label();
        let mut settings = RunSettings {
            scenes: ["tetra", "mount", "tree"].map(String::from).to_vec(),
            structures: [1, 4, 64].map(row).to_vec(),
            ..RunSettings::default()
        };
        (settings.measuring.quick, settings.measuring.rounds) = (true, Some(1));
        for precision in [Precision::F32, Precision::F64] {
            settings.measuring.precision = precision;
            let record = rtbench::measure(&[entry!(MedianBvh, INFO)], &settings).unwrap();
            let rows: Vec<_> = record.scenes.iter().flat_map(|scene| &scene.rows).collect();
            assert_eq!(rows.len(), 9);
            for row in rows {
                assert_eq!(row.verdict, Verdict::Ok, "{} {:?}", row.settings, row.example);
            }
        }
    }
}
