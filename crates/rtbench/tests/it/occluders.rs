//! The light buffer as a row of a run and as the shadow path of an image.

use crate::common::{Ended, Folder, PLANTED, row, run, run_over};
use accel_core::occluders::{self, BoxedOccluder, Occluder, light_buffer};
use accel_core::params::config::Settings;
use accel_core::primitives::PrimsRef;
use accel_core::query::counters::WorkCounters;
use accel_core::structure::{BuildError, StructureInfo, StructureStats};
use accel_core::{Ray, Scalar};
use glam::DVec3;
use measurement::record::{AnsweredRays, Verdict};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

/// Says that every light is seen: the wrong occluder that must be found out.
struct Bright;

impl<S: Scalar> Occluder<S> for Bright {
    fn occlusions(&self, _: &[Ray<S>], _: &[u32], blocked: &mut [bool]) {
        blocked.fill(false);
    }

    fn count_occlusions(&self, _: &[Ray<S>], _: &[u32], blocked: &mut [bool]) -> WorkCounters {
        blocked.fill(false);
        WorkCounters::default()
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

fn bright<'a, S: Scalar>(
    _: PrimsRef<'a, S>,
    _: &[DVec3],
    _: &Settings<()>,
) -> Result<BoxedOccluder<'a, S>, BuildError> {
    Ok(Box::new(Bright))
}

static BRIGHT: StructureInfo = StructureInfo {
    name: "bright",
    summary: "sees every light",
    paper: "none",
    deviations: "none",
    params: &[],
    variants: &[""],
    also_tested: &[],
    known_defect: accel_core::structure::no_defect,
    sampled: false,
};

pub static OCCLUDERS: &[occluders::Entry] = &[
    accel_core::occluder!(light_buffer::build, light_buffer::INFO),
    accel_core::occluder!(crate::occluders::bright, BRIGHT),
];

fn run_planted(arguments: &str) -> Ended {
    run_over(&PLANTED, OCCLUDERS, &InstalledScenes, &SystemClock::default(), arguments)
}

#[test]
fn the_light_buffer_is_right_in_every_scene_and_is_timed_on_shadow_rays_alone() {
    let scenes = "balls:2 gears:1 lattice:3 mount:3 rings:1 teapot:3 tetra:3 tree:5";
    for (precision, settings) in [("f32", "light-buffer"), ("f64", "light-buffer:resolution=64")] {
        let folder = Folder::new();
        let arguments = format!("run {scenes} --quick --precision {precision} --rounds 1");
        let ended = run(&format!("{arguments} -s {settings},obvhs-bvh2 -o {}", folder.path()));
        assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
        for scene in folder.record().scenes {
            let own = scene.rows.iter().find(|r| r.structure == "light-buffer").unwrap();
            assert_eq!((own.verdict, own.mismatches), (Verdict::Ok, 0), "{}", scene.name);
            assert_eq!(own.answers, AnsweredRays::ShadowRays);
            assert_eq!(own.checked_rays, scene.rays["shadow"], "{}", scene.name);
            assert!(own.checked_rays > 100, "{}", scene.name);
            assert_eq!(own.rays_by_kind.keys().collect::<Vec<_>>(), ["shadow"]);
            assert!(own.samples.iter().all(|s| s.trace_s.keys().eq(["shadow"])));
            let other = scene.rows.iter().find(|r| r.structure == "obvhs-bvh2").unwrap();
            // the ratio is over the same rays
            let (sample, of_other) = (&own.samples[0], &other.samples[0]);
            assert_eq!(sample.reference_trace_s, of_other.trace_s.get("shadow").copied());
            assert_eq!(other.answers, AnsweredRays::AllRays);
            let stats = own.stats.as_ref().unwrap();
            assert!(own.build_s.is_some() && stats.memory_bytes > 0 && own.render_s.is_none());
        }
    }
}

