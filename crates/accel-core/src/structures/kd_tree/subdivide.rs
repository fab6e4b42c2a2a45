//! How a k-d tree is built: depth first, each cell cut where the heuristic says; the sides of the
//! first cuts at once.

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::memory::Counted;
use crate::parallel::{forks, is_worth_a_fork};
use crate::params::config::Settings;
use crate::room::Room;
use crate::structure::BuildError;
use crate::structures::kd_tree::KdTreeConfig;
use crate::structures::kd_tree::cells::{Cells, DEEPEST, Node};
use crate::structures::kd_tree::surface_area::{Cut, Heuristic};

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
    let root = || Task { ids: (0..boxes.len() as u32).collect(), bounds, depth: 0, useless: 0 };
    match forks() {
        0 => rules.alone(root()),
        // which limit is broken, and by how much, is what one thread finds
        forks => rules.forked(root(), forks).or_else(|_| rules.alone(root())),
    }
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

/// A cell that is to be divided, by itself.
struct Task<S: Scalar> {
    ids: Vec<u32>,
    bounds: Aabb<S>,
    depth: usize,
    useless: u64,
}

impl<S: Scalar> Rules<'_, S> {
    /// The cells below a task, on this thread.
    fn alone(&self, task: Task<S>) -> Result<Cells<S>, BuildError> {
        let mut builder = Builder {
            rules: self,
            heuristic: Heuristic::new(self.config),
            cells: Cells { nodes: vec![Node::leaf(0)], starts: vec![0], ids: Vec::new() },
            waiting: task.ids,
        };
        builder.cell(0, task.bounds, task.depth, 0, task.useless)?;
        Ok(builder.cells)
    }

    /// The same with both sides of a cut at once, `forks` times one below the other.
    fn forked(&self, task: Task<S>, forks: u32) -> Result<Cells<S>, BuildError> {
        if forks == 0 || !is_worth_a_fork(task.ids.len()) {
            return self.alone(task);
        }
        let mut heuristic = Heuristic::new(self.config);
        let decided = self.cut(&mut heuristic, &task.ids, &task.bounds, task.depth, task.useless);
        let Some((cut, useless)) = decided else { return self.alone(task) };
        let side = |side: usize| {
            let inside = |id: &u32| self.is_inside(*id, &cut, side);
            let ids = task.ids.iter().copied().filter(inside).collect();
            let bounds = half(&task.bounds, &cut, side);
            self.forked(Task { ids, bounds, depth: task.depth + 1, useless }, forks - 1)
        };
        let (lower, upper) = rayon::join(|| side(0), || side(1));
        let cells = Cells::joined(&cut, lower?, &upper?);
        self.room.check([cells.nodes.len() as u64, cells.ids.len() as u64])?;
        Ok(cells)
    }

    /// Where to cut a cell, and the useless cuts on the way to it with that one; `None` makes it a
    /// leaf.
    fn cut(
        &self,
        heuristic: &mut Heuristic<S>,
        ids: &[u32],
        bounds: &Aabb<S>,
        depth: usize,
        useless: u64,
    ) -> Option<(Cut<S>, u64)> {
        if ids.len() <= self.config.max_leaf || depth == self.max_depth {
            return None;
        }
        let cut = heuristic.best_cut(self.boxes, ids, bounds)?;
        let useless = useless + u64::from(cut.cost >= ids.len() as f64);
        (useless <= self.config.useless_splits).then_some((cut, useless))
    }

    /// Whether a primitive reaches to a side of a cut.
    #[inline(always)]
    fn is_inside(&self, id: u32, cut: &Cut<S>, side: usize) -> bool {
        let b = &self.boxes[id as usize];
        // boxes are padded: what ends on a plane has no point on its other side
        match side {
            0 => b.min.to_array()[cut.axis] < cut.plane,
            _ => b.max.to_array()[cut.axis] > cut.plane,
        }
    }
}

/// One side of a cell that is cut.
fn half<S: Scalar>(bounds: &Aabb<S>, cut: &Cut<S>, side: usize) -> Aabb<S> {
    let (mut lo, mut hi) = (bounds.min.to_array(), bounds.max.to_array());
    if side == 0 {
        hi[cut.axis] = cut.plane
    } else {
        lo[cut.axis] = cut.plane
    }
    Aabb { min: Vec3::<S>::from_array(lo), max: Vec3::<S>::from_array(hi) }
}

impl<S: Scalar> Cells<S> {
    /// A cell that is cut, with the cells below it where a build from top to bottom has them: both
    /// sides, then all below the lower one, then all below the upper one.
    fn joined(cut: &Cut<S>, mut lower: Self, upper: &Self) -> Self {
        let (leaves, ids) = (lower.starts.len() - 1, lower.ids.len() as u32);
        // how far the cells below a side move
        let (of_lower, of_upper) = (2, lower.nodes.len() + 1);
        let mut nodes = Vec::with_capacity(1 + lower.nodes.len() + upper.nodes.len());
        nodes.push(Node::inner(cut.axis, cut.plane, 1));
        let from_lower = |node: &Node<S>| node.moved(of_lower, 0);
        let from_upper = |node: &Node<S>| node.moved(of_upper, leaves);
        nodes.extend(lower.nodes.first().map(from_lower));
        nodes.extend(upper.nodes.first().map(from_upper));
        nodes.extend(lower.nodes.iter().skip(1).map(from_lower));
        nodes.extend(upper.nodes.iter().skip(1).map(from_upper));
        lower.starts.extend(upper.starts.iter().skip(1).map(|start| start + ids));
        lower.ids.extend_from_slice(&upper.ids);
        Self { nodes, starts: lower.starts, ids: lower.ids }
    }
}

struct Builder<'a, S: Scalar> {
    rules: &'a Rules<'a, S>,
    heuristic: Heuristic<S>,
    cells: Cells<S>,
    /// References of the cells on the way from the first, one list after the other.
    waiting: Vec<u32>,
}

impl<S: Scalar> Builder<'_, S> {
    /// Makes `cell` of the references `waiting[from..]`, which it takes away.
    fn cell(
        &mut self,
        cell: usize,
        bounds: Aabb<S>,
        depth: usize,
        from: usize,
        useless: u64,
    ) -> Result<(), BuildError> {
        let end = self.waiting.len();
        let ids = &self.waiting[from..];
        let decided = self.rules.cut(&mut self.heuristic, ids, &bounds, depth, useless);
        let Some((cut, useless)) = decided else { return self.leaf(cell, from) };
        let lower = self.cells.nodes.len();
        self.rules.room.check([lower as u64 + 2, self.cells.ids.len() as u64])?;
        self.cells.nodes[cell] = Node::inner(cut.axis, cut.plane, lower);
        self.cells.nodes.resize(lower + 2, Node::leaf(0));
        for side in 0..2 {
            for i in from..end {
                let id = self.waiting[i];
                if self.rules.is_inside(id, &cut, side) {
                    self.waiting.push(id);
                }
            }
            self.cell(lower + side, half(&bounds, &cut, side), depth + 1, end, useless)?;
        }
        self.waiting.truncate(from);
        Ok(())
    }

    fn leaf(&mut self, cell: usize, from: usize) -> Result<(), BuildError> {
        let references = self.cells.ids.len() + self.waiting.len() - from;
        self.rules.room.check([self.cells.nodes.len() as u64, references as u64])?;
        self.cells.nodes[cell] = Node::leaf(self.cells.starts.len() - 1);
        self.cells.ids.extend_from_slice(&self.waiting[from..]);
        self.cells.starts.push(references as u32);
        self.waiting.truncate(from);
        Ok(())
    }
}
