//! The effects, and what is known of each.

use scene_loading::{Material, Scene};

use super::settings::RenderSettings;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// Shadows of point lights.
    HardShadows,
    /// Shadows of lights with an extent.
    SoftShadows,
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
    pub const COUNT: usize = 10;
}

/// Registry line of an effect.
#[derive(Debug)]
pub struct EffectInfo {
    pub effect: Effect,
    pub name: &'static str,
    /// Source, and our deviations.
    pub paper: &'static str,
    /// The reason in the scene to simulate it; `None` without one.
    pub called_by: fn(&Scene, &RenderSettings) -> Option<String>,
}

/// `1 light`, `2 lights`.
pub(super) fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

/// Materials that primitives are made of; others cannot call for anything.
pub(super) fn used_materials(scene: &Scene) -> impl Iterator<Item = &Material> {
    let mut used = vec![false; scene.materials.len()];
    for primitive in &scene.primitives {
        if let Some(used) = used.get_mut(primitive.material as usize) {
            *used = true;
        }
    }
    scene.materials.iter().zip(used).filter(|(_, used)| *used).map(|(m, _)| m)
}
