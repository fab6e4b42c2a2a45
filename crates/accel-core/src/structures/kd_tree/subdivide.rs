//! How the cells of a k-d tree are cut: where the heuristic says (`tree/build.rs` builds them).

use crate::capacity::CapacityLimits;
use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vector};
use crate::memory::CountedItem;
use crate::params::config::Settings;
use crate::structure::BuildError;
use crate::structures::kd_tree::surface_area::{CutPlane, DEEPEST, Heuristic, KdTreeConfig};
use crate::tree::build::{self, Cell, Division, Link};

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

pub(super) type Cells<S> = build::Cells<S, Node<S>>;

#[derive(Debug, Clone, Copy)]
pub(super) struct Node<S> {
    /// The plane, if it is an inner cell.
    pub(super) plane: S,
    /// Inner cell: the axis, and above two bits the lower child, which the upper one follows.
    /// Leaf: 3, and above two bits the number of the leaf.
    pub(super) link: u32,
}

impl<S> Node<S> {
    pub(super) const LEAF: u32 = 3;
}

impl<S: Scalar> Link<S> for Node<S> {
    type Cut = CutPlane<S>;
    type Record = ();
    const CHILDREN: usize = 2;

    fn leaf(number: u32) -> Self {
        Self { plane: S::ZERO, link: number << 2 | Self::LEAF }
    }

    fn inner(cut: &CutPlane<S>, number: u32) -> Self {
        Self { plane: cut.plane, link: (1 + 2 * number) << 2 | cut.axis as u32 }
    }

    fn record(_: CutPlane<S>) {}

    fn moved(self, [inner, leaves]: [u32; 2]) -> Self {
        let by = if self.link & 3 == Self::LEAF { leaves } else { 2 * inner };
        Self { link: self.link + (by << 2), ..self }
    }
}

/// Settings that stay constant during a build.
struct Rules<'a, S: Scalar> {
    boxes: &'a [Aabb<S>],
    config: &'a KdTreeConfig,
    max_depth: usize,
    room: CapacityLimits,
}

impl<'a, S: Scalar> Division<S> for Rules<'a, S> {
    type Link = Node<S>;
    type Cut = CutPlane<S>;
    type Descent = u64;
    type Scratch = Heuristic<'a, S>;

    fn scratch(&self) -> Heuristic<'a, S> {
        Heuristic::new(self.config)
    }

    fn cut(
        &self,
        heuristic: &mut Heuristic<'a, S>,
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
        bounds.cut(cut.axis, cut.plane)[side]
    }

    fn room(&self) -> &CapacityLimits {
        &self.room
    }
}
