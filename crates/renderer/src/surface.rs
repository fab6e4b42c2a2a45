//! Surfaces at hit points: the point put back onto its primitive, from which rays leave; normals;
//! directions of reflected and refracted rays.
//!
//! Origin + t * direction is off the surface by the rounding of `t`, which grows with the way the
//! ray came. In double precision the point is therefore projected onto the primitive along its
//! normal; what is left is the rounding of the primitive's own coordinates.
//!
//! Paper: B. T. Phong, "Illumination for Computer Generated Pictures", CACM 18(6), 1975 (normals
//! interpolated between the vertices of a patch).

use accel_core::primitives::newell_normal;
use glam::DVec3;
use scene_loading::{Cone, Material, Rgb, Scene, Shape, Sphere};

/// Looks up normals and materials of a scene after a hit.
pub struct Surfaces<'a> {
    scene: &'a Scene,
    /// Newell normals of polygons, by primitive id; computed once because outlines are long.
    polygon_normals: Vec<DVec3>,
    historical_cones: bool,
    /// Bounds the magnitude of slivers: twice the scene's largest coordinate.
    most: f64,
}

#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint<'a> {
    pub position: DVec3,
    /// Unit shading normal on the outer side (interpolated on patches); zero where there is none.
    pub normal: DVec3,
    pub material: &'a Material,
    /// The colour here: that of the material, unless a stage has found another one.
    pub color: Rgb,
    /// The point of the primitive itself, with its geometric normal.
    pub refined: RefinedHit,
}

impl<'a> Surfaces<'a> {
    /// `historical_cones` takes the cone normal that Havran's program took, in which the axis
    /// length is missing.
    pub fn new(scene: &'a Scene, historical_cones: bool) -> Self {
        let any_polygon = scene.primitives.iter().any(|p| matches!(p.shape, Shape::Polygon { .. }));
        let normals = scene.primitives.iter().map(|p| newell(scene, p.shape));
        let polygon_normals = if any_polygon { normals.collect() } else { Vec::new() };
        let most = 2.0 * scene.bounds().reach();
        Self { scene, polygon_normals, historical_cones, most }
    }

    /// The surface at `position` of primitive `id`.
    pub fn at(&self, id: u32, position: DVec3) -> SurfacePoint<'a> {
        let scene = self.scene;
        let primitive = scene.primitives[id as usize];
        let (normal, refined) = match primitive.shape {
            Shape::Sphere(i) => {
                let refined = on_sphere(&scene.spheres[i as usize], position);
                (refined.normal, refined)
            }
            Shape::Cone(i) => {
                let cone = &scene.cones[i as usize];
                (self.cone_normal(cone, position), on_cone(cone, position))
            }
            Shape::Polygon { first, count } => {
                let normal = self.polygon_normals[id as usize];
                let corners = &scene.vertices[first as usize..][..count as usize];
                let refined = match *corners {
                    [a, b, c] => on_triangle([a, b, c], self.most, position),
                    _ => on_plane(corners.iter().copied(), normal, position),
                };
                (normal, refined)
            }
            Shape::Triangle { v } => {
                let corners @ [a, b, c] = v.map(|i| scene.vertices[i as usize]);
                let normal = (b - a).cross(c - a).normalize_or_zero();
                (normal, on_triangle(corners, self.most, position))
            }
            Shape::Patch { v, n } => {
                let corners = v.map(|i| scene.vertices[i as usize]);
                let normal = patch_normal(corners, n.map(|i| scene.normals[i as usize]), position);
                (normal, on_triangle(corners, self.most, position))
            }
        };
        let material = &scene.materials[primitive.material as usize];
        SurfacePoint { position, normal, material, color: material.color, refined }
    }

    fn cone_normal(&self, cone: &Cone, position: DVec3) -> DVec3 {
        let outer = if self.historical_cones {
            let slope = (cone.apex_radius - cone.base_radius) / cone.base_radius;
            let Some((unit, _, radial, _)) = around(cone, position) else { return DVec3::ZERO };
            (radial - unit * slope).normalize_or_zero()
        } else {
            on_cone(cone, position).normal
        };
        if cone.base_radius + cone.apex_radius < 0.0 { -outer } else { outer }
    }
}

/// The interpolated normal of a patch; that of its face where it has none there.
fn patch_normal(corners: [DVec3; 3], [na, nb, nc]: [DVec3; 3], position: DVec3) -> DVec3 {
    let Some([wa, wb, wc]) = barycentric(corners, position) else {
        return na.normalize_or_zero();
    };
    let [a, b, c] = corners;
    let face = (b - a).cross(c - a);
    (na * wa + nb * wb + nc * wc).normalize_or(face.normalize_or_zero())
}

/// Barycentric weights of a point in the plane of a triangle; `None` if it has no area.
#[inline]
pub fn barycentric([a, b, c]: [DVec3; 3], position: DVec3) -> Option<[f64; 3]> {
    let face = (b - a).cross(c - a);
    let area = face.dot(face);
    if area == 0.0 {
        return None;
    }
    let wa = (c - b).cross(position - b).dot(face) / area;
    let wb = (a - c).cross(position - c).dot(face) / area;
    Some([wa, wb, 1.0 - wa - wb])
}

