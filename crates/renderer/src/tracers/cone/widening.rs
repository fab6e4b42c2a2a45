//! How a cone goes on from a surface: its spread after a curved mirror or a curved interface.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984: the distance to the virtual image
//! by the mirror equation, and the lens equation for refraction. Deviation: oblique cones, too, by
//! Coddington's equations (H. Coddington 1829; M. Born, E. Wolf, *Principles of Optics*, 4.6).
//!
//! Let a cone of radius r and spread s meet a surface at the angle a from the normal. In the plane
//! of incidence its footprint is r / cos a long, so that the normal turns by k r / cos a across it
//! (k is the curvature, above 0 where the surface bulges towards the cone), and a mirrored ray
//! turns twice that: s_t = s + 2 k r / cos a. Across that plane the footprint is r, the normal n
//! turns by k r, and of the mirrored direction d - 2 (d . n) n turns 2 cos a times that:
//! s_s = s + 2 k r cos a. At a = 0 both are the mirror equation: s / r = 1 / (distance of the
//! apex), 1 / d' = 1 / d + 2 / R.
//!
//! Refracted from index m to m' at the angle a': with the vergence v = s / r, m' v_s' = m v - (m'
//! cos a' - m cos a) k and m' cos^2 a' v_t' = m cos^2 a v - (m' cos a' - m cos a) k; across the
//! plane of incidence the radius stays, within it it becomes r cos a' / cos a. At a flat surface
//! and a = 0 this is the derivative of Snell's law: s' = s m / m'.
//!
//! The cone stays round: its spread is the geometric mean of both (the same area), or, where one
//! grows and the other shrinks, the arithmetic mean.

use glam::DVec3;

use crate::surface::Surfaces;

/// The widest cone: half an angle of 45 degrees. What spreads further is seen by its middle.
pub const WIDEST: f64 = 1.0;

/// Cosines below this count as this: the footprint of a grazing cone ends where the surface does.
pub const LEAST_COSINE: f64 = 0.05;

/// A cone where it meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    /// Radius there, world units, >= 0.
    pub radius: f64,
    /// Growth of that radius.
    pub spread: f64,
    /// Cosine of the angle to the normal, from [`LEAST_COSINE`] to 1.
    pub cosine: f64,
    /// Curvatures in the plane of incidence and across it, per world unit; above 0 where the
    /// surface bulges towards the cone.
    pub curvatures: [f64; 2],
}

impl Incidence {
    /// Measures how the normal of a primitive changes across the footprint of a cone.
    /// `direction`: unit, of the axis; `normal`: unit, of shading, at `position`.
    pub fn measure(
        surfaces: &Surfaces<'_>,
        id: u32,
        (position, normal): (DVec3, DVec3),
        direction: DVec3,
        (radius, spread): (f64, f64),
    ) -> Self {
        let along = direction.dot(normal);
        let cosine = along.abs().clamp(LEAST_COSINE, 1.0);
        // seen from the other side, what bulged is hollow
        let side = if along > 0.0 { -1.0 } else { 1.0 };
        let forwards = (direction - normal * along)
            .try_normalize()
            .unwrap_or_else(|| normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_vector());
        let curvature = |way: DVec3| {
            if radius <= 0.0 {
                return 0.0;
            }
            let there = surfaces.at(id, position + way * radius).normal;
            side * (there - normal).dot(way) / radius
        };
        let curvatures = [curvature(forwards), curvature(normal.cross(forwards))];
        Self { radius, spread, cosine, curvatures }
    }

    /// The same on a flat surface.
    pub fn flattened(self) -> Self {
        Self { curvatures: [0.0; 2], ..self }
    }

    /// By how much the normal turns from the axis to the edge of the footprint, radians, about.
    pub fn turn(&self) -> f64 {
        let [along, across] = self.curvatures;
        self.radius * (along / self.cosine).abs().max(across.abs())
    }

    /// Radius and spread of the mirrored cone.
    pub fn mirrored(&self) -> (f64, f64) {
        let Self { radius, spread, cosine, curvatures: [along, across] } = *self;
        let within = spread + 2.0 * radius * along / cosine;
        let aside = spread + 2.0 * radius * across * cosine;
        (radius, mean(within, aside))
    }

    /// Radius and spread of the refracted cone, whose direction has the cosine `refracted` to the
    /// normal; `from` and `to` are the indices on both sides.
    pub fn refracted(&self, refracted: f64, from: f64, to: f64) -> (f64, f64) {
        let ratio = (refracted.abs().clamp(LEAST_COSINE, 1.0) / self.cosine).sqrt();
        let [within, aside] = self.refracted_spreads(refracted, from, to);
        (self.radius * ratio, mean(within, aside))
    }

