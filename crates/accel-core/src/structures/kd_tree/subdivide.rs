//! How the cells of a k-d tree are cut: where the heuristic says (`tree/build.rs` builds them).

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::memory::Counted;
use crate::params::config::Settings;
use crate::room::Room;
use crate::structure::BuildError;
use crate::structures::kd_tree::cells::{Cells, DEEPEST, Node};
use crate::structures::kd_tree::config::KdTreeConfig;
use crate::structures::kd_tree::surface_area::{Cut, Heuristic};
use crate::tree::build::{self, Cell, CellStore, Division};

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
        room: Room::new(
            settings.limits(),
            [(&CELLS, settings.max_cells), (&REFERENCES, settings.max_references)],
        ),
    };
    let root = Cell { bounds, depth: 0, descent: 0 };
    build::cells(&rules, root, || (0..boxes.len() as u32).collect())
}

/// A node, and the start of a list.
static CELLS: Counted = Counted::cells("number of cells", 16);
static REFERENCES: Counted = Counted::references("references in cells");

/// What does not change during a build.
struct Rules<'a, S: Scalar> {
    boxes: &'a [Aabb<S>],
    config: &'a KdTreeConfig,
    max_depth: usize,
    room: Room,
}

impl<S: Scalar> Division<S> for Rules<'_, S> {
    type Cells = Cells<S>;
    type Cut = Cut<S>;
    /// Useless cuts.
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
    ) -> Option<(Cut<S>, u64)> {
        if ids.len() <= self.config.max_leaf || cell.depth == self.max_depth {
            return None;
        }
        let cut = heuristic.best_cut(self.boxes, ids, &cell.bounds)?;
        let useless = cell.descent + u64::from(cut.cost >= ids.len() as f64);
        (useless <= self.config.useless_splits).then_some((cut, useless))
    }

    #[inline(always)]
    fn reaches(&self, id: u32, cut: &Cut<S>, side: usize) -> bool {
        let b = &self.boxes[id as usize];
        // boxes are padded: what ends on a plane has no point on its other side
        match side {
            0 => b.min.to_array()[cut.axis] < cut.plane,
            _ => b.max.to_array()[cut.axis] > cut.plane,
        }
    }

    fn child(bounds: &Aabb<S>, cut: &Cut<S>, side: usize) -> Aabb<S> {
        let (mut lo, mut hi) = (bounds.min.to_array(), bounds.max.to_array());
        if side == 0 {
            hi[cut.axis] = cut.plane
        } else {
            lo[cut.axis] = cut.plane
        }
        Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) }
    }

    fn room(&self) -> &Room {
        &self.room
    }
}

impl<S: Scalar> CellStore for Cells<S> {
    type Cut = Cut<S>;

    fn begun() -> Self {
        Self { nodes: vec![Node::leaf(0)], starts: vec![0], ids: Vec::new() }
    }

    fn counts(&self) -> [usize; 2] {
        [self.nodes.len(), self.ids.len()]
    }

    fn divide(&mut self, cell: usize, cut: Cut<S>) -> usize {
        let lower = self.nodes.len();
        self.nodes[cell] = Node::inner(cut.axis, cut.plane, lower);
        self.nodes.resize(lower + 2, Node::leaf(0));
        lower
    }

    fn leaf(&mut self, cell: usize, ids: &[u32]) {
        self.nodes[cell] = Node::leaf(self.starts.len() - 1);
        self.ids.extend_from_slice(ids);
        self.starts.push(self.ids.len() as u32);
    }

    fn append(&mut self, side: usize, below: Self) {
        // how far the cells below the side move
        let (by, leaves, ids) =
            (self.nodes.len() - 1, self.starts.len() - 1, self.ids.len() as u32);
        let moved = |node: &Node<S>| node.moved(by, leaves);
        if let Some(first) = below.nodes.first() {
            self.nodes[1 + side] = moved(first);
        }
        self.nodes.extend(below.nodes.iter().skip(1).map(moved));
        self.starts.extend(below.starts.iter().skip(1).map(|start| start + ids));
        self.ids.extend_from_slice(&below.ids);
    }
}
