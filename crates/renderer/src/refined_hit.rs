//! A hit point, put back onto its primitive: what a ray that leaves the surface starts from.
//!
//! Origin + t * direction is off the surface by the rounding of `t`, which grows with the way the
//! ray came. In double precision the point is therefore projected onto the primitive along its
//! normal; what is left is the rounding of the primitive's own coordinates.

use glam::DVec3;
use scene_loading::{Cone, Scene, Shape, Sphere};

/// A point of a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinedHit {
    /// Where, world units.
    pub position: DVec3,
    /// Unit geometric normal, not that of shading; zero where there is none.
    pub normal: DVec3,
    /// The largest coordinate that its primitive is made of, world units, and more for slivers:
    /// where a ray meets the surface is uncertain by a few epsilons of the precision times this.
    pub magnitude: f64,
}

impl RefinedHit {
    /// The hit on the primitive moved by `way`.
    pub fn moved_by(self, way: DVec3) -> Self {
        let (position, magnitude) = (self.position + way, self.magnitude + largest(way));
        Self { position, magnitude, ..self }
    }
}

/// The distance at which a ray meets a triangle is uncertain by the length of the triangle over
/// its height, as all its barycentric coordinates are. This part of (longest side)^3 / (2 area) is
/// added to the magnitude: without it, 6,747 of 26 million rays hit the sliver they left (`rtbench
/// verify --cases S1,S4`); with a quarter of it, none. What goes beyond the size of the scene is
/// computed more precisely (`accel_core::primitives`).
const SLIVER: f64 = 0.125;

/// The point of primitive `id` nearest to `hit`. `polygon_normals` by id, unit; `most` bounds the
/// magnitude of slivers.
pub(crate) fn refined_hit(
    scene: &Scene,
    polygon_normals: &[DVec3],
    most: f64,
    id: u32,
    hit: DVec3,
) -> RefinedHit {
    match scene.primitives[id as usize].shape {
        Shape::Sphere(i) => on_sphere(&scene.spheres[i as usize], hit),
        Shape::Cone(i) => on_cone(&scene.cones[i as usize], hit),
        Shape::Polygon { first, count } => {
            let corners = &scene.vertices[first as usize..][..count as usize];
            if let &[a, b, c] = corners {
                return on_triangle([a, b, c], most, hit);
            }
            let normal = polygon_normals.get(id as usize).copied().unwrap_or(DVec3::ZERO);
            on_plane(corners.iter().copied(), normal, hit)
        }
        Shape::Triangle { v } | Shape::Patch { v, .. } => {
            on_triangle(v.map(|i| scene.vertices[i as usize]), most, hit)
        }
    }
}

/// A ray that grazes a cone may hit it 8 epsilons of its size outside of its surface
/// (`accel_core::primitives::cone`), and a few more are the rounding of its axis and slope: more
/// than the usual offset of 4.
const CONE: f64 = 4.0;

fn largest(p: DVec3) -> f64 {
    p.abs().max_element()
}

fn on_sphere(sphere: &Sphere, hit: DVec3) -> RefinedHit {
    let normal = (hit - sphere.center).normalize_or_zero();
    RefinedHit {
        position: sphere.center + normal * sphere.radius,
        normal,
        magnitude: largest(sphere.center) + sphere.radius,
    }
}

fn on_triangle(corners: [DVec3; 3], most: f64, hit: DVec3) -> RefinedHit {
    let across = normal(corners);
    let refined = on_plane(corners.into_iter(), across.normalize_or_zero(), hit);
    let [a, b, c] = corners;
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let extra = SLIVER * longest * longest * longest / across.length();
    RefinedHit { magnitude: (refined.magnitude + extra).min(most), ..refined }
}

