//! The effects, what in a scene calls for each, and the settings of an image.

use glam::DVec3;
use scene_loading::{Material, SampleWishes, Scene, Shape};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    HardShadows,
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

#[derive(Debug)]
pub struct EffectInfo {
    pub effect: Effect,
    pub name: &'static str,
    /// The reason in the scene to simulate it; `None` without one.
    pub called_by: fn(&Scene, &RenderSettings) -> Option<String>,
}

pub static EFFECTS: [EffectInfo; Effect::COUNT] = [
    EffectInfo {
        effect: Effect::HardShadows,
        name: "hard shadows",
        called_by: |scene, _| {
            let points = scene.lights.iter().filter(|light| light.radius <= 0.0).count();
            counted(points, "light").map(|lights| lights + " without a radius")
        },
    },
    EffectInfo {
        effect: Effect::SoftShadows,
        name: "soft shadows",
        called_by: |scene, _| {
            let discs = scene.lights.iter().filter(|light| light.radius > 0.0).count();
            counted(discs, "light").map(|lights| lights + " with a radius")
        },
    },
    EffectInfo {
        effect: Effect::Mirror,
        name: "mirror reflection",
        called_by: |scene, settings| {
            let is_mirror =
                |m: &Material| (m.specular > 0.0 && m.roughness <= 0.0) || m.transmittance > 0.0;
            sending(scene, settings, is_mirror, "mirror")
                .map(|mirrors| mirrors + " without a roughness")
        },
    },
    EffectInfo {
        effect: Effect::Gloss,
        name: "glossy reflection",
        called_by: |scene, settings| {
            let is_rough = |m: &Material| m.specular > 0.0 && m.roughness > 0.0;
            sending(scene, settings, is_rough, "mirror")
                .map(|mirrors| mirrors + " with a roughness")
        },
    },
    EffectInfo {
        effect: Effect::Refraction,
        name: "refraction",
        called_by: |scene, settings| {
            let transmits = |m: &Material| m.transmittance > 0.0;
            sending(scene, settings, transmits, "material")
                .map(|materials| materials + " with a transmittance")
        },
    },
    EffectInfo {
        effect: Effect::SmoothNormals,
        name: "smooth normals",
        called_by: |scene, _| {
            let is_patch = |shape: Shape| matches!(shape, Shape::Patch { .. });
            let patches = scene.primitives.iter().filter(|p| is_patch(p.shape)).count();
            counted(patches, "triangle").map(|triangles| triangles + " with normals")
        },
    },
    EffectInfo {
        effect: Effect::Textures,
        name: "textures",
        called_by: |scene, _| {
            let has_texture =
                |m: &&Material| m.texture.is_some_and(|t| (t as usize) < scene.textures.len());
            let textured = used_materials(scene).filter(has_texture).count();
            let textured = counted(textured, "material").filter(|_| !scene.texcoords.is_empty());
            textured.map(|materials| materials + " with a texture")
        },
    },
    EffectInfo {
        effect: Effect::Focus,
        name: "depth of field",
        called_by: |scene, _| {
            let aperture = scene.camera.aperture;
            (aperture > 0.0).then(|| format!("a lens of radius {aperture}"))
        },
    },
    EffectInfo {
        effect: Effect::Motion,
        name: "motion blur",
        called_by: |scene, _| {
            let moving = scene.velocities.iter().filter(|v| **v != DVec3::ZERO).count();
            let shutter = scene.camera.shutter;
            let moving = counted(moving, "moving primitive").filter(|_| shutter > 0.0);
            moving.map(|moving| format!("{moving}, a shutter open for {shutter}"))
        },
    },
    EffectInfo {
        effect: Effect::Supersampling,
        name: "supersampling",
        called_by: |scene, settings| {
            let samples = samples(scene, settings, Effect::Supersampling);
            let typed = settings.samples.supersamples.is_some();
            let who = if typed { "the command line" } else { "the scene" };
            (samples > 1).then(|| format!("{who} asks for {samples} samples of a pixel's area"))
        },
    },
];

/// `1 light`, `2 lights`; `None` for 0.
fn counted(n: usize, what: &str) -> Option<String> {
    let plural = if n == 1 { "" } else { "s" };
    (n > 0).then(|| format!("{n} {what}{plural}"))
}

/// Counts used materials that send rays on, if rays may be that long.
fn sending(
    scene: &Scene,
    settings: &RenderSettings,
    test: fn(&Material) -> bool,
    what: &str,
) -> Option<String> {
    let materials = used_materials(scene).filter(|m| test(m)).count();
    counted(materials, what).filter(|_| settings.max_depth > 1)
}

/// Materials that primitives are made of; others cannot call for anything.
fn used_materials(scene: &Scene) -> impl Iterator<Item = &Material> {
    let mut used = vec![false; scene.materials.len()];
    for primitive in &scene.primitives {
        if let Some(used) = used.get_mut(primitive.material as usize) {
            *used = true;
        }
    }
    scene.materials.iter().zip(used).filter(|(_, used)| *used).map(|(m, _)| m)
}

/// How an image is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings {
    /// Pixels of the image.
    pub resolution: [u32; 2],
    /// Longest chain of rays; eye rays have depth 1.
    pub max_depth: u32,
    /// Numbers of samples that replace those of the scene.
    pub samples: SampleWishes,
    pub seed: u64,
}

impl Default for RenderSettings {
    fn default() -> Self {
        let (resolution, samples) = ([256, 256], SampleWishes::default());
        Self { resolution, max_depth: 5, samples, seed: 1 }
    }
}

/// Number of samples of an effect, called for or not: what the settings say, else what the scene
/// says, else 16 (1 for the area of a pixel). 1 for effects that are not sampled.
pub(super) fn samples(scene: &Scene, settings: &RenderSettings, effect: Effect) -> u32 {
    let (wish, default): (fn(&SampleWishes) -> Option<u32>, u32) = match effect {
        Effect::SoftShadows => (|wishes| wishes.shadow, 16),
        Effect::Gloss => (|wishes| wishes.glossy, 16),
        Effect::Focus => (|wishes| wishes.focal, 16),
        Effect::Motion => (|wishes| wishes.temporal, 16),
        Effect::Supersampling => (|wishes| wishes.supersamples, 1),
        _ => return 1,
    };
    wish(&settings.samples).or(wish(&scene.samples)).unwrap_or(default).max(1)
}
