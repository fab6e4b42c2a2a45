//! One image, for instruction counts: `valgrind --tool=callgrind one_image SCENE`. Prints a hash of
//! all its bits; see `scripts/effect-gating.sh`.

use accel_core::structures::find;
use renderer::{EffectPlan, Geometry, RenderSettings, render_plan};
use scene_loading::{SampleWishes, SceneCatalogue};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "effect-hard-shadows".to_owned());
    let scene = SceneCatalogue::embedded()?.resolve(&[name])?.remove(0).load()?.scene;
    let geometry = Geometry::<f32>::of(&scene)?;
    let entry = find("obvhs-cwbvh").ok_or("no such structure")?;
    let tracer = entry.build(geometry.prims(), &entry.params([])?)?;
    // samples for everything: what the scene does not call for must not take them
    let many = Some(64);
    let samples = SampleWishes {
        supersamples: None,
        shadow: many,
        glossy: many,
        temporal: many,
        focal: many,
    };
    let settings = RenderSettings { resolution: [96, 96], samples, ..RenderSettings::default() };
    let rendered = render_plan(&scene, tracer.as_ref(), &EffectPlan::of(&scene, &settings));
    let bits = rendered.image.pixels.as_flattened().iter().map(|x| x.to_bits());
    let hash = bits.fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ b).wrapping_mul(0x100_0000_01b3));
    println!("{hash:016x} {} rays", rendered.counts.total());
    Ok(())
}
