//! The crate `parry3d` as a plugin of rtbench: its `TriMesh`, or a `Bvh` of its other builder, and its own test of
//! triangles. What its `TriMesh::cast_local_ray` does is done with its `Bvh::cast_ray`, as that tells
//! which triangle is hit, and lets hits before `t_min` be left out.

use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, TraversalAction};
use parry3d::query::{Ray as OwnRay, RayCast};
use parry3d::shape::{TriMesh, Triangle as OwnTriangle};
use peer::{Description, Hit, Kind, Peer, Ray, Scene, Setting, Shadows, Stats};

/// A tree over triangles.
enum Parry {
    Mesh(TriMesh),
    Tree { tree: Bvh, vertices: Vec<Vector>, triangles: Vec<[u32; 3]> },
}

impl Peer for Parry {
    const DESCRIPTION: Description = Description {
        name: "parry3d",
        library: "parry3d",
        summary: "parry3d over rtbench.h",
        settings: &[Setting {
            name: "build",
            summary: "binned SAH, which its TriMesh has, or PLOC, for a Bvh alone",
            initial: "binned",
            kind: Kind::Choice("binned ploc"),
        }],
    };
    const SHADOWS: Shadows = Shadows::None;
    const ASKS_INDICES: bool = true;
    const USES_RAYON: bool = false;

    fn build(scene: &Scene<'_>) -> Result<Self, String> {
        let indexed = scene.indexed.ok_or("there are no indices")?;
        let vertices: Vec<Vector> =
            indexed.vertices.iter().map(|v| Vector::from_array(*v)).collect();
        let triangles = indexed.triangles.to_vec();
        if scene.settings.text("build") == "binned" {
            let mesh = TriMesh::new(vertices, triangles);
            return mesh.map(Self::Mesh).map_err(|error| error.to_string());
        }
        let boxes =
            (0..triangles.len()).map(|id| (id, triangle(&vertices, &triangles, id).local_aabb()));
        let tree = Bvh::from_iter(BvhBuildStrategy::Ploc, boxes);
        Ok(Self::Tree { tree, vertices, triangles })
    }

    #[inline(always)]
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self {
            Self::Mesh(mesh) => closest(ray, mesh.bvh(), |id| mesh.triangle(id)),
            Self::Tree { tree, vertices, triangles } => {
                closest(ray, tree, |id| triangle(vertices, triangles, id as usize))
            }
        }
    }

    fn stats(&self, stats: &mut Stats) {
        let tree = match self {
            Self::Mesh(mesh) => mesh.bvh(),
            Self::Tree { tree, .. } => tree,
        };
        // the root has no box, and is not shown
        stats.inner_nodes += u64::from(tree.leaf_count() > 1);
        tree.traverse(|node| {
            if node.is_leaf() {
                stats.leaves += 1;
                stats.references += 1;
            } else {
                stats.inner_nodes += 1;
            }
            TraversalAction::Continue
        });
    }
}

/// Its interval is open at its end, that of rtbench closed.
#[inline(always)]
fn closest(ray: &Ray, tree: &Bvh, triangle: impl Fn(u32) -> OwnTriangle) -> Option<Hit> {
    let own = OwnRay::new(Vector::from_array(ray.origin), Vector::from_array(ray.direction));
    let hit = tree.cast_ray(&own, ray.t_max.next_up(), |id, best| {
        triangle(id).cast_local_ray(&own, best, true).filter(|t| *t >= ray.t_min)
    });
    hit.map(|(id, t)| Hit::new(t, id))
}

#[inline(always)]
fn triangle(vertices: &[Vector], triangles: &[[u32; 3]], id: usize) -> OwnTriangle {
    let [a, b, c] = triangles[id].map(|vertex| vertices[vertex as usize]);
    OwnTriangle::new(a, b, c)
}

peer::export!(Parry);

#[cfg(test)]
mod tests {
    use peer::trial::{Trial, rays, triangles};

    #[test]
    fn answers_are_right() {
        let triangles = triangles(3000);
        let rays = rays(1000);
        for build in ["binned", "ploc"] {
            let plugin = super::rtbench_plugin_describe;
            let settings = format!("build={build}");
            let trial = Trial::build(plugin, &triangles, &[], &settings, 1).unwrap();
            let stats = trial.stats();
            assert_eq!([stats.inner_nodes, stats.leaves, stats.references], [2999, 3000, 3000]);
            let faults = trial.faults(&rays);
            assert!(faults.sum() == 0 && faults.certain > 500, "{build} {faults:?}");
        }
    }
}
