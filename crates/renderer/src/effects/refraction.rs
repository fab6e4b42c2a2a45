//! Refraction with total internal reflection: one ray by Snell's law, none beyond the critical
//! angle ([`crate::surface::refract`]; the stage is [`super::mirror::Scatter`]).
//!
//! Paper: T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980.
//! Deviations, as in NFF: no Fresnel term, bodies are not nested (outside is vacuum).

use scene_loading::Scene;

use super::effect::{Effect, EffectInfo, counted, used_materials};
use super::settings::RenderSettings;

pub static INFO: EffectInfo =
    EffectInfo { effect: Effect::Refraction, name: "refraction", paper: "Whitted 1980", called_by };

fn called_by(scene: &Scene, settings: &RenderSettings) -> Option<String> {
    let glass = used_materials(scene).filter(|m| m.transmittance > 0.0).count();
    (glass > 0 && settings.max_depth > 1)
        .then(|| format!("{} with a transmittance", counted(glass, "material")))
}