fn newell(scene: &Scene, shape: Shape) -> DVec3 {
    let Shape::Polygon { first, count } = shape else { return DVec3::ZERO };
    newell_normal(&scene.vertices[first as usize..][..count as usize])
}

/// Mirror direction of `d` at a surface with unit normal `n` (either side).
pub fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    d - n * (2.0 * d.dot(n))
}

/// Refracted direction of the unit vector `d` by Snell's law at a surface with unit *outer* normal
/// `n`; `index` is that of the inside, the outside has 1. `None` on total internal reflection.
pub fn refract(d: DVec3, n: DVec3, index: f64) -> Option<DVec3> {
    let cos = d.dot(n);
    let (n, eta) = if cos < 0.0 { (n, 1.0 / index) } else { (-n, index) };
    let cos_in = cos.abs();
    let k = 1.0 - eta * eta * (1.0 - cos_in * cos_in);
    (k >= 0.0).then(|| d * eta + n * (eta * cos_in - k.sqrt()))
}

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

/// A ray that grazes a cone may hit it 8 epsilons of its size outside of its surface
/// (`accel_core::primitives::cone`), and a few more are the rounding of its axis and slope: more
/// than the usual offset of 4.
const CONE: f64 = 4.0;

pub(crate) fn largest(p: DVec3) -> f64 {
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

/// The unit axis of a cone and its length, the unit radius that a point lies on, and how far along
/// the axis it lies; none of a cone without a length.
fn around(cone: &Cone, point: DVec3) -> Option<(DVec3, f64, DVec3, f64)> {
    let axis = cone.apex - cone.base;
    let length = axis.length();
    let unit = axis / length;
    let from_base = point - cone.base;
    let along = from_base.dot(unit);
    (length > 0.0).then(|| (unit, length, (from_base - unit * along).normalize_or_zero(), along))
}

/// Along the radius; the rim and the apex belong to the side.
fn on_cone(cone: &Cone, hit: DVec3) -> RefinedHit {
    let [base_radius, apex_radius] = [cone.base_radius.abs(), cone.apex_radius.abs()];
    let size = largest(cone.base).max(largest(cone.apex)) + base_radius.max(apex_radius);
    let magnitude = CONE * size;
    let Some((unit, length, radial, along)) = around(cone, hit) else {
        return RefinedHit { position: hit, normal: DVec3::ZERO, magnitude };
    };
    let slope = (apex_radius - base_radius) / length;
    let along = along.clamp(0.0, length);
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

    #[test]
    fn snell_and_the_critical_angle() {
        let n = DVec3::Y;
        let angle = |a: f64| DVec3::new(a.sin(), -a.cos(), 0.0);
        let inside = refract(angle(0.5), n, 1.5).unwrap();
        assert!((inside.x - 0.5f64.sin() / 1.5).abs() < 1e-12 && inside.y < 0.0);
        // back out again: the same angle
        let out = refract(inside, -n, 1.5).unwrap();
        assert!((out.x - 0.5f64.sin()).abs() < 1e-12);
        // leaving the dense side: beyond asin(1/1.5) nothing gets out
        let critical = (1.0f64 / 1.5).asin();
        let up = |a: f64| DVec3::new(a.sin(), a.cos(), 0.0);
        assert!(refract(up(critical - 1e-9), n, 1.5).is_some());
        assert!(refract(up(critical + 1e-9), n, 1.5).is_none());
        assert_eq!(reflect(DVec3::new(1.0, -1.0, 0.0), n), DVec3::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn cone_normals_right_and_historical() {
        let (mut scene, m) = Scene::of_one_material("cone");
        let (base, apex) = (DVec3::ZERO, DVec3::Z * 4.0);
        scene.push_cone(m, Cone { base, base_radius: 2.0, apex, apex_radius: 1.0 });
        let p = DVec3::new(1.5, 0.0, 2.0);
        let right = Surfaces::new(&scene, false).at(0, p).normal;
        // perpendicular to the side from (2, 0) to (1, 4)
        assert!(right.dot(DVec3::new(-1.0, 0.0, 4.0)).abs() < 1e-12 && right.x > 0.0);
        let old = Surfaces::new(&scene, true).at(0, p).normal;
        assert!((old - DVec3::new(1.0, 0.0, 0.5).normalize()).length() < 1e-12);
    }

    #[test]
    fn the_refined_hit_is_on_the_surface_and_the_normal_stands_on_it() {
        let (mut scene, m) = Scene::of_one_material("kinds");
        scene.push_sphere(m, dvec3(5.0, 0.0, 0.0), 2.0);
        let cone =
            Cone { base: DVec3::ZERO, base_radius: 2.0, apex: DVec3::Z * 4.0, apex_radius: 1.0 };
        scene.push_cone(m, cone);
        let surfaces = Surfaces::new(&scene, false);
        let on_ball = surfaces.at(0, dvec3(7.1, 0.0, 0.0)).refined;
        assert_eq!((on_ball.position, on_ball.normal), (dvec3(7.0, 0.0, 0.0), DVec3::X));
        assert_eq!(on_ball.magnitude, 7.0);
        let on_side = surfaces.at(1, dvec3(1.6, 0.0, 2.0)).refined;
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
