//! What an image must simulate, found in the scene: one file an effect, one line each in
//! [`EFFECTS`].
//!
//! An effect that a scene does not call for is not there: the [`plan`] picks the stages of the
//! tracer once, before the first ray, and those of other effects are not among them.

pub mod counts;
mod eye;
mod focus;
mod gloss;
mod hard_shadows;
mod mirror;
mod motion;
pub mod plan;
mod refraction;
pub mod sampler;
mod smooth_normals;
mod soft_shadows;
mod supersampling;
mod textures;

use scene_loading::Scene;

pub(crate) use eye::Pinhole;
pub(crate) use hard_shadows::{PointLights, first_light, lights, lit_normal, shadow_ray};
pub(crate) use mirror::Scatter;
pub use plan::{EffectPlan, Gating, RenderSettings, Samples};
pub(crate) use textures::ImageColors;

/// An effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// Shadows of point lights.
    HardShadows,
    /// Shadows of lights with an extent.
    SoftShadows,
    /// Mirror reflection.
    Mirror,
    /// Reflection by rough mirrors.
    Gloss,
    /// Refraction with total internal reflection.
    Refraction,
    /// Normals interpolated between vertices.
    SmoothNormals,
    /// Colours looked up in images.
    Textures,
    /// A lens with an extent.
    Focus,
    /// Something moves while the shutter is open.
    Motion,
    /// Several rays for the area of a pixel.
    Supersampling,
}

impl Effect {
    /// How many there are.
    pub const COUNT: usize = 10;
}

/// What is known of an effect.
#[derive(Debug)]
pub struct EffectInfo {
    /// Which one.
    pub effect: Effect,
    /// Name in tables.
    pub name: &'static str,
    /// Where it comes from, and what we do differently.
    pub paper: &'static str,
    /// What in the scene calls for it, in words; `None` when nothing does.
    pub called_by: fn(&Scene, &RenderSettings) -> Option<String>,
}

/// Every effect: one line each.
pub static EFFECTS: &[&EffectInfo] = &[
    &hard_shadows::INFO,
    &soft_shadows::INFO,
    &mirror::INFO,
    &gloss::INFO,
    &refraction::INFO,
    &smooth_normals::INFO,
    &textures::INFO,
    &focus::INFO,
    &motion::INFO,
    &supersampling::INFO,
];

/// `1 light`, `2 lights`.
fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

/// Materials that primitives are made of; others cannot call for anything.
fn used_materials(scene: &Scene) -> impl Iterator<Item = &scene_loading::Material> {
    let mut used = vec![false; scene.materials.len()];
    for primitive in &scene.primitives {
        if let Some(used) = used.get_mut(primitive.material as usize) {
            *used = true;
        }
    }
    scene.materials.iter().zip(used).filter(|(_, used)| *used).map(|(m, _)| m)
}
