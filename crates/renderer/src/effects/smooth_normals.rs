//! Normals interpolated between vertices ([`crate::surface::Surfaces`]): no rays of its own.
//!
//! Paper: B. T. Phong, "Illumination for Computer Generated Pictures", CACM 18(6), 1975.

use scene_loading::{Scene, Shape};

use super::effect::{Effect, EffectInfo, counted};
use super::settings::RenderSettings;

pub static INFO: EffectInfo = EffectInfo {
    effect: Effect::SmoothNormals,
    name: "smooth normals",
    paper: "Phong 1975",
    called_by,
};

fn called_by(scene: &Scene, _: &RenderSettings) -> Option<String> {
    let patches = scene.primitives.iter().filter(|p| matches!(p.shape, Shape::Patch { .. }));
    let patches = patches.count();
    (patches > 0).then(|| format!("{} with normals", counted(patches, "triangle")))
}
