//! How the cells of a k-d tree are cut: where the heuristic says (`tree/build.rs` builds them).

use crate::capacity::CapacityLimits;
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::grid::cell_lists::CellLists;
use crate::memory::CountedItem;
use crate::parallel::concat;
use crate::params::config::Settings;
use crate::structure::BuildError;
use crate::structures::kd_tree::surface_area::{CutPlane, DEEPEST, Heuristic, KdTreeConfig};
use crate::tree::build::{self, Cell, CellStore, Division, Step, joined_lists};

/// Builds the cells over boxes of primitives, on all threads of the current rayon pool; the same
/// cells in the same places for any number of threads.
pub(super) fn cells<S: Scalar>(
    boxes: &[Aabb<S>],
    bounds: Aabb<S>,
    settings: &Settings<KdTreeConfig>,
) -> Result<Cells<S>, BuildError> {
    let max_depth = match settings.max_depth {
        0 => (8.0 + 1.3 * (boxes.len().max(1) as f64).log2()) as usize,
        depth => depth,
    };
    let rules = Rules {
        boxes,
        config: settings,
        max_depth: max_depth.min(DEEPEST),
        room: CapacityLimits::new(
            settings.limits(),
            [(&CELLS, settings.max_cells), (&REFERENCES, settings.max_references)],
        ),
    };
    let root = Cell { bounds, depth: 0, descent: 0 };
    build::cells(&rules, root, (0..boxes.len() as u32).collect())
}

/// A node, and the start of a list.
static CELLS: CountedItem = CountedItem::cells("number of cells", 16);
static REFERENCES: CountedItem = CountedItem::references("references in cells");

/// The cells; cell 0 is the root.
#[derive(Debug, Clone, Default)]
pub(super) struct Cells<S> {
    pub(super) nodes: Vec<Node<S>>,
    /// The references of leaves.
    pub(super) lists: CellLists,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Node<S> {
    /// The plane, if it is an inner cell.
    pub(super) plane: S,
    /// Inner cell: the axis, and above two bits the lower child, which the upper one follows.
    /// Leaf: 3, and above two bits the number of the leaf.
    pub(super) link: u32,
}

impl<S: Scalar> Node<S> {
    pub(super) const LEAF: u32 = 3;

    pub(super) fn leaf(number: usize) -> Self {
        Self { plane: S::ZERO, link: (number as u32) << 2 | Self::LEAF }
    }

    pub(super) fn inner(axis: usize, plane: S, lower: usize) -> Self {
        Self { plane, link: (lower as u32) << 2 | axis as u32 }
    }

    /// The same after cells have moved by `cells`, and leaves have got numbers higher by `leaves`.
    pub(super) fn moved(self, cells: usize, leaves: usize) -> Self {
        let by = if self.link & 3 == Self::LEAF { leaves } else { cells };
        Self { link: self.link + ((by as u32) << 2), ..self }
    }
}

/// Settings that stay constant during a build.
struct Rules<'a, S: Scalar> {
    boxes: &'a [Aabb<S>],
    config: &'a KdTreeConfig,
    max_depth: usize,
    room: CapacityLimits,
}

impl<S: Scalar> Division<S> for Rules<'_, S> {
    type Cells = Cells<S>;
    type Cut = CutPlane<S>;
    type Descent = u64;
    type Scratch = Heuristic<S>;
    const CHILDREN: usize = 2;

    fn scratch(&self) -> Heuristic<S> {
        Heuristic::new(self.config)
    }

    fn cut(
        &self,
        heuristic: &mut Heuristic<S>,
        ids: &[u32],
        cell: &Cell<S, u64>,
    ) -> Option<(CutPlane<S>, u64)> {
        if ids.len() <= self.config.max_leaf || cell.depth == self.max_depth {
            return None;
        }
        let cut = heuristic.best_cut(self.boxes, ids, &cell.bounds)?;
        let useless = cell.descent + u64::from(cut.cost >= ids.len() as f64);
        (useless <= self.config.useless_splits).then_some((cut, useless))
    }

    #[inline(always)]
    fn reaches(&self, id: u32, cut: &CutPlane<S>, side: usize) -> bool {
        let b = &self.boxes[id as usize];
        // boxes are padded: what ends on a plane has no point on its other side
        match side {
            0 => b.min.to_array()[cut.axis] < cut.plane,
            _ => b.max.to_array()[cut.axis] > cut.plane,
        }
    }

    fn child(bounds: &Aabb<S>, cut: &CutPlane<S>, side: usize) -> Aabb<S> {
        let (mut lo, mut hi) = (bounds.min.to_array(), bounds.max.to_array());
        if side == 0 {
            hi[cut.axis] = cut.plane
        } else {
            lo[cut.axis] = cut.plane
        }
        Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) }
    }

    fn room(&self) -> &CapacityLimits {
        &self.room
    }
}

impl<S: Scalar> CellStore for Cells<S> {
    type Cut = CutPlane<S>;

    fn begun() -> Self {
        Self { nodes: vec![Node::leaf(0)], lists: CellLists::none() }
    }

    fn counts(&self) -> [usize; 2] {
        [self.nodes.len(), self.lists.references()]
    }

    fn divide(&mut self, cell: usize, cut: CutPlane<S>) -> usize {
        let lower = self.nodes.len();
        self.nodes[cell] = Node::inner(cut.axis, cut.plane, lower);
        self.nodes.resize(lower + 2, Node::leaf(0));
        lower
    }

    fn leaf(&mut self, cell: usize, ids: &[u32]) {
        self.nodes[cell] = Node::leaf(self.lists.cells());
        self.lists.push(ids);
    }

    fn joined(steps: &[Step<Self>]) -> Self {
        let moved = |node: Node<S>, by: [usize; 2]| node.moved(by[0], by[1]);
        let leaf = [Node::leaf(0); 2];
        let mut nodes = vec![(&leaf[..1], [0; 2])];
        // the nodes that stand for children, and where the next nodes and leaves stand
        let (mut firsts, mut next, mut leaves) = (Vec::new(), 1, 0);
        for step in steps {
            match step {
                Step::Divide(cell, cut) => {
                    firsts.push((*cell, Node::inner(cut.axis, cut.plane, next)));
                    nodes.push((&leaf, [0; 2]));
                    next += 2;
                }
                Step::Below(cell, below) => {
                    let by = [next - 1, leaves];
                    firsts.push((*cell, moved(below.nodes[0], by)));
                    nodes.push((&below.nodes[1..], by));
                    next += below.nodes.len() - 1;
                    leaves += below.lists.cells();
                }
            }
        }
        let mut nodes = concat(&nodes, &moved);
        firsts.into_iter().for_each(|(cell, node)| nodes[cell] = node);
        Self { nodes, lists: joined_lists(steps, |cells| &cells.lists) }
    }
}
