//! Effect scenes and images of them.

use accel_core::structures::{REGISTRY, find};
use renderer::{EffectPlan, Geometry, RenderSettings, RenderedImage, render_plan};
use scene_loading::{SampleWishes, Scene, SceneCatalogue};

/// Every scene of the set `effects`.
pub fn effect_scenes() -> Vec<Scene> {
    let catalogue = SceneCatalogue::embedded().unwrap();
    let scenes = catalogue.resolve(&["effects".to_owned()]).unwrap();
    scenes.iter().map(|scene| scene.load().unwrap().scene).collect()
}

pub fn effect_scene(name: &str) -> Scene {
    effect_scenes().into_iter().find(|scene| scene.name == name).expect("an effect scene")
}

/// So many samples of every effect.
pub fn samples(n: u32) -> SampleWishes {
    let n = Some(n);
    SampleWishes { supersamples: n, shadow: n, glossy: n, temporal: n, focal: n }
}

/// The same, but one ray for the area of a pixel.
pub fn samples_without_area(n: u32) -> SampleWishes {
    SampleWishes { supersamples: Some(1), ..samples(n) }
}

pub fn settings(resolution: [u32; 2], samples: SampleWishes) -> RenderSettings {
    RenderSettings { resolution, samples, ..RenderSettings::default() }
}

/// The image of a plan through the structure of that name.
pub fn image_of(scene: &Scene, plan: &EffectPlan, structure: &str) -> RenderedImage {
    let geometry = Geometry::<f32>::of(scene).unwrap();
    let entry = find(structure).unwrap_or(&REGISTRY[0]);
    let tracer = entry.build(geometry.prims(), &entry.params([]).unwrap()).unwrap();
    render_plan(scene, tracer.as_ref(), plan)
}

/// The image that the scene calls for.
pub fn image(scene: &Scene, settings: &RenderSettings) -> RenderedImage {
    image_of(scene, &EffectPlan::of(scene, settings), "obvhs-bvh2")
}

/// All bits of an image.
pub fn bits(rendered: &RenderedImage) -> Vec<u64> {
    rendered.image.pixels.iter().flatten().map(|x| x.to_bits()).collect()
}

/// Root of the mean square difference of two images.
pub fn rmse(a: &RenderedImage, b: &RenderedImage) -> f64 {
    let (a, b) = (a.image.pixels.as_flattened(), b.image.pixels.as_flattened());
    let sum: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
    (sum / a.len() as f64).sqrt()
}
