//! The integration tests of the renderer, one binary: each further one costs a link. Here: effect
//! scenes and images of them.

mod beam;
mod cone;
mod convergence;
mod flat_scenes;
mod gating;
mod hard_cases;

use accel_core::query::tracer::Tracer;
use accel_core::structures::{REGISTRY, find, frustum_queries};
use renderer::tracers::Structures;
use renderer::{EffectPlan, Geometry, Image, RenderSettings, RenderedImage, render_plan};
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
    through(scene, structure, |tracer| render_plan(scene, tracer, plan))
}

/// Asks `ask` with the structure of that name.
pub fn through<R>(scene: &Scene, structure: &str, ask: impl FnOnce(&dyn Tracer<f32>) -> R) -> R {
    let geometry = Geometry::<f32>::of(scene).unwrap();
    let entry = find(structure).unwrap_or(&REGISTRY[0]);
    let tracer = entry.build(geometry.prims(), &entry.params([]).unwrap()).unwrap();
    ask(tracer.as_ref())
}

/// The image that the scene calls for.
pub fn image(scene: &Scene, settings: &RenderSettings) -> RenderedImage {
    image_of(scene, &EffectPlan::of(scene, settings), "obvhs-bvh2")
}

/// Asks `ask` with a kd-tree for rays and the structure of that name for frusta.
pub fn over<R>(scene: &Scene, frusta: &str, ask: impl FnOnce(Structures<'_>) -> R) -> R {
    let geometry = Geometry::<f64>::of(scene).unwrap();
    let entry = find("kd-tree").unwrap();
    let rays = entry.build(geometry.prims(), &entry.params([]).unwrap()).unwrap();
    let entry = frustum_queries::find(frusta).unwrap();
    let frusta = entry.build(geometry.prims(), &entry.params([]).unwrap()).unwrap();
    ask(Structures { rays: rays.as_ref(), frusta: frusta.as_ref() })
}

/// The image by single rays in f64.
pub fn by_rays(scene: &Scene, settings: &RenderSettings) -> Image {
    let plan = EffectPlan::of(scene, settings);
    over(scene, "brute-force", |over| render_plan(scene, over.rays, &plan).image)
}

/// All bits of an image.
pub fn bits(image: &Image) -> Vec<u64> {
    image.pixels.as_flattened().iter().map(|x| x.to_bits()).collect()
}

/// Root of the mean square difference of two images.
pub fn rmse(a: &Image, b: &Image) -> f64 {
    let (a, b) = (a.pixels.as_flattened(), b.pixels.as_flattened());
    let sum: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
    (sum / a.len() as f64).sqrt()
}
