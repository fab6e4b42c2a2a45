//! The crate `rtbvh` as a plugin of rtbench: its builders and both layouts, asked through its iterators, with the test
//! of its trait `SpatialTriangle`. It has no query for shadow rays: the iterator is left at the first hit.

use std::num::NonZeroUsize;

use glam::Vec3;
use peer::{Description, Hit, Kind, Peer, Ray, Scene, Setting, Shadows, Stats, Triangle};
use rtbvh::{Aabb, Builder, Bvh, Mbvh, Primitive, Ray as OwnRay, SpatialTriangle};

/// A tree and its triangles.
struct Rtbvh {
    tree: Tree,
    triangles: Vec<Corners>,
    has_own_test: bool,
    /// Whether shadow rays pass; empty where they pass nowhere.
    transmissive: Vec<bool>,
}

enum Tree {
    Binary(Bvh),
    FourWide(Mbvh),
}

/// A triangle as its builders want it.
#[derive(Debug, Clone, Copy)]
struct Corners([Vec3; 3]);

impl Primitive for Corners {
    fn center(&self) -> Vec3 {
        self.0.iter().sum::<Vec3>() / 3.0
    }

    fn aabb(&self) -> Aabb {
        let mut bounds = Aabb::new();
        for corner in self.0 {
            bounds.grow(corner);
        }
        bounds
    }
}

impl SpatialTriangle for Corners {
    fn vertex0(&self) -> Vec3 {
        self.0[0]
    }

    fn vertex1(&self) -> Vec3 {
        self.0[1]
    }

    fn vertex2(&self) -> Vec3 {
        self.0[2]
    }
}

impl Peer for Rtbvh {
    const DESCRIPTION: Description = Description {
        name: "rtbvh",
        library: "rtbvh",
        summary: "rtbvh over rtbench.h",
        settings: &[
            Setting {
                name: "layout",
                summary: "Bvh, or Mbvh: four-wide",
                initial: "mbvh",
                kind: Kind::Choice("bvh mbvh"),
            },
            Setting {
                name: "build",
                summary: "binned SAH, SAH with spatial splits, or locally ordered clustering",
                initial: "locb",
                kind: Kind::Choice("binned spatial locb"),
            },
            Setting {
                name: "leaf",
                summary: "primitives_per_leaf; not of locb",
                initial: "1",
                kind: Kind::Integer(1, 64),
            },
            Setting {
                name: "test",
                summary: "library: SpatialTriangle::intersect; plain: one of ours, without epsilons",
                initial: "library",
                kind: Kind::Choice("library plain"),
            },
        ],
    };
    const SHADOWS: Shadows = Shadows::Filtered;
    const USES_RAYON: bool = true;

    fn build(scene: &Scene<'_>) -> Result<Self, String> {
        let corners = |triangle: &Triangle| Corners(triangle.map(Vec3::from_array));
        let triangles: Vec<Corners> = scene.triangles.iter().map(corners).collect();
        let aabbs: Vec<Aabb> = triangles.iter().map(Primitive::aabb).collect();
        let builder = Builder {
            aabbs: Some(&aabbs),
            primitives: &triangles,
            primitives_per_leaf: NonZeroUsize::new(scene.settings.integer("leaf")),
        };
        let tree = match scene.settings.text("build") {
            "spatial" => builder.construct_spatial_sah(),
            "locb" => builder.construct_locally_ordered_clustered(),
            _ => builder.construct_binned_sah(),
        };
        let tree = tree.map_err(|error| error.to_string())?;
        let flags = 0..scene.transmissive.map_or(0, <[u8]>::len);
        Ok(Self {
            tree: match scene.settings.text("layout") {
                "bvh" => Tree::Binary(tree),
                _ => Tree::FourWide(Mbvh::from(tree)),
            },
            triangles,
            has_own_test: scene.settings.text("test") == "library",
            transmissive: flags.map(|id| scene.is_transmissive(id)).collect(),
        })
    }

    #[inline(always)]
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut own = own(ray);
        match &self.tree {
            Tree::Binary(tree) => self.nearest(ray, tree.traverse_iter_indices(&mut own)),
            Tree::FourWide(tree) => self.nearest(ray, tree.traverse_iter_indices(&mut own)),
        }
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray) -> bool {
        let mut own = own(ray);
        match &self.tree {
            Tree::Binary(tree) => self.any(ray, tree.traverse_iter_indices(&mut own)),
            Tree::FourWide(tree) => self.any(ray, tree.traverse_iter_indices(&mut own)),
        }
    }

    fn stats(&self, stats: &mut Stats) {
        match &self.tree {
            Tree::Binary(tree) => {
                let valid = tree.nodes().iter().filter(|node| node.is_valid());
                let leaves = valid.clone().filter(|node| node.is_leaf());
                stats.references += leaves
                    .clone()
                    .map(|leaf| u64::from(leaf.get_count().unwrap_or(0)))
                    .sum::<u64>();
                let leaves = leaves.count();
                stats.leaves += leaves as u64;
                stats.inner_nodes += (valid.count() - leaves) as u64;
            }
            Tree::FourWide(tree) => {
                stats.inner_nodes += tree.quad_nodes().len() as u64;
                let counts = tree.quad_nodes().iter().flat_map(|node| node.counts);
                let leaves = counts.filter(|count| *count >= 0);
                stats.references += leaves.clone().sum::<i32>() as u64;
                stats.leaves += leaves.count() as u64;
            }
        }
    }
}

