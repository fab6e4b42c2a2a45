//! One image of a scene and its effects: whatever the structure, the number of threads, the run.

use accel_core::structures::{Entry, REGISTRY};
use renderer::EffectPlan;
use scene_loading::SampleWishes;

use crate::common::{bits, effect_scenes, image_of, settings};

fn few() -> SampleWishes {
    SampleWishes {
        supersamples: Some(2),
        shadow: Some(3),
        glossy: Some(3),
        temporal: Some(2),
        focal: Some(2),
    }
}

#[test]
fn all_structures_give_the_same_image() {
    for scene in effect_scenes() {
        let plan = EffectPlan::of(&scene, &settings([24, 18], few()));
        let expected = image_of(&scene, &plan, "brute-force");
        assert!(expected.image.pixels.as_flattened().iter().any(|x| *x != 0.0));
        let is_right = |entry: &&Entry| (entry.info.known_defect)(&entry.defaults()).is_none();
        for entry in REGISTRY.iter().filter(is_right) {
            let got = image_of(&scene, &plan, entry.info.name);
            assert!(
                bits(&got.image) == bits(&expected.image),
                "{} {}",
                scene.name,
                entry.info.name
            );
            assert_eq!(got.counts, expected.counts, "{} {}", scene.name, entry.info.name);
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
