//! Mirror reflection, and the stage that sends all reflected and refracted rays on.
//!
//! Paper: T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980.
//! Deviation: as in NFF, whatever transmits also mirrors, by its specular share.

use scene_loading::Scene;

use super::counts::RayCounts;
use super::effect::{Effect, EffectInfo, counted, used_materials};
use super::gloss::Lobe;
use super::settings::RenderSettings;
use super::stages::{ScatterStage, ScatteredRay, SurfaceHit, WavePosition};
use crate::rays::RayKind;
use crate::shading::surface::{reflect, refract};

pub static INFO: EffectInfo = EffectInfo {
    effect: Effect::Mirror,
    name: "mirror reflection",
    paper: "Whitted 1980",
    called_by,
};

fn called_by(scene: &Scene, settings: &RenderSettings) -> Option<String> {
    let mirrors = used_materials(scene)
        .filter(|m| (m.specular > 0.0 && m.roughness <= 0.0) || m.transmittance > 0.0)
        .count();
    (mirrors > 0 && settings.max_depth > 1)
        .then(|| format!("{} without a roughness", counted(mirrors, "mirror")))
}

/// Sends rays on. What a scene has nothing of is not compiled in: `GLASS` refracts, `ROUGH`
/// spreads the rays of rough mirrors.
pub struct Scatter<const GLASS: bool, const ROUGH: bool>(pub Lobe);

impl<const GLASS: bool, const ROUGH: bool> ScatterStage for Scatter<GLASS, ROUGH> {
    fn scatter(
        &self,
        place: WavePosition,
        hits: &[SurfaceHit<'_>],
        out: &mut Vec<ScatteredRay>,
        counts: &mut RayCounts,
    ) {
        let (mut mirrored, mut refracted) = (0, 0);
        for (hit, index) in hits.iter().zip(0..) {
            let m = hit.point.material;
            let normal = hit.point.normal;
            let ray = |kind, direction, share: f64| {
                let weight = hit.weight.map(|w| w * share);
                ScatteredRay { hit: index, kind, direction, weight, origin: hit.origin }
            };
            if ROUGH && m.roughness > 0.0 && m.specular > 0.0 {
                self.0.reflect(place, index, hit, out, counts);
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
