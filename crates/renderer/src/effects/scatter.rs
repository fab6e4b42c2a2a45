//! The stage that sends reflected and refracted rays on.
//!
//! Papers: T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980
//! (mirrors, and refraction by Snell's law, with total reflection beyond the critical angle);
//! R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984 (rays spread about the
//! mirror direction); the directions are those of microfacets whose normals follow GGX: B. Walter,
//! S. Marschner, H. Li, K. Torrance, "Microfacet Models for Refraction through Rough Surfaces", EGSR
//! 2007.
//! Deviations, as in NFF: whatever transmits also mirrors, by its specular share; no Fresnel term;
//! bodies are not nested (outside is vacuum). A facet is hidden by others only where its ray would
//! go into the surface. The first rough mirror of a path spreads `samples` rays, those behind it one
//! each: the lecture's product has the factor once. Refracted rays are not spread.

use super::effect::Effect;
use super::sampler::{Pattern, Purpose};
use super::stages::{Origin, RayCounts, ScatterStage, ScatteredRay, Wave};
use crate::rays::RayKind;
use crate::surface::{reflect, refract};

/// Sends rays on. What a scene has nothing of is not compiled in: `GLASS` refracts, `ROUGH`
/// spreads the rays of rough mirrors.
pub struct Scatter<const GLASS: bool, const ROUGH: bool>(pub Lobe);

impl<const GLASS: bool, const ROUGH: bool> ScatterStage for Scatter<GLASS, ROUGH> {
    fn scatter(&self, wave: Wave<'_>, out: &mut Vec<ScatteredRay>, counts: &mut RayCounts) {
        let (mut mirrored, mut refracted) = (0, 0);
        for (hit, index) in wave.hits.iter().zip(0..) {
            let m = hit.point.material;
            let normal = hit.point.normal;
            let ray = |kind, direction, share: f64| {
                let weight = hit.weight.map(|w| w * share);
                ScatteredRay { hit: index, kind, direction, weight, origin: hit.origin }
            };
            if ROUGH && m.roughness > 0.0 && m.specular > 0.0 {
                self.0.reflect(wave, index, out, counts);
            } else if m.specular > 0.0 || (GLASS && m.transmittance > 0.0) {
                out.push(ray(RayKind::Reflected, reflect(hit.incoming, normal), m.specular));
                mirrored += 1;
            }
            if GLASS && m.transmittance > 0.0 {
                match refract(hit.incoming, normal, m.refraction_index) {
                    Some(direction) => {
                        out.push(ray(RayKind::Refracted, direction, m.transmittance));
                        refracted += 1;
                    }
                    None => counts.total_internal_reflections += 1,
                }
            }
        }
        counts.add_effect(Effect::Mirror, mirrored);
        counts.add_effect(Effect::Refraction, refracted);
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Lobe {
    /// Rays at the first rough mirror of a path.
    pub samples: u32,
    pub seed: u64,
}

impl Lobe {
    /// Sends the rays of one hit.
    pub fn reflect(
        &self,
        wave: Wave<'_>,
        index: u32,
        out: &mut Vec<ScatteredRay>,
        counts: &mut RayCounts,
    ) {
        let hit = &wave.hits[index as usize];
        let m = hit.point.material;
        // the side that is seen
        let outside = hit.point.normal.dot(hit.incoming) <= 0.0;
        let normal = if outside { hit.point.normal } else { -hit.point.normal };
        let Some(unit) = normal.try_normalize() else { return };
        let (s, t) = unit.any_orthonormal_pair();
        let purpose = Purpose::Facet(wave.depth);
        let pattern = Pattern::new(self.seed, [hit.origin.column, wave.y], purpose);
        let (begin, samples) = if hit.origin.fanned {
            (hit.origin.sample, 1)
        } else {
            (hit.origin.sample.wrapping_mul(self.samples), self.samples)
        };
        let share = m.specular / f64::from(samples);
        let before = out.len();
        for k in 0..samples {
            let sample = begin.wrapping_add(k);
            let u = pattern.square(sample);
            // tan^2 of the angle between facet and surface (Walter et al., equation 35)
            let tan2 = m.roughness * m.roughness * u.x / (1.0 - u.x);
            let cos = 1.0 / (1.0 + tan2).sqrt();
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let (y, x) = (u.y * std::f64::consts::TAU).sin_cos();
            let facet = s * (sin * x) + t * (sin * y) + unit * cos;
            let direction = reflect(hit.incoming, facet);
            if direction.dot(unit) <= 0.0 {
                continue;
            }
            out.push(ScatteredRay {
                hit: index,
                kind: RayKind::Reflected,
                direction,
                weight: hit.weight.map(|w| w * share),
                origin: Origin { sample, fanned: true, ..hit.origin },
            });
        }
        counts.add_effect(Effect::Gloss, out.len() - before);
    }
}
