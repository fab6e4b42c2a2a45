//! What a scene does not call for is not there: no rays, and not one other bit in the image
//! (HARD_CASES S5). What is there is the same by any structure and number of threads.

use accel_core::structures::{Entry, REGISTRY};
use glam::DVec3;
use renderer::effects::EFFECTS;
use renderer::{Effect, EffectPlan, RaySettings, RenderSettings, Whitted};
use scene_loading::{SampleWishes, Scene};

use crate::{
    bits, effect_scene, effect_scenes, image, image_of, samples, samples_without_area, settings,
    through,
};

const SIZE: [u32; 2] = [40, 30];

/// The effects that a scene calls for, and what it takes to make it call for none of them.
const NAMED: &[(&str, &[Effect])] = &[
    ("effect-plain", &[]),
    ("effect-hard-shadows", &[Effect::HardShadows]),
    ("effect-soft-shadows", &[Effect::SoftShadows]),
    ("effect-mirror", &[Effect::HardShadows, Effect::Mirror]),
    ("effect-gloss", &[Effect::HardShadows, Effect::Gloss]),
    ("effect-refraction", &[Effect::HardShadows, Effect::Mirror, Effect::Refraction]),
    ("effect-smooth-normals", &[Effect::HardShadows, Effect::SmoothNormals]),
    ("effect-textures", &[Effect::HardShadows, Effect::Textures]),
    ("effect-focus", &[Effect::HardShadows, Effect::Focus]),
    ("effect-motion", &[Effect::HardShadows, Effect::Motion]),
    ("effect-supersampling", &[Effect::HardShadows, Effect::Supersampling]),
    (
        "effect-all",
        &[
            Effect::SoftShadows,
            Effect::Mirror,
            Effect::Gloss,
            Effect::Refraction,
            Effect::Focus,
            Effect::Motion,
            Effect::Supersampling,
        ],
    ),
];

#[test]
fn plans_call_for_what_the_scene_has_and_nothing_else() {
    let scenes = effect_scenes();
    assert_eq!(scenes.len(), NAMED.len());
    for (scene, (name, effects)) in scenes.iter().zip(NAMED) {
        let plan = EffectPlan::of(scene, &RenderSettings::default());
        let called: Vec<Effect> = plan.called.iter().map(|c| c.info.effect).collect();
        assert_eq!((&*scene.name, &*called), (*name, *effects));
        assert!(plan.called.iter().all(|called| !called.by.is_empty()));
    }
}

#[test]
fn rays_of_effects_that_are_not_called_for_are_exactly_none() {
    for (scene, (name, effects)) in effect_scenes().iter().zip(NAMED) {
        // planted: numbers of samples for everything must tempt nobody
        let mut settings = settings(SIZE, samples(4));
        settings.samples.supersamples = scene.samples.supersamples;
        let rendered = image(scene, &settings);
        for info in &EFFECTS {
            let rays = rendered.counts.effect(info.effect);
            let is_rayless = matches!(info.effect, Effect::SmoothNormals | Effect::Textures);
            let has_rays = effects.contains(&info.effect) && !is_rayless;
            assert_eq!(rays > 0, has_rays, "{name} {}: {rays}", info.name);
        }
    }
}

/// The images of the tracer without any effects of this module, where a scene calls for none that
/// it lacks: the same bits.
#[test]
fn the_image_is_that_of_a_renderer_without_the_effects() {
    let mut compared = 0;
    for scene in effect_scenes() {
        let plan = EffectPlan::of(&scene, &settings(SIZE, samples(64)));
        let sampled = [
            Effect::Textures,
            Effect::SoftShadows,
            Effect::Gloss,
            Effect::Focus,
            Effect::Motion,
            Effect::Supersampling,
        ];
        let plan = sampled.into_iter().fold(plan, EffectPlan::without);
        let rendered = image_of(&scene, &plan, "obvhs-bvh2");
        let ray_settings =
            RaySettings { resolution: SIZE, diffuse: false, ..RaySettings::default() };
        let plain = Whitted::new(&scene, &ray_settings);
        let plain = through(&scene, "obvhs-bvh2", |tracer| plain.image(tracer, &|| ()));
        assert_eq!(rendered.image, plain.image, "{}", scene.name);
        compared += 1;
    }
    assert_eq!(compared, NAMED.len());
}

