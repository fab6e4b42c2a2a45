//! The crate `obvhs` as a plugin of rtbench: its trees over its triangles, built and asked as its examples do.
//!
//! rtbench's own rows `obvhs-bvh2` and `obvhs-cwbvh` do the same within it, so the two tell
//! what the interface costs.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray as OwnRay, RayHit, safe_inverse};
use obvhs::rt_triangle::{RtCompressedTriangle, RtTriangle};
use obvhs::triangle::Triangle as OwnTriangle;
use peer::{Description, Hit, Kind, Peer, Ray, Scene, Setting, Shadows, Stats};

/// A tree and its triangles.
struct Obvhs {
    tree: Tree,
    triangles: Triangles,
    /// Of each triangle of a leaf, whether shadow rays pass; empty where they pass nowhere.
    transmissive: Vec<bool>,
}

enum Tree {
    Binary(Bvh2),
    EightWide(CwBvh),
}

/// In the order of the leaves.
enum Triangles {
    ForCpu(Vec<RtTriangle>),
    Plain(Vec<OwnTriangle>),
    Compressed(Vec<RtCompressedTriangle>),
}

/// Binds the tree and the triangles of their kinds.
macro_rules! with {
    ($self:ident, |$tree:ident, $triangles:ident| $do:expr) => {
        match (&$self.tree, &$self.triangles) {
            (Tree::Binary($tree), Triangles::ForCpu($triangles)) => $do,
            (Tree::Binary($tree), Triangles::Plain($triangles)) => $do,
            (Tree::Binary($tree), Triangles::Compressed($triangles)) => $do,
            (Tree::EightWide($tree), Triangles::ForCpu($triangles)) => $do,
            (Tree::EightWide($tree), Triangles::Plain($triangles)) => $do,
            (Tree::EightWide($tree), Triangles::Compressed($triangles)) => $do,
        }
    };
}

impl Peer for Obvhs {
    const DESCRIPTION: Description = Description {
        name: if cfg!(feature = "small-nodes") { "obvhs-small" } else { "obvhs-crate" },
        library: "obvhs",
        summary: if cfg!(feature = "small-nodes") {
            "obvhs over rtbench.h, compiled with small_bvh2_node"
        } else {
            "obvhs over rtbench.h"
        },
        settings: &[
            Setting {
                name: "layout",
                summary: "Bvh2, or CwBvh: eight-wide, compressed",
                // small nodes are those of the binary tree
                initial: if cfg!(feature = "small-nodes") { "bvh2" } else { "cwbvh" },
                kind: Kind::Choice("bvh2 cwbvh"),
            },
            Setting {
                name: "preset",
                summary: "of its builder",
                initial: "medium",
                kind: Kind::Choice("fastest very-fast fast medium slow very-slow"),
            },
            Setting {
                name: "triangles",
                summary: "RtTriangle, Triangle, or RtCompressedTriangle, whose edges are of 16 bits",
                initial: "rt",
                kind: Kind::Choice("rt plain compressed"),
            },
        ],
    };
    const SHADOWS: Shadows = Shadows::Filtered;
    const USES_RAYON: bool = true;

    fn build(scene: &Scene<'_>) -> Result<Self, String> {
        let corner = |triangle: &peer::Triangle| {
            let [v0, v1, v2] = triangle.map(Vec3A::from_array);
            OwnTriangle { v0, v1, v2 }
        };
        let triangles: Vec<OwnTriangle> = scene.triangles.iter().map(corner).collect();
        let (preset, time) = (preset(scene.settings.text("preset")), &mut Duration::default());
        let tree = match scene.settings.text("layout") {
            "bvh2" => Tree::Binary(build_bvh2_from_tris(&triangles, preset, time)),
            _ => Tree::EightWide(build_cwbvh_from_tris(&triangles, preset, time)),
        };
        let ids = match &tree {
            Tree::Binary(tree) => &tree.primitive_indices,
            Tree::EightWide(tree) => &tree.primitive_indices,
        };
        let in_order = ids.iter().map(|id| &triangles[*id as usize]);
        let is_transmissive = |id: &u32| scene.is_transmissive(*id as usize);
        let flags = ids.iter().filter(|_| scene.transmissive.is_some()).map(is_transmissive);
        Ok(Self {
            transmissive: flags.collect(),
            triangles: match scene.settings.text("triangles") {
                "plain" => Triangles::Plain(in_order.copied().collect()),
                "compressed" => Triangles::Compressed(in_order.map(Into::into).collect()),
                _ => Triangles::ForCpu(in_order.map(Into::into).collect()),
            },
            tree,
        })
    }