impl Rtbvh {
    /// The nearest hit of candidates; whoever traverses is told of each, through the ray.
    #[inline(always)]
    fn nearest<'a>(
        &self,
        ray: &Ray,
        candidates: impl Iterator<Item = (u32, &'a mut OwnRay)>,
    ) -> Option<Hit> {
        let mut best = None;
        for (id, own) in candidates {
            if self.hits(id, own, ray) {
                best = Some(Hit::new(own.t, id));
            }
        }
        best
    }

    /// Whether a candidate is hit that shadow rays do not pass.
    #[inline(always)]
    fn any<'a>(
        &self,
        ray: &Ray,
        mut candidates: impl Iterator<Item = (u32, &'a mut OwnRay)>,
    ) -> bool {
        let passes = |id: u32| self.transmissive.get(id as usize).is_some_and(|passes| *passes);
        candidates.any(|(id, own)| !passes(id) && self.hits(id, own, ray))
    }

    /// Whether a triangle is hit before `own.t`, which then is where.
    #[inline(always)]
    fn hits(&self, id: u32, own: &mut OwnRay, ray: &Ray) -> bool {
        let corners = &self.triangles[id as usize];
        if self.has_own_test {
            return corners.intersect(own);
        }
        let t = peer::triangle::intersect(&corners.0.map(|corner| corner.to_array()), ray, own.t);
        own.t = t.unwrap_or(own.t);
        t.is_some()
    }
}

/// Its interval is open, that of rtbench closed.
#[inline(always)]
fn own(ray: &Ray) -> OwnRay {
    let mut own = OwnRay::new(Vec3::from_array(ray.origin), Vec3::from_array(ray.direction));
    (own.t_min, own.t) = (ray.t_min.next_down(), ray.t_max.next_up());
    own
}

peer::export!(Rtbvh);

#[cfg(test)]
mod tests {
    use peer::trial::{Trial, glass, rays, triangles};

    use super::*;

    #[test]
    fn answers_are_right() {
        let triangles = triangles(3000);
        let glass = glass(3000);
        let rays = rays(1000);
        let of = |settings: &str| {
            let plugin = rtbench_plugin_describe;
            let trial = Trial::build(plugin, &triangles, &glass, settings, 2).unwrap();
            let stats = trial.stats();
            assert!(stats.inner_nodes > 500 && stats.leaves > 1000 && stats.references >= 3000);
            trial.faults(&rays)
        };
        for layout in ["bvh", "mbvh"] {
            let right = of(&format!("layout={layout} build=locb test=plain"));
            assert!(right.sum() == 0 && right.certain > 500, "{layout} {right:?}");
            // its test has an epsilon in world units: some hits of short directions are lost
            let with_its_test = of(&format!("layout={layout} build=locb"));
            assert!(with_its_test.sum() < 10, "{layout} {with_its_test:?}");
            // boxes of left children that are too small, in nodes halved for want of a cheap split
            let binned = of(&format!("layout={layout} build=binned test=plain"));
            assert!((1..10).contains(&binned.elsewhere) && binned.lost == 0, "{layout} {binned:?}");
            // boxes of parts of triangles that are none of theirs
            let spatial = of(&format!("layout={layout} build=spatial test=plain"));
            assert!(spatial.lost > 50 && spatial.elsewhere > 200, "{layout} {spatial:?}");
        }
    }

    /// Triangles that stick out of the box of a node above them, by more than rounding.
    fn sticking_out(tree: &Bvh, aabbs: &[Aabb]) -> usize {
        let (mut waiting, mut found) = (vec![(0, Vec3::MIN, Vec3::MAX)], 0);
        while let Some((at, mut low, mut high)) = waiting.pop() {
            let node = &tree.nodes()[at];
            (low, high) = (low.max(node.bounds.min), high.min(node.bounds.max));
            let first = node.get_left_first_unchecked() as usize;
            match node.get_count() {
                None => waiting.extend([(first, low, high), (first + 1, low, high)]),
                Some(count) => {
                    let ids = &tree.indices()[first..first + count as usize];
                    let boxes = ids.iter().map(|id| &aabbs[*id as usize]);
                    let slack = Vec3::splat(1e-3);
                    let sticks_out = |b: &&Aabb| {
                        b.min.cmplt(low - slack).any() || b.max.cmpgt(high + slack).any()
                    };
                    found += boxes.filter(sticks_out).count();
                }
            }
        }
        found
    }

    #[test]
    fn boxes_of_its_builders() {
        let triangles: Vec<Corners> =
            triangles(3000).iter().map(|t| Corners(t.map(Vec3::from_array))).collect();
        let aabbs: Vec<Aabb> = triangles.iter().map(Primitive::aabb).collect();
        let builder = Builder {
            aabbs: Some(&aabbs),
            primitives: &triangles,
            primitives_per_leaf: NonZeroUsize::new(1),
        };
        let clustered = builder.construct_locally_ordered_clustered().unwrap();
        assert_eq!(sticking_out(&clustered, &aabbs), 0);
        // where no split is cheap a node is halved elsewhere; its left box is that of the split not taken
        // (binned_sah.rs:233 has best_splits[best_axis].count, line 237 split_index)
        let binned = builder.construct_binned_sah().unwrap();
        assert!(sticking_out(&binned, &aabbs) > 0);
    }

    #[test]
    fn what_its_splits_do() {
        // half of a triangle lies at x up to 1: the box of that half ends there, and begins at 0
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(Vec3::from_array);
        let (left, _) = Corners(corners).split(0, 1.0);
        // the point at x = 1 on the edges is (1, 0, 0) and (1, 1, 0); it takes a * t * (b - a) for a + t * (b - a)
        assert_eq!(left.max, Vec3::new(0.0, 2.0, 0.0));
    }
}
