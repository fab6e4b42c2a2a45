//! JSON scene files drawn with every effect that they call for: an image of few pixels.
#![no_main]

use std::path::Path;

use accel_core::structures::find;
use renderer::effects::{EffectPlan, RenderSettings};
use renderer::{Geometry, render_plan};
use scene_loading::scene_file::{SceneFile, Source};

/// Rays a pixel, about, beyond which nothing is drawn.
const MOST_RAYS: u64 = 256;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("a.json");
    let Ok(file) = SceneFile::parse(path, &String::from_utf8_lossy(bytes)) else { return };
    let Source::Shapes(shapes) = &file.source else { return };
    let Ok(mut scene) = file.inline(path, shapes) else { return };
    if file.apply(path, &mut scene).is_err() {
        return;
    }
    let plan = EffectPlan::of(&scene, &RenderSettings::default()).at([2, 2]);
    let lights = scene.lights.len().max(1) as u64;
    if plan.samples_per_pixel().saturating_mul(lights) > MOST_RAYS || scene.primitives.len() > 64 {
        return;
    }
    let Ok(geometry) = Geometry::<f32>::of(&scene) else { return };
    let entry = find("brute-force").expect("it is in the registry");
    let params = entry.params([]).expect("defaults are valid");
    if let Ok(tracer) = entry.build(geometry.prims(), &params) {
        let image = render_plan(&scene, &*tracer, &plan).image;
        assert_eq!(image.pixels.len(), 4);
    }
});