    #[inline(always)]
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = RayHit::none();
        with!(self, |tree, triangles| {
            let is_hit =
                tree.ray_traverse(own(ray), &mut hit, |ray, at| triangles[at].intersect(ray));
            is_hit.then(|| Hit::new(hit.t, tree.primitive_indices[hit.primitive_id as usize]))
        })
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray) -> bool {
        with!(self, |tree, triangles| {
            if self.transmissive.is_empty() {
                return !tree.ray_traverse_miss(own(ray), |ray, at| triangles[at].intersect(ray));
            }
            !tree.ray_traverse_miss(own(ray), |ray, at| match triangles[at].intersect(ray) {
                t if t < ray.tmax && self.transmissive[at] => f32::INFINITY,
                t => t,
            })
        })
    }

    fn stats(&self, stats: &mut Stats) {
        match &self.tree {
            Tree::Binary(tree) => {
                let leaves = tree.nodes.iter().filter(|node| node.is_leaf()).count();
                stats.inner_nodes += (tree.nodes.len() - leaves) as u64;
                stats.leaves += leaves as u64;
                stats.references += tree.primitive_indices.len() as u64;
            }
            Tree::EightWide(tree) => {
                let children = tree.nodes.iter().flat_map(|node| (0..8).map(move |i| (node, i)));
                let leaves =
                    children.filter(|(node, i)| node.is_leaf(*i) && !node.is_child_empty(*i));
                stats.inner_nodes += tree.nodes.len() as u64;
                stats.leaves += leaves.count() as u64;
                stats.references += tree.primitive_indices.len() as u64;
            }
        }
    }
}

fn preset(name: &str) -> BvhBuildParams {
    match name {
        "fastest" => BvhBuildParams::fastest_build(),
        "very-fast" => BvhBuildParams::very_fast_build(),
        "fast" => BvhBuildParams::fast_build(),
        "slow" => BvhBuildParams::slow_build(),
        "very-slow" => BvhBuildParams::very_slow_build(),
        _ => BvhBuildParams::medium_build(),
    }
}

/// As its `Ray::new` makes it, which in debug builds panics where a ray is not finite.
#[inline(always)]
fn own(ray: &Ray) -> OwnRay {
    OwnRay {
        origin: Vec3A::from_array(ray.origin),
        direction: Vec3A::from_array(ray.direction),
        inv_direction: Vec3A::from_array(ray.direction.map(safe_inverse)),
        tmin: ray.t_min,
        tmax: ray.t_max,
    }
}

peer::export!(Obvhs);

#[cfg(test)]
mod tests {
    use peer::trial::{Trial, glass, rays, triangles};

    #[test]
    fn answers_are_right() {
        let triangles = triangles(3000);
        let glass = glass(3000);
        // its eight-wide tree knows no hits before t = 1e-4: not all rays are that short
        let all = rays(1000);
        let rays: Vec<_> = all
            .iter()
            .filter(|ray| ray.direction.iter().all(|x| x.abs() < 10.0))
            .copied()
            .collect();
        let of = |settings: &str, transmissive: &[u8]| {
            let plugin = super::rtbench_plugin_describe;
            let trial = Trial::build(plugin, &triangles, transmissive, settings, 2).unwrap();
            let stats = trial.stats();
            assert!(stats.inner_nodes > 100 && stats.references >= 3000 && stats.leaves > 500);
            trial.faults(&rays)
        };
        for layout in ["bvh2", "cwbvh"] {
            for preset in ["fastest", "very-fast", "fast", "medium", "slow", "very-slow"] {
                let faults = of(&format!("layout={layout} preset={preset}"), &glass);
                assert!(faults.sum() == 0 && faults.certain > 500, "{layout} {preset} {faults:?}");
            }
            for triangles in ["rt", "plain"] {
                let faults = of(&format!("layout={layout} triangles={triangles}"), &[]);
                assert_eq!(faults.sum(), 0, "{layout} {triangles} {faults:?}");
            }
            // edges of 16 bits: elsewhere, but there
            let faults = of(&format!("layout={layout} triangles=compressed"), &[]);
            assert!(faults.elsewhere > 0 && faults.lost < 20 && faults.invented < 20, "{faults:?}");
        }
    }

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn what_intersect_embree_returns() {
        use super::*;
        // at t = 3; the determinant is 4
        let triangle = RtTriangle::new(Vec3A::ZERO, Vec3A::X * 2.0, Vec3A::Y * 2.0);
        let ray = OwnRay::new_inf(Vec3A::new(0.5, 0.5, 3.0), -Vec3A::Z);
        assert_eq!([triangle.intersect(&ray), triangle.intersect_embree(&ray)], [3.0, 12.0]);
    }
}