/// Makes the extent of an effect what `factor` says of it.
type Scaled = fn(&mut Scene, f64);

#[test]
fn extents_of_0_at_64_samples_are_1_sample_bit_for_bit() {
    let cases: &[(&str, Scaled)] = &[
        ("effect-soft-shadows", |scene, factor| {
            scene.lights.iter_mut().for_each(|light| light.radius *= factor);
        }),
        ("effect-gloss", |scene, factor| {
            scene.materials.iter_mut().for_each(|m| m.roughness *= factor);
        }),
        ("effect-focus", |scene, factor| scene.camera.aperture *= factor),
        ("effect-motion", |scene, factor| scene.camera.shutter *= factor),
        ("effect-motion", |scene, factor| {
            scene.velocities.iter_mut().for_each(|v| *v *= factor);
        }),
    ];
    for (name, scale) in cases {
        let with = |factor: f64, n: u32| {
            let mut scene = effect_scene(name);
            scale(&mut scene, factor);
            image(&scene, &settings(SIZE, samples_without_area(n)))
        };
        let (many, one) = (with(0.0, 64), with(0.0, 1));
        assert_eq!(bits(&many.image), bits(&one.image), "{name}");
        assert_eq!(many.counts, one.counts, "{name}");
        // planted fault: the least extent must be seen
        let (least, full) = (with(1e-3, 2), with(1.0, 2));
        assert!(bits(&least.image) != bits(&one.image) && least.counts != one.counts, "{name}");
        assert!(bits(&full.image) != bits(&least.image), "{name}");
    }
}

#[test]
fn pixels_that_see_no_gloss_are_those_of_a_scene_without() {
    let scene = effect_scene("effect-gloss");
    let mut matte = scene.clone();
    for m in matte.materials.iter_mut().filter(|m| m.roughness > 0.0) {
        (m.specular, m.roughness) = (0.0, 0.0);
    }
    let settings = settings(SIZE, samples(1));
    let without = image(&matte, &settings).image.pixels;
    let whitted = Whitted::planned(&scene, &EffectPlan::of(&scene, &settings));
    let pixels: Vec<_> = through(&scene, "obvhs-bvh2", |tracer| {
        let pixel = |i: u32| (i / SIZE[0], i % SIZE[0]);
        let pixels = (0..SIZE[0] * SIZE[1]).map(pixel);
        pixels.map(|(y, x)| whitted.trace_columns(tracer, y, x..x + 1, None)).collect()
    });
    let mut free = 0;
    for (i, (pixel, without)) in pixels.iter().zip(&without).enumerate() {
        if pixel.counts.effect(Effect::Gloss) == 0 {
            free += 1;
            assert_eq!(pixel.colors, [*without], "{i}");
        }
    }
    assert!(free > without.len() / 2 && free < without.len(), "{free} of {}", without.len());
}

#[test]
fn depth_1_sends_nothing_on() {
    for scene in effect_scenes() {
        let settings = RenderSettings { max_depth: 1, ..settings(SIZE, SampleWishes::default()) };
        let counts = image(&scene, &settings).counts;
        for effect in [Effect::Mirror, Effect::Gloss, Effect::Refraction] {
            assert_eq!(counts.effect(effect), 0, "{}", scene.name);
        }
    }
}

#[test]
fn motion_blur_covers_the_path() {
    // without the effect it stands where it is when the shutter opens
    let scene = effect_scene("effect-motion");
    let plan = EffectPlan::of(&scene, &settings(SIZE, samples(16)));
    let blurred = image_of(&scene, &plan, "obvhs-bvh2");
    let frozen = image_of(&scene, &plan.without(Effect::Motion), "obvhs-bvh2");
    let mut still = scene.clone();
    still.velocities.fill(DVec3::ZERO);
    let still = image(&still, &settings(SIZE, samples_without_area(1)));
    let mut plain = settings(SIZE, samples_without_area(16));
    plain.samples.temporal = Some(1);
    assert!(bits(&blurred.image) != bits(&frozen.image));
    let frozen_plain =
        image_of(&scene, &EffectPlan::of(&scene, &plain).without(Effect::Motion), "obvhs-bvh2");
    assert_eq!(bits(&frozen_plain.image), bits(&still.image));
}

