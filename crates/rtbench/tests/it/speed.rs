//! Orders of rays, one shadow ray a primary hit, ratios by kind, batches told from single rays, and
//! the options that a set of scenes has for its runs.

use std::time::Duration;

use crate::common::{
    BatchFault, Batched, Ended, Folder, answered_by_brute_force, planted, row, run_with,
};
use accel_core::primitives::PrimSet;
use accel_core::structure::{BatchAnswers, Batches, RayBatch, StructureInfo};
use accel_core::structures::{Entry, REGISTRY, obvhs};
use accel_core::{Hit, Scalar, Vector};
use measurement::record::query::Query;
use measurement::record::{RunRecord, Verdict};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SteppingClock;

const KINDS: &str = "--rays primary,shadow,diffuse --lights first";

fn run_over(registry: &[Entry], arguments: &str) -> Ended {
    run_with(registry, &InstalledScenes, &SteppingClock::new(Duration::from_millis(1)), arguments)
}

/// A run that is right; its record.
fn record_of(arguments: &str) -> (RunRecord, Ended, Folder) {
    let folder = Folder::new();
    let ended = run_over(REGISTRY, &format!("{arguments} -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    (folder.record(), ended, folder)
}

#[test]
fn both_orders_ask_the_same_rays_and_each_primary_hit_sends_one_to_the_first_light() {
    // two lights, mirrors
    let (record, ..) = record_of(&format!(
        "run tetra:2 balls:1 --size 16 --rounds 2 {KINDS} --order both -s obvhs-cwbvh,light-buffer"
    ));
    let settings = &record.settings;
    assert_eq!((settings.order.as_str(), settings.lights.as_str()), ("both", "first"));
    assert_eq!(settings.max_depth, 1, "nothing behind the first hit is asked");
    for scene in &record.scenes {
        let rays = &scene.rays;
        let names: Vec<&str> = rays.keys().map(String::as_str).collect();
        let kinds = ["diffuse", "primary", "shadow"];
        assert_eq!(names.len(), 6, "{names:?}");
        for kind in kinds {
            assert_eq!(rays[kind], rays[&format!("{kind}-shuffled")], "{kind}");
        }
        // one of each leaves every primary hit
        assert_eq!(rays["shadow"], rays["diffuse"], "{}", scene.name);
        assert!(rays["shadow"] > 10 && rays["primary"] == 256);
        let reference = scene.rows.iter().find(|r| r.is_reference).unwrap();
        assert_eq!(reference.checked_rays, scene.distinct_rays(), "each ray is checked once");
        assert_eq!(reference.rays, 2 * scene.distinct_rays(), "and asked in both orders");
        for row in &scene.rows {
            let of_kinds = row.rays_by_kind.keys();
            assert!(row.ratio_by_kind.keys().eq(of_kinds), "{}", row.label());
            for sample in &row.samples {
                // on this clock every batch takes as long as any other
                assert!(sample.reference_by_kind.keys().eq(sample.trace_s.keys()));
                let sum: f64 = sample.reference_by_kind.values().sum();
                assert_eq!(sample.reference_trace_s, Some(sum));
            }
            assert!(row.ratio_by_kind.values().all(|ratio| (ratio.median - 1.0).abs() < 1e-9));
        }
        let light_buffer = scene.rows.iter().find(|r| r.structure == "light-buffer").unwrap();
        assert_eq!(light_buffer.verdict, Verdict::Ok);
        assert_eq!(light_buffer.checked_rays, rays["shadow"]);
        let asked: Vec<&str> = light_buffer.rays_by_kind.keys().map(String::as_str).collect();
        assert_eq!(asked, ["shadow", "shadow-shuffled"]);
    }
}

#[test]
fn shuffled_rays_have_the_same_work() {
    let run = |order: &str| {
        let rows = "obvhs-cwbvh,uniform-grid";
        record_of(&format!("run tetra:2 --size 16 --rounds 1 {KINDS} --order {order} -s {rows}")).0
    };
    let (scanline, shuffled) = (run("scanline"), run("shuffled"));
    assert!(shuffled.scenes[0].rays.keys().all(|name| name.ends_with("-shuffled")));
    for label in ["obvhs-cwbvh", "uniform-grid"] {
        let [a, b] = [&scanline, &shuffled].map(|record| row(record, label));
        assert_eq!(a.work, b.work, "{label}");
        assert_ne!(a.answers_sha256, b.answers_sha256, "in another order");
    }
}

#[test]
fn batches_and_single_rays_are_distinguished_by_the_built_structure() {
    // the same settings: triangles have batches, spheres have not
    let (record, ended, folder) = record_of(&format!(
        "run pavilion balls:1 --size 8 --rounds 1 {KINDS} --by-kind \
         -s obvhs-cwbvh,irregular-grid,irregular-grid:query=batch"
    ));
    let queries: Vec<Vec<Query>> =
        record.scenes.iter().map(|s| s.rows.iter().map(|r| r.query).collect()).collect();
    let (one, batch) = (Query::OneRay, Query::Batch);
    assert_eq!(queries, [vec![one, one, batch], vec![one, one, one]]);
    assert_eq!(record.summary[2].batch_scenes, 1);
    assert!(ended.out.contains("batch in 1 of 2"), "{}", ended.out);
    assert!(ended.out.contains("query: batch rows answer many rays together in one call"));
    let csv = folder.csv();
    let query = |scene: &str| {
        let mut rows = csv.iter().filter(|r| r["scene"] == scene);
        rows.find(|r| r["settings"] == "query=batch").unwrap()["query"].clone()
    };
    assert_eq!((query("pavilion").as_str(), query("balls:1").as_str()), ("batch", "one ray"));
    for row in &csv {
        assert!((row["ratio_primary"].parse::<f64>().unwrap() - 1.0).abs() < 1e-9);
        // a millisecond to build, one for each kind, 64 primary rays
        let picture = 0.001 + 0.002 * 1e6 / 64.0;
        assert!((row["picture_s"].parse::<f64>().unwrap() - picture).abs() < 1e-6, "{row:?}");
    }
    let markdown = folder.text("results.md");
    for title in ["pavilion: by kind of ray", "All scenes: by kind of ray", "Time to image"] {
        assert!(ended.out.contains(title) && markdown.contains(title), "{title}");
    }
    let page = run_over(REGISTRY, &format!("report {} -o -", folder.path()));
    assert!(page.out.contains("irregular-grid query=batch (batch)"), "{}", page.err);
    assert!(page.out.contains("Time to image"));
}

#[test]
fn a_run_without_batches_or_orders_prints_what_it_printed() {
    let (record, ended, _folder) = record_of("run tetra:2 --size 8 --rounds 1 -s obvhs-cwbvh,hug");
    assert!(!ended.out.contains("query") && !ended.out.contains("by kind of ray"), "{}", ended.out);
    // a record from before has none of the new fields
    let mut json = serde_json::to_value(&record).unwrap();
    let settings = json["settings"].as_object_mut().unwrap();
    without(settings, &["order", "lights", "by_kind"]);
    for row in json["scenes"][0]["rows"].as_array_mut().unwrap() {
        let row = row.as_object_mut().unwrap();
        without(row, &["query", "ratio_by_kind"]);
        row["samples"][0].as_object_mut().unwrap().remove("reference_by_kind").unwrap();
    }
    for row in json["summary"].as_array_mut().unwrap() {
        let row = row.as_object_mut().unwrap();
        without(row, &["batch_scenes", "ratio_by_kind"]);
    }
    let before: RunRecord = serde_json::from_value(json).unwrap();
    assert_eq!(before.settings, record.settings);
    assert_eq!(row(&before, "hug").query, Query::OneRay);
    assert!(row(&before, "hug").ratio_by_kind.is_empty());
}

/// Takes fields away that must be there.
fn without(object: &mut serde_json::Map<String, serde_json::Value>, names: &[&str]) {
    names.iter().for_each(|name| drop(object.remove(*name).unwrap()));
}

#[test]
fn options_override_those_of_a_set() {
    let (record, ..) = record_of("run pavilion --as speed --quick --size 8 --rounds 1 -s wide-bvh");
    let settings = &record.settings;
    assert_eq!(settings.rays, ["primary", "shadow", "diffuse"]);
    assert_eq!((settings.order.as_str(), settings.lights.as_str()), ("both", "first"));
    assert!(settings.by_kind && settings.resolution == [8, 8]);
    let rows: Vec<_> = record.scenes[0].rows.iter().map(|row| row.label()).collect();
    assert_eq!(rows, ["wide-bvh", "obvhs-cwbvh"], "what was typed, the reference");
    let ended = run_over(REGISTRY, "run pavilion --as sped");
    assert_eq!(ended.code, 2);
    assert!(ended.err.contains("did you mean 'speed'?"), "{}", ended.err);
}

/// Right on rays in the order of an image; loses every hit of a batch whose neighbours part.
struct OfNeighbours;

impl BatchFault for OfNeighbours {
    fn answer<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>) {
        let rays = batch.rays;
        let from_the_eye = rays.windows(2).all(|pair| pair[0].origin == pair[1].origin);
        // 16 pixels a line: the first two are neighbours
        let apart = match rays {
            [a, b, ..] if from_the_eye => {
                let cosine =
                    a.direction.to_dvec3().normalize().dot(b.direction.to_dvec3().normalize());
                cosine < 0.99
            }
            _ => false,
        };
        match &mut batch.answers {
            BatchAnswers::Closest(hits) if apart => hits.fill(Hit::NONE),
            _ => answered_by_brute_force(prims, batch),
        }
    }
}

type Coherent<S> = Batched<S, OfNeighbours>;

static COHERENT: StructureInfo = planted("coherent", "serves neighbours alone");

static WITH_COHERENT: &[Entry] = &[
    accel_core::entry!(obvhs::bvh2::ObvhsBvh2, obvhs::bvh2::INFO),
    accel_core::entry!(obvhs::cwbvh::ObvhsCwBvh, obvhs::cwbvh::INFO),
    accel_core::entry!(crate::speed::Coherent, COHERENT),
];

#[test]
fn a_structure_that_is_wrong_in_shuffled_order_alone_is_found() {
    let run = |order: &str| {
        let arguments = "run tetra:2 --size 16 --rounds 2 --rays primary -s obvhs-cwbvh,coherent";
        run_over(WITH_COHERENT, &format!("{arguments} --order {order}"))
    };
    let scanline = run("scanline");
    assert_eq!(scanline.code, 0, "{}{}", scanline.out, scanline.err);
    for order in ["both", "shuffled"] {
        let ended = run(order);
        assert_eq!(ended.code, 4, "{order}: {}{}", ended.out, ended.err);
        assert!(ended.out.contains("wrong: "), "{}", ended.out);
    }
}

/// Right, in packets.
struct InPackets;

impl BatchFault for InPackets {
    const BATCHES: Batches = Batches::Packets;

    fn answer<S: Scalar, P: PrimSet<S>>(prims: &P, batch: &mut RayBatch<'_, S>) {
        answered_by_brute_force(prims, batch);
    }
}

type OfPackets<S> = Batched<S, InPackets>;

static PACKETS: StructureInfo = planted("of-packets", "answers all rays of a batch at once");

#[test]
fn packets_are_counted_of_whole_batches_by_any_number_of_threads() {
    let registry = &[
        accel_core::entry!(obvhs::cwbvh::ObvhsCwBvh, obvhs::cwbvh::INFO),
        accel_core::entry!(crate::speed::OfPackets, PACKETS, prepare_compiled, false),
    ];
    for threads in [1, 3] {
        let folder = Folder::new();
        let arguments = format!(
            "run tetra:2 --size 80 --rounds 1 --rays primary -s of-packets --pass-limit 100s -j {threads} -o {}",
            folder.path()
        );
        let ended = run_over(registry, &arguments);
        assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
        let record = folder.record();
        let row = row(&record, "of-packets");
        let steps = row.work.as_ref().unwrap().traversal_steps;
        assert_eq!((row.rays, steps), (6400, 1), "{threads} threads");
    }
}

#[test]
fn avx512_is_off_where_the_environment_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let run = |value: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_rtbench"));
        command.args("run tetra:3 -s wide-bvh --quick --rounds 1 -o out".split(' '));
        command.current_dir(folder.path()).env("RTBENCH_AVX512", value).output().unwrap()
    };
    let refused = run("no");
    assert_eq!(refused.status.code(), Some(1));
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(said, "error: RTBENCH_AVX512 is \"no\", expected \"off\"\n");
    assert!(run("off").status.success());
    let record = std::fs::read_to_string(folder.path().join("out/results.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    assert_eq!(record["machine"]["batches_by_avx512"], false, "{}", record["machine"]);
}
