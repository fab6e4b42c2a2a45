//! The crate `bvh` as a plugin of rtbench: its `Bvh` and `FlatBvh`, all of its ways to go through them, and its own
//! triangle test. None of these ways knows of the best hit so far, and none asks for any hit: what they
//! yield is left when it cannot matter any more.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BHValue, BoundingHierarchy};
use bvh::bvh::{Bvh, BvhNode};
use bvh::flat_bvh::FlatBvh;
use bvh::ray::Ray as OwnRay;
use nalgebra::{Point3, RealField, Vector3};
use peer::{Description, Hit, Kind, Peer, Ray, Scene, Setting, Shadows, Stats};

/// `f32` or `f64`.
trait Number: peer::triangle::Number + BHValue + RealField {}

impl Number for f32 {}
impl Number for f64 {}

/// A triangle, as its builder wants it.
#[derive(Debug, Clone, Copy)]
struct Shape<T: Number> {
    corners: [Point3<T>; 3],
    id: u32,
    is_transmissive: bool,
    node: usize,
}

impl<T: Number> Bounded<T, 3> for Shape<T> {
    fn aabb(&self) -> Aabb<T, 3> {
        let [a, b, c] = self.corners;
        Aabb::empty().grow(&a).grow(&b).grow(&c)
    }
}

impl<T: Number> BHShape<T, 3> for Shape<T> {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

/// A tree and its triangles.
struct BvhPeer<T: Number> {
    tree: Tree<T>,
    way: Way,
    shapes: Vec<Shape<T>>,
    has_own_test: bool,
}

enum Tree<T: Number> {
    Nodes(Bvh<T, 3>),
    Flat(FlatBvh<T, 3>),
}

/// How the tree is gone through.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Nearest,
    NearestChild,
    Iterator,
    List,
}

/// A ray in the crate's terms: of unit length.
struct Asked<T: Number> {
    ray: OwnRay<T, 3>,
    /// Of the direction that rtbench gave.
    length: T,
    original: Ray<T>,
}

impl<T: Number> Peer<T> for BvhPeer<T> {
    const DESCRIPTION: Description = Description {
        name: "bvh-rs",
        library: "bvh",
        summary: "the crate bvh over rtbench.h",
        settings: &[
            Setting {
                name: "traverse",
                summary: "nearest_traverse_iterator, until boxes begin behind the best hit; all that \
                          nearest_child_traverse_iterator, traverse_iterator or traverse yields; \
                          traverse of a FlatBvh",
                initial: "nearest",
                kind: Kind::Choice("nearest nearest-child iterator list flat"),
            },
            Setting {
                name: "test",
                summary: "library: Ray::intersects_triangle, for each side; plain: one of ours, without epsilons",
                initial: "library",
                kind: Kind::Choice("library plain"),
            },
        ],
    };
    const SHADOWS: Shadows = Shadows::Filtered;
    const USES_RAYON: bool = true;

    fn build(scene: &Scene<'_, T>) -> Result<Self, String> {
        let shape = |(id, triangle): (usize, &peer::Triangle<T>)| Shape {
            corners: triangle.map(Point3::from),
            id: id as u32,
            is_transmissive: scene.is_transmissive(id),
            node: 0,
        };
        let mut shapes: Vec<Shape<T>> = scene.triangles.iter().enumerate().map(shape).collect();
        let tree = match scene.threads {
            1 => Bvh::build(&mut shapes),
            _ => Bvh::build_par(&mut shapes),
        };
        let way = match scene.settings.text("traverse") {
            "nearest-child" => Way::NearestChild,
            "iterator" => Way::Iterator,
            "list" | "flat" => Way::List,
            _ => Way::Nearest,
        };
        let is_flat = scene.settings.text("traverse") == "flat";
        let tree = if is_flat { Tree::Flat(tree.flatten()) } else { Tree::Nodes(tree) };
        Ok(Self { tree, way, shapes, has_own_test: scene.settings.text("test") == "library" })
    }

    #[inline(always)]
    fn closest(&self, ray: &Ray<T>) -> Option<Hit<T>> {
        let asked = Asked::new(ray);
        let (ray, shapes) = (&asked.ray, &self.shapes[..]);
        match &self.tree {
            Tree::Nodes(tree) => match self.way {
                Way::Nearest => {
                    self.nearest(&asked, true, tree.nearest_traverse_iterator(ray, shapes))
                }
                Way::NearestChild => {
                    self.nearest(&asked, false, tree.nearest_child_traverse_iterator(ray, shapes))
                }
                Way::Iterator => self.nearest(&asked, false, tree.traverse_iterator(ray, shapes)),
                Way::List => self.nearest(&asked, false, tree.traverse(ray, shapes)),
            },
            Tree::Flat(tree) => self.nearest(&asked, false, tree.traverse(ray, shapes)),
        }
    }

    #[inline(always)]
    fn occluded(&self, ray: &Ray<T>) -> bool {
        let asked = Asked::new(ray);
        let (ray, shapes) = (&asked.ray, &self.shapes[..]);
        match &self.tree {
            Tree::Nodes(tree) => match self.way {
                Way::NearestChild => {
                    self.any(&asked, tree.nearest_child_traverse_iterator(ray, shapes))
                }
                // order is of no use here
                Way::Nearest | Way::Iterator => {
                    self.any(&asked, tree.traverse_iterator(ray, shapes))
                }
                Way::List => self.any(&asked, tree.traverse(ray, shapes)),
            },
            Tree::Flat(tree) => self.any(&asked, tree.traverse(ray, shapes)),
        }
    }

