//! Shading of hit points: normals, directions of reflected and refracted rays.

use accel_core::primitives::newell_normal;
use glam::DVec3;
use scene_loading::{Material, Rgb, Scene, Shape};

use super::refined_hit::{RefinedHit, refined_hit};

/// Looks up normals and materials of a scene after a hit.
pub struct Surfaces<'a> {
    scene: &'a Scene,
    /// Newell normals of polygons, by primitive id; computed once because outlines are long.
    polygon_normals: Vec<DVec3>,
    historical_cones: bool,
    /// No primitive counts as larger: twice the scene's largest coordinate.
    most: f64,
}

/// A point on a surface.
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
        let bounds = scene.bounds();
        let most = 2.0 * bounds.min.abs().max(bounds.max.abs()).max_element();
        Self { scene, polygon_normals, historical_cones, most }
    }

    /// The surface at `position` of primitive `id`.
    pub fn at(&self, id: u32, position: DVec3) -> SurfacePoint<'a> {
        let primitive = self.scene.primitives[id as usize];
        let normal = match primitive.shape {
            Shape::Sphere(i) => {
                (position - self.scene.spheres[i as usize].center).normalize_or_zero()
            }
            Shape::Cone(i) => self.cone_normal(i, position),
            Shape::Polygon { .. } => self.polygon_normals[id as usize],
            Shape::Triangle { v } => {
                let [a, b, c] = v.map(|i| self.scene.vertices[i as usize]);
                (b - a).cross(c - a).normalize_or_zero()
            }
            Shape::Patch { v, n } => self.patch_normal(v, n, position),
        };
        let material = &self.scene.materials[primitive.material as usize];
        let refined = refined_hit(self.scene, &self.polygon_normals, self.most, id, position);
        SurfacePoint { position, normal, material, color: material.color, refined }
    }

    fn cone_normal(&self, index: u32, position: DVec3) -> DVec3 {
        let c = self.scene.cones[index as usize];
        let axis = c.apex - c.base;
        let length = axis.length();
        if length == 0.0 {
            return DVec3::ZERO;
        }
        let w = axis / length;
        let from_base = position - c.base;
        let radial = (from_base - w * from_base.dot(w)).normalize_or_zero();
        let slope = if self.historical_cones {
            (c.apex_radius - c.base_radius) / c.base_radius
        } else {
            (c.apex_radius.abs() - c.base_radius.abs()) / length
        };
        let outer = (radial - w * slope).normalize_or_zero();
        if c.base_radius + c.apex_radius < 0.0 { -outer } else { outer }
    }

    fn patch_normal(&self, v: [u32; 3], n: [u32; 3], position: DVec3) -> DVec3 {
        let [a, b, c] = v.map(|i| self.scene.vertices[i as usize]);
        let [na, nb, nc] = n.map(|i| self.scene.normals[i as usize]);
        let face = (b - a).cross(c - a);
        let Some([wa, wb, wc]) = barycentric([a, b, c], position) else {
            return na.normalize_or_zero();
        };
        (na * wa + nb * wb + nc * wc).normalize_or(face.normalize_or_zero())
    }
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

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut scene = Scene::new("cone");
        let m = scene.push_material(Material::default());
        let (base, apex) = (DVec3::ZERO, DVec3::Z * 4.0);
        scene.push_cone(m, scene_loading::Cone { base, base_radius: 2.0, apex, apex_radius: 1.0 });
        let p = DVec3::new(1.5, 0.0, 2.0);
        let right = Surfaces::new(&scene, false).at(0, p).normal;
        // perpendicular to the side from (2, 0) to (1, 4)
        assert!(right.dot(DVec3::new(-1.0, 0.0, 4.0)).abs() < 1e-12 && right.x > 0.0);
        let old = Surfaces::new(&scene, true).at(0, p).normal;
        assert!((old - DVec3::new(1.0, 0.0, 0.5).normalize()).length() < 1e-12);
    }
}