#[test]
fn unused_images_change_no_pixel_and_trace_no_ray() {
    let settings = settings(SIZE, samples(1));
    for scene in effect_scenes().iter().filter(|scene| scene.textures.is_empty()) {
        let mut unworn = scene.clone();
        let textured = effect_scene("effect-textures");
        unworn.textures = textured.textures;
        unworn.materials.extend(textured.materials);
        unworn.texcoords = vec![Some([[0.5; 2]; 3]); unworn.primitives.len()];
        let plan = EffectPlan::of(&unworn, &settings);
        assert!(!plan.calls_for(Effect::Textures), "{}", scene.name);
        let (with, without) = (image(&unworn, &settings), image(scene, &settings));
        assert_eq!(bits(&with.image), bits(&without.image), "{}", scene.name);
        assert_eq!(with.counts, without.counts, "{}", scene.name);
    }
}

#[test]
fn textures_change_colours_and_no_ray() {
    let scene = effect_scene("effect-textures");
    let plan = EffectPlan::of(&scene, &settings(SIZE, samples(1)));
    let textured = image_of(&scene, &plan, "obvhs-bvh2");
    let plain = image_of(&scene, &plan.clone().without(Effect::Textures), "obvhs-bvh2");
    // planted fault: an image that were there without the effect would be these bits
    assert!(bits(&textured.image) != bits(&plain.image));
    assert_eq!(textured.counts, plain.counts);
    // images that are white all over are the plain colour: the same bits
    let mut white = scene.clone();
    for texture in &mut white.textures {
        texture.texels = vec![[255; 3]; texture.texels.len()].into();
    }
    assert_eq!(bits(&image_of(&white, &plan, "obvhs-bvh2").image), bits(&plain.image));
    // one texel more, at a corner: seen
    for texture in &mut scene.clone().textures {
        let mut texels = vec![[255; 3]; texture.texels.len()];
        texels[0] = [0; 3];
        texture.texels = texels.into();
        white.textures = vec![texture.clone(); white.textures.len()];
        assert!(bits(&image_of(&white, &plan, "obvhs-bvh2").image) != bits(&plain.image));
    }
}

fn few() -> SampleWishes {
    SampleWishes { shadow: Some(3), glossy: Some(3), ..samples(2) }
}

#[test]
fn all_structures_give_the_same_image() {
    for scene in effect_scenes() {
        let plan = EffectPlan::of(&scene, &settings([24, 18], few()));
        let expected = image_of(&scene, &plan, "brute-force");
        assert!(expected.image.pixels.as_flattened().iter().any(|x| *x != 0.0));
        let is_right = |entry: &&Entry| (entry.info.known_defect)(&entry.defaults()).is_none();
        for entry in REGISTRY.iter().filter(is_right) {
            let (got, what) = (image_of(&scene, &plan, entry.info.name), entry.info.name);
            assert!(bits(&got.image) == bits(&expected.image), "{} {what}", scene.name);
            assert_eq!(got.counts, expected.counts, "{} {what}", scene.name);
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_image_and_another_seed_another() {
    for scene in effect_scenes() {
        let mut settings = settings([24, 18], few());
        let with = |settings: &renderer::RenderSettings, threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let plan = EffectPlan::of(&scene, settings);
            pool.install(|| image_of(&scene, &plan, "uniform-grid"))
        };
        let expected = with(&settings, 1);
        for threads in [2, 5] {
            assert!(with(&settings, threads) == expected, "{} {threads}", scene.name);
        }
        // planted fault: a seed that depends on the thread would be another seed
        settings.seed = 2;
        assert!(bits(&with(&settings, 1).image) != bits(&expected.image), "{}", scene.name);
    }
}
