//! Reflection by rough mirrors: rays spread about the mirror direction.
//!
//! Papers: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984; the
//! directions are those of microfacets whose normals follow GGX: B. Walter, S. Marschner, H. Li,
//! K. Torrance, "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007.
//! Deviations: a facet reflects the specular share whatever the angle (no Fresnel term), and is
//! hidden by others only where its ray would go into the surface. The first rough mirror of a path
//! spreads `samples` rays, those behind it one each: the lecture's product has the factor once.
//! Refracted rays are not spread.

use scene_loading::Scene;

use super::counts::RayCounts;
use super::effect::{Effect, EffectInfo, counted, used_materials};
use super::sampler::{Pattern, Purpose};
use super::settings::RenderSettings;
use super::stages::{Origin, ScatteredRay, SurfaceHit, WavePosition};
use crate::rays::RayKind;
use crate::shading::surface::reflect;

pub static INFO: EffectInfo = EffectInfo {
    effect: Effect::Gloss,
    name: "glossy reflection",
    paper: "Cook, Porter, Carpenter 1984; Walter et al. 2007",
    called_by,
};

fn called_by(scene: &Scene, settings: &RenderSettings) -> Option<String> {
    let rough = used_materials(scene).filter(|m| m.specular > 0.0 && m.roughness > 0.0).count();
    (rough > 0 && settings.max_depth > 1)
        .then(|| format!("{} with a roughness", counted(rough, "mirror")))
}

/// How rough mirrors are sampled.
#[derive(Debug, Clone, Copy)]
pub struct Lobe {
    /// Rays at the first rough mirror of a path.
    pub samples: u32,
    /// Seed of the directions.
    pub seed: u64,
}

impl Lobe {
    /// Sends the rays of one hit.
    pub fn reflect(
        &self,
        place: WavePosition,
        index: u32,
        hit: &SurfaceHit<'_>,
        out: &mut Vec<ScatteredRay>,
        counts: &mut RayCounts,
    ) {
        let m = hit.point.material;
        // the side that is seen
        let outside = hit.point.normal.dot(hit.incoming) <= 0.0;
        let normal = if outside { hit.point.normal } else { -hit.point.normal };
        let Some(unit) = normal.try_normalize() else { return };
        let (s, t) = unit.any_orthonormal_pair();
        let purpose = Purpose::Facet(place.depth);
        let pattern = Pattern::new(self.seed, [hit.origin.column, place.y], purpose);
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