/// The normal of a triangle, not of unit length, right to few ulps for slivers too: the plain cross
/// product would be tilted by their length over their height, and the point beside the plane.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let ((e, e_error), (f, f_error)) = (difference(b, a), difference(c, a));
    let component = |i: usize, j: usize| {
        let (p, q) = (e[i] * f[j], e[j] * f[i]);
        let rounding = e[i].mul_add(f[j], -p) - e[j].mul_add(f[i], -q);
        let errors = e[i] * f_error[j] + e_error[i] * f[j] - e[j] * f_error[i] - e_error[j] * f[i];
        (p - q) + (rounding + errors)
    };
    DVec3::new(component(1, 2), component(2, 0), component(0, 1))
}

/// `a - b`, and what rounding took from it (D. E. Knuth, *The Art of Computer Programming* 2,
/// 4.2.2).
fn difference(a: DVec3, b: DVec3) -> (DVec3, DVec3) {
    let rounded = a - b;
    let of_a = rounded + b;
    let of_b = of_a - rounded;
    (rounded, (a - of_a) + (of_b - b))
}

fn on_plane(corners: impl Iterator<Item = DVec3> + Clone, normal: DVec3, hit: DVec3) -> RefinedHit {
    let anchor = corners.clone().next().unwrap_or(hit);
    RefinedHit {
        position: hit - normal * (hit - anchor).dot(normal),
        normal,
        magnitude: corners.map(largest).fold(largest(hit), f64::max),
    }
}

/// Along the radius; the rim and the apex belong to the side.
fn on_cone(cone: &Cone, hit: DVec3) -> RefinedHit {
    let axis = cone.apex - cone.base;
    let length = axis.length();
    let [base_radius, apex_radius] = [cone.base_radius.abs(), cone.apex_radius.abs()];
    let size = largest(cone.base).max(largest(cone.apex)) + base_radius.max(apex_radius);
    let magnitude = CONE * size;
    if length == 0.0 {
        return RefinedHit { position: hit, normal: DVec3::ZERO, magnitude };
    }
    let unit = axis / length;
    let from_base = hit - cone.base;
    let along = from_base.dot(unit).clamp(0.0, length);
    let radial = (from_base - unit * from_base.dot(unit)).normalize_or_zero();
    let slope = (apex_radius - base_radius) / length;
    RefinedHit {
        position: cone.base + unit * along + radial * (base_radius + slope * along),
        normal: (radial - unit * slope).normalize_or_zero(),
        magnitude,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;
    use scene_loading::Material;

    /// One primitive of each kind, in the shape of a scene.
    fn scene() -> Scene {
        let mut scene = Scene::new("kinds");
        let m = scene.push_material(Material::default());
        scene.push_sphere(m, dvec3(5.0, 0.0, 0.0), 2.0);
        let cone =
            Cone { base: DVec3::ZERO, base_radius: 2.0, apex: DVec3::Z * 4.0, apex_radius: 1.0 };
        scene.push_cone(m, cone);
        scene
    }

    #[test]
    fn the_refined_hit_is_on_the_surface_and_the_normal_stands_on_it() {
        let scene = scene();
        let on_ball = refined_hit(&scene, &[], 9.0, 0, dvec3(7.1, 0.0, 0.0));
        assert_eq!((on_ball.position, on_ball.normal), (dvec3(7.0, 0.0, 0.0), DVec3::X));
        assert_eq!(on_ball.magnitude, 7.0);
        let on_side = refined_hit(&scene, &[], 9.0, 1, dvec3(1.6, 0.0, 2.0));
        assert!((on_side.position - dvec3(1.5, 0.0, 2.0)).length() < 1e-15);
        // the side runs from (2, 0) to (1, 4)
        assert!(on_side.normal.dot(dvec3(-1.0, 0.0, 4.0)).abs() < 1e-15 && on_side.normal.x > 0.0);
        let corners = [dvec3(0.0, 3.0, 0.0), dvec3(9.0, 3.0, 0.0), dvec3(0.0, 3.0, -1.0)];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let on_floor = on_plane(corners.into_iter(), normal, dvec3(1.0, 3.01, -0.1));
        assert_eq!(on_floor.position, dvec3(1.0, 3.0, -0.1));
        assert_eq!(on_floor.magnitude, 9.0);
    }
}
