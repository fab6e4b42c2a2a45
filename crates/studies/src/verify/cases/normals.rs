//! Normals of hit points, as the renderer has them, in closed form.

use scene_loading::{Cone, Scene};

use super::secondary::from_hits;
use super::*;
use crate::verify::meshes::{placed, tangled};

/// A shape whose normals are known.
enum KnownNormals {
    Sphere { center: DVec3 },
    Cone(Cone),
    Plane(DVec3),
}

impl KnownNormals {
    fn is_right(&self, at: DVec3, normal: DVec3, slack: f64) -> bool {
        let right = match self {
            Self::Sphere { center } => (at - *center).normalize(),
            Self::Cone(cone) => {
                let axis = cone.apex - cone.base;
                let out = (at - cone.base).reject_from(axis).normalize();
                let slope = (cone.apex_radius - cone.base_radius) / axis.length();
                (out - axis.normalize() * slope).normalize()
            }
            Self::Plane(plane) => *plane * normal.dot(*plane).signum(),
        };
        right.distance(normal) <= slack
    }
}

pub fn normals<S: Buildable>(random: &mut Random, rays: usize) -> RoundResult<S> {
    let at = point(random) * one_of(random, &[0.0, 1.0, 100.0]);
    let (mut scene, material) = Scene::of_one_material("normals");
    // the smallest radius of curvature
    let (known, radius) = match random.below(3) {
        0 => {
            let radius = 10f64.powf(2.0 - 4.0 * unit(random));
            scene.push_sphere(material, at, radius);
            (KnownNormals::Sphere { center: at }, radius)
        }
        1 => {
            let radius = 10f64.powf(-2.0 * unit(random));
            let apex = at + direction(random) * one_of(random, &[1.0, 10.0]);
            let apex_radius = radius * one_of(random, &[1.0, 0.5]);
            let cone = Cone { base: at, base_radius: radius, apex, apex_radius };
            scene.push_cone(material, cone);
            (KnownNormals::Cone(cone), apex_radius)
        }
        _ => {
            let outline = tangled(random);
            let outline = placed(random, &vec![outline], 1.0).concat();
            scene.push_polygon(material, &outline);
            let across = |p: &DVec3| (outline[1] - outline[0]).cross(*p - outline[0]);
            let widest =
                outline.iter().map(across).max_by(|a, b| a.length().total_cmp(&b.length()));
            (KnownNormals::Plane(widest.unwrap_or_default().normalize_or_zero()), 1.0)
        }
    };
    let bounds = scene.bounds();
    let (middle, size) = ((bounds.min + bounds.max) / 2.0, bounds.max - bounds.min);
    let aimed: Vec<Ray<S>> = (0..rays)
        .map(|_| {
            let target = middle + size * point(random) * 0.5;
            let origin = single(target + direction(random) * size.length());
            ray(origin, target - origin)
        })
        .collect();
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element() + size.length();
    let rounding = match known {
        // vertices are rounded to f32
        KnownNormals::Plane(_) => 8.0 * f64::from(f32::EPSILON),
        _ => 256.0 * S::EPSILON.to_f64(),
    };
    let slack = 1e-6 + rounding * reach / radius;
    from_hits(&scene, &aimed, |point, _, round| {
        let leaving = ray(point.position, point.normal);
        let is_right = |normal| known.is_right(point.position, normal, slack);
        let expected = if is_right(point.normal) && is_right(point.refined.normal) {
            OracleAnswer::Anything
        } else {
            OracleAnswer::Broken(format!("the normal is {}", point.normal))
        };
        round.push(leaving, expected);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    #[test]
    fn wrong_normals_are_refuted() {
        let center = dvec3(1.0, 2.0, 3.0);
        let cone =
            Cone { base: center, base_radius: 1.0, apex: center + DVec3::Z, apex_radius: 0.0 };
        let shapes = [
            (KnownNormals::Sphere { center }, DVec3::X, vec![-DVec3::X, dvec3(1.0, 1e-3, 0.0)]),
            // that of a cylinder, and that from within
            (KnownNormals::Cone(cone), dvec3(0.5, 0.0, 0.5).normalize(), vec![DVec3::X, -DVec3::X]),
            (KnownNormals::Plane(DVec3::Z), -DVec3::Z, vec![DVec3::X, DVec3::ZERO]),
        ];
        for (known, right, wrong) in shapes {
            let at = center + dvec3(0.5, 0.0, 0.0);
            assert!(known.is_right(at, right, 1e-6), "{right}");
            assert!(wrong.iter().all(|normal| !known.is_right(at, *normal, 1e-6)), "{wrong:?}");
        }
    }
}