#[test]
fn occluders_have_figures_for_shadow_rays_only() {
    let folder = Folder::new();
    let ended =
        run(&format!("run tetra:3 --quick -s light-buffer,obvhs-bvh2 -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let csv = folder.csv();
    let own = csv.iter().find(|r| r["structure"] == "light-buffer").unwrap();
    assert_eq!(own["answers"], "shadow rays");
    for empty in ["primary_mrays", "secondary_mrays", "diffuse_mrays", "render_s"] {
        assert_eq!(own[empty], "", "{empty}");
    }
    for given in ["shadow_mrays", "trace_s", "build_s", "ratio_to_reference", "n_it", "n_oiv"] {
        assert_ne!(own[given], "", "{given}");
    }
    let record = folder.record();
    assert_eq!(own["rays"], record.scenes[0].rays["shadow"].to_string());
    for text in [&ended.out, &folder.text("results.md")] {
        assert!(text.contains("shadow rays"), "{text}");
        assert!(text.contains("light-buffer: answers shadow rays only"), "{text}");
    }
    let summary = record.summary.iter().find(|s| s.structure == "light-buffer").unwrap();
    assert!(summary.ratio.is_some() && summary.answers == AnsweredRays::ShadowRays);
}

#[test]
fn an_occluder_alone_is_compared_with_the_default_structure() {
    let folder = Folder::new();
    let ended = run(&format!("run tetra:2 --quick -s light-buffer -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let record = folder.record();
    assert_eq!(record.settings.reference, "obvhs-cwbvh");
    assert!(row(&record, "light-buffer").ratio.is_some());
}

#[test]
fn an_occluder_that_sees_every_light_is_wrong_and_has_no_times() {
    let folder = Folder::new();
    let arguments = "run balls:2 --quick -s obvhs-cwbvh,light-buffer,bright -o";
    let ended = run_planted(&format!("{arguments} {}", folder.path()));
    assert_eq!(ended.code, 4, "{}{}", ended.out, ended.err);
    let record = folder.record();
    let wrong = row(&record, "bright");
    assert_eq!(wrong.verdict, Verdict::Wrong);
    assert!(wrong.mismatches > 0);
    assert!(wrong.example.as_ref().is_some_and(|e| e.contains("shadow ray")), "{wrong:?}");
    assert!(wrong.samples.is_empty() && wrong.trace_s.is_none() && wrong.ratio.is_none());
    assert_eq!(row(&record, "light-buffer").verdict, Verdict::Ok);
}

#[test]
fn images_are_the_same_whatever_answers_shadow_rays() {
    let folder = Folder::new();
    let image = |name: &str, options: &str| {
        let png = format!("{}/{name}.png", folder.path());
        let ended = run_planted(&format!("render balls:2 --size 64 -o {png} {options}"));
        assert_eq!(ended.code, 0, "{}", ended.err);
        std::fs::read(png).unwrap()
    };
    let expected = image("structure", "--shadows structure");
    assert!(expected == image("default", ""));
    assert!(expected == image("buffer", "--shadows light-buffer -s obvhs-bvh2"));
    assert!(expected == image("settings", "--shadows light-buffer:resolution=64 -j 2"));
    // planted fault: without shadows the image must differ
    assert!(expected != image("bright", "--shadows bright"));
}

#[test]
fn lights_with_an_extent_and_moving_things_cast_the_same_shadows() {
    let folder = Folder::new();
    for scene in ["effect-all", "effect-motion", "effect-soft-shadows"] {
        let image = |shadows: &str| {
            let png = format!("{}/{scene}.png", folder.path());
            let options = format!("--size 48 -o {png} --overwrite --shadows {shadows}");
            let ended = run_planted(&format!("render {scene} {options}"));
            assert_eq!(ended.code, 0, "{}", ended.err);
            std::fs::read(png).unwrap()
        };
        let expected = image("structure");
        assert!(expected == image("light-buffer"), "{scene}");
    }
}

#[test]
fn wrong_names_and_settings_are_errors_that_help() {
    for (arguments, said) in [
        ("run tetra:2 -s light-bufer", "did you mean 'light-buffer'?"),
        ("run tetra:2 -s light-buffer --rays primary", "answers shadow rays only"),
        ("run tetra:2 -s light-buffer:resolution=100", "expected one of 16, 32, 64"),
        ("run tetra:2 -s light-buffer:resolutoin=64", "did you mean 'resolution'?"),
        ("run tetra:2 -s obvhs-bvh2 --set light-buffer.divide=2", "does not measure"),
        ("run tetra:2 -s light-buffer --set obvhs-bvh2.preset=fast", "does not measure"),
        ("run tetra:2 --reference light-buffer", "unknown structure"),
        ("render tetra:2 -o /dev/null.png --shadows light", "valid: structure, light-buffer"),
        ("render tetra:2 -o /dev/null.png -s light-buffer", "unknown structure"),
    ] {
        let ended = run(arguments);
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
    }
    let listed = run("list occluders");
    assert!(listed.out.contains("light-buffer: ") && listed.out.contains("resolution = auto"));
    assert!(run("list occluders --format json").out.contains("\"resolution\""));
}