    fn stats(&self, stats: &mut Stats) {
        let (nodes, leaves) = match &self.tree {
            Tree::Nodes(tree) => {
                let is_leaf = |node: &&BvhNode<T, 3>| matches!(node, BvhNode::Leaf { .. });
                (tree.nodes.len(), tree.nodes.iter().filter(is_leaf).count())
            }
            Tree::Flat(tree) => (tree.len(), tree.iter().filter(|node| node.is_leaf()).count()),
        };
        stats.inner_nodes += (nodes - leaves) as u64;
        stats.leaves += leaves as u64;
        stats.references += leaves as u64;
    }
}

impl<T: Number> Asked<T> {
    #[inline(always)]
    fn new(ray: &Ray<T>) -> Self {
        let direction = Vector3::from(ray.direction);
        let own = OwnRay::new(Point3::from(ray.origin), direction);
        Self { ray: own, length: direction.norm(), original: *ray }
    }
}

impl<T: Number> BvhPeer<T> {
    /// The nearest hit of candidates. If they are sorted, none is looked at whose box begins behind it.
    #[inline(always)]
    fn nearest<'a>(
        &self,
        asked: &Asked<T>,
        are_sorted: bool,
        candidates: impl IntoIterator<Item = &'a Shape<T>>,
    ) -> Option<Hit<T>> {
        let mut best: Option<Hit<T>> = None;
        for shape in candidates {
            let t_max = best.map_or(asked.original.t_max, |hit| hit.t);
            if are_sorted {
                let entry = asked.ray.intersection_slice_for_aabb(&shape.aabb());
                if entry.is_some_and(|(entry, _)| entry > t_max * asked.length) {
                    break;
                }
            }
            if let Some(t) = self.hit(shape, asked, t_max) {
                best = Some(Hit::new(t, shape.id));
            }
        }
        best
    }

    /// Whether a candidate is hit that shadow rays do not pass.
    #[inline(always)]
    fn any<'a>(
        &self,
        asked: &Asked<T>,
        candidates: impl IntoIterator<Item = &'a Shape<T>>,
    ) -> bool {
        let blocks = |shape: &Shape<T>| {
            !shape.is_transmissive && self.hit(shape, asked, asked.original.t_max).is_some()
        };
        candidates.into_iter().any(blocks)
    }

    #[inline(always)]
    fn hit(&self, shape: &Shape<T>, asked: &Asked<T>, t_max: T) -> Option<T> {
        let [a, b, c] = &shape.corners;
        if !self.has_own_test {
            let corners = shape.corners.map(|corner| [corner.x, corner.y, corner.z]);
            return peer::triangle::intersect(&corners, &asked.original, t_max);
        }
        // it hits front sides alone
        let front = asked.ray.intersects_triangle(a, b, c).distance;
        let distance = match front.is_finite() {
            true => front,
            false => asked.ray.intersects_triangle(a, c, b).distance,
        };
        let t = distance / asked.length;
        (distance.is_finite() && t >= asked.original.t_min && t <= t_max).then_some(t)
    }
}

peer::export!(BvhPeer<f32>, BvhPeer<f64>);

#[cfg(test)]
mod tests {
    use peer::trial::{Trial, glass, rays, triangles};

    use super::*;

    #[test]
    fn answers_are_right() {
        let triangles = triangles(3000);
        let glass = glass(3000);
        let rays = rays(1000);
        let doubled = triangles.iter().map(|t| t.map(|corner| corner.map(f64::from)));
        let doubled: Vec<peer::Triangle<f64>> = doubled.collect();
        let double = |ray: &Ray| Ray {
            origin: ray.origin.map(f64::from),
            t_min: ray.t_min.into(),
            direction: ray.direction.map(f64::from),
            t_max: ray.t_max.into(),
        };
        let doubled_rays: Vec<Ray<f64>> = rays.iter().map(double).collect();
        for way in ["nearest", "nearest-child", "iterator", "list", "flat"] {
            for test in ["library", "plain"] {
                let settings = format!("traverse={way} test={test}");
                let plugin = rtbench_plugin_describe;
                let trial = Trial::build(plugin, &triangles, &glass, &settings, 2).unwrap();
                let stats = trial.stats();
                assert_eq!([stats.leaves, stats.references], [3000; 2]);
                let faults = trial.faults(&rays);
                assert!(faults.sum() == 0 && faults.certain > 500, "{settings} {faults:?}");
                let trial = Trial::build(plugin, &doubled, &glass, &settings, 2).unwrap();
                let faults = trial.faults(&doubled_rays);
                assert!(faults.sum() == 0 && faults.certain > 500, "{settings} f64 {faults:?}");
            }
        }
    }

    #[test]
    fn its_test_loses_small_triangles() {
        // a determinant below f32::EPSILON: sides of 3.4e-4 are too short
        let ray = |size: f32| Ray {
            origin: [0.2 * size, 0.2 * size, 1.0],
            t_min: 0.0,
            direction: [0.0, 0.0, -1.0],
            t_max: f32::INFINITY,
        };
        let found = |size: f32, test: &str| {
            let triangles = [[[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]]];
            let plugin = rtbench_plugin_describe;
            let trial = Trial::build(plugin, &triangles, &[], test, 1).unwrap();
            trial.closest(&[ray(size)])[0].id == 0
        };
        assert!(found(4e-4, "") && !found(3e-4, "") && found(3e-4, "test=plain"));
    }
}