    /// In the plane of incidence, and across it.
    fn refracted_spreads(&self, refracted: f64, from: f64, to: f64) -> [f64; 2] {
        let Self { radius, spread, cosine, curvatures: [along, across] } = *self;
        let refracted = refracted.abs().clamp(LEAST_COSINE, 1.0);
        // vergences times the radius, which may be 0
        let power = (to * refracted - from * cosine) * radius;
        let aside = (from * spread - power * across) / to;
        let within =
            (from * cosine * cosine * spread - power * along) / (to * refracted * refracted);
        [within * refracted / cosine, aside]
    }
}

/// One spread for two, not wider than [`WIDEST`].
fn mean(a: f64, b: f64) -> f64 {
    let mean = if a * b >= 0.0 { (a * b).sqrt().copysign(a + b) } else { (a + b) / 2.0 };
    mean.clamp(-WIDEST, WIDEST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{reflect, refract};
    use scene_loading::Scene;

    /// Spreads by rays: how directions change across the footprint of a narrow cone that meets the
    /// unit sphere at the angle `a`.
    fn by_rays(a: f64, spread: f64, bend: impl Fn(DVec3, DVec3) -> DVec3) -> [f64; 2] {
        let radius = 1e-5;
        let normal = DVec3::Z;
        let direction = DVec3::new(a.sin(), 0.0, -a.cos());
        let apex = normal - direction * (radius / spread);
        let meet = |d: DVec3| {
            let b = apex.dot(d);
            let t = -b - (b * b - apex.dot(apex) + 1.0).sqrt();
            let p = apex + d * t;
            (p, bend(d, p))
        };
        let across = [direction.cross(DVec3::Y), DVec3::Y];
        across.map(|way| {
            let (_, middle) = meet(direction);
            let (_, edge) = meet((direction + way * spread).normalize());
            (edge - middle).length()
        })
    }

    fn measured(a: f64, spread: f64) -> Incidence {
        let (mut scene, m) = Scene::of_one_material("ball");
        scene.push_sphere(m, DVec3::ZERO, 1.0);
        let surfaces = Surfaces::new(&scene, false);
        let direction = DVec3::new(a.sin(), 0.0, -a.cos());
        Incidence::measure(&surfaces, 0, (DVec3::Z, DVec3::Z), direction, (1e-5, spread))
    }

    #[test]
    fn spreads_are_those_of_rays() {
        for a in [0.0, 0.4, 1.0, 1.3] {
            for spread in [1e-6, 2e-5] {
                let incidence = measured(a, spread);
                assert!((incidence.curvatures[0] - 1.0).abs() < 1e-3);
                let [t, s] = by_rays(a, spread, reflect);
                let (_, found) = incidence.mirrored();
                assert!((found / (t * s).sqrt() - 1.0).abs() < 1e-3, "mirror {a}: {found} {t} {s}");
                // planted fault: a spread that is not widened
                let (_, flat) = incidence.flattened().mirrored();
                assert!((flat / (t * s).sqrt() - 1.0).abs() > 0.1);
                let bent = |d: DVec3, n: DVec3| refract(d, n, 1.5).unwrap();
                let [t, s] = by_rays(a, spread, bent);
                let inside = bent(DVec3::new(a.sin(), 0.0, -a.cos()), DVec3::Z);
                let found = incidence.refracted_spreads(inside.z, 1.0, 1.5);
                for (found, expected) in found.into_iter().zip([t, s]) {
                    let error = (found.abs() - expected).abs() / (t + s);
                    assert!(error < 1e-3, "glass {a} {spread}: {found} {expected}");
                }
                let (radius, _) = incidence.refracted(inside.z, 1.0, 1.5);
                let ratio = (inside.z.abs() / a.cos()).sqrt();
                assert!((radius / 1e-5 / ratio - 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_mirror_equation_and_flat_surfaces() {
        let incidence =
            Incidence { radius: 0.1, spread: 0.02, cosine: 1.0, curvatures: [0.5, 0.5] };
        // the apex at 5, the sphere's radius 2: the image at 1 / (1/5 + 2/2)
        assert!((0.1 / incidence.mirrored().1 - 1.0 / 1.2).abs() < 1e-12);
        let flat = incidence.flattened();
        assert!((flat.mirrored().1 - 0.02).abs() < 1e-15);
        assert!((flat.refracted(1.0, 1.0, 1.5).1 - 0.02 / 1.5).abs() < 1e-15);
    }
}
