//! `rtbench accuracy`: errors are real where variants are cheap, none where they are the reference,
//! and what cannot be is refused.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::common::{Ended, planted, run_with};
use accel_core::bvh;
use accel_core::params::config::Settings;
use accel_core::primitives::Primitives;
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats};
use accel_core::structures::{Entry, REGISTRY};
use accel_core::{Ray, Scalar};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;

fn run(arguments: &str) -> Ended {
    run_with(REGISTRY, &InstalledScenes, &SystemClock::default(), arguments)
}

/// A row of the CSV, by column.
type Row = BTreeMap<String, String>;

fn rows(folder: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(folder.join("accuracy.csv")).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| {
        header.iter().cloned().zip(record.iter().map(str::to_owned)).collect()
    };
    reader.records().map(|r| row(r.unwrap())).collect()
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap()
}

fn error_of(rows: &[Row], axis: &str, variant: &str) -> f64 {
    let row = rows.iter().find(|r| r["axis"] == axis && r["variant"] == variant);
    number(row.unwrap_or_else(|| panic!("{axis}: no {variant}")), "error")
}

#[test]
fn errors_are_real_and_references_have_none() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!(
        "accuracy triangle-test voxel-traversal ray-offset mailbox cell-insertion box-test --scene \
         pavilion --quick --rounds 3 --trials 4000 -o {}",
        folder.path().display()
    );
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
    let rows = rows(folder.path());
    for (axis, cheap, reference) in [
        ("triangle-test", "moeller-trumbore", "watertight"),
        ("triangle-test", "moeller-trumbore", "f64"),
        ("voxel-traversal", "accumulate", "f64"),
        ("ray-offset", "none", "error-bound"),
        ("ray-offset", "fixed", "error-bound"),
        ("cell-insertion", "exact", "padded-exact"),
        ("box-test", "plain", "f64"),
    ] {
        assert!(error_of(&rows, axis, cheap) > 0.0, "{axis}: {cheap}");
        assert_eq!(error_of(&rows, axis, reference), 0.0, "{axis}: {reference}");
    }
    for row in &rows {
        let is_by_kind = row["parts"].starts_with("primary=");
        // these rays are made anew in each pass
        assert_eq!(is_by_kind, row["axis"] != "ray-offset", "{row:?}");
    }
    assert!(ended.out.contains("time over that of moeller-trumbore, by kind of ray"));
    assert!(rows.iter().filter(|r| r["axis"] == "mailbox").all(|r| number(r, "error") == 0.0));
    for axis in ["triangle-test", "voxel-traversal", "ray-offset", "mailbox", "cell-insertion"] {
        let of_axis = || rows.iter().filter(|r| r["axis"] == axis);
        assert!(of_axis().count() >= 3, "{axis}");
        assert!(of_axis().any(|r| number(r, "ratio_to_cheapest") == 1.0), "{axis}");
        let svg = std::fs::read_to_string(folder.path().join(format!("{axis}.svg"))).unwrap();
        roxmltree::Document::parse(&svg).unwrap();
    }
    for file in ["summary.md", "accuracy.md", "accuracy.json", "leak.png", "acne.png"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn offsets_are_compared_with_the_smallest_and_their_errors_reported() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!(
        "accuracy ray-offset --scene teapot:3 --quick --rounds 3 --trials 4000 -o {}",
        folder.path().display()
    );
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
    let rows = rows(folder.path());
    let also = |variant: &str, name: &str| -> f64 {
        let row = rows.iter().find(|r| r["variant"] == variant).unwrap();
        let of_name = row["also"].split("; ").find_map(|a| a.strip_prefix(name)?.strip_prefix('='));
        of_name.unwrap_or_else(|| panic!("{name}: {}", row["also"])).parse().unwrap()
    };
    // no offset is below the smallest, one of 0.01 and one of 256 ulps far beyond
    let again = |variant| also(variant, "found again by their own test in 10^6");
    assert!(again("none") > 1e5 && again("error-bound") == 0.0);
    let median = |variant| also(variant, "times the smallest, median");
    assert!(median("none") < 1.0 && 1.0 < median("error-bound"));
    assert!(median("error-bound") < median("ulp-wise"), "{}", median("ulp-wise"));
    let elsewhere = |variant| also(variant, "refracted rays elsewhere in 10^6");
    assert!(elsewhere("none") > 1e5 && elsewhere("error-bound") == 0.0);
    let moved = |variant| also(variant, "refracted rays moved by 10^-9 diagonals, median");
    assert!(0.0 < moved("error-bound") && moved("error-bound") < moved("ulp-wise"));
    // a coarse mesh blocks some of what its shading says is lit, under any rule
    assert!(also("error-bound", "lit shadow rays blocked by their own mesh in 10^6") > 0.0);
    let acne = |variant| also(variant, "of these by the facet itself in 10^6");
    assert!(acne("none") > 1e5 && acne("error-bound") == 0.0);
}

#[test]
fn a_scene_without_smooth_surfaces_has_no_column_of_their_shadows() {
    let folder = tempfile::tempdir().unwrap();
    let folder_of = folder.path().display();
    let ended =
        run(&format!("accuracy ray-offset --scene balls:1 --quick --rounds 3 -o {folder_of}"));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let rows = rows(folder.path());
    assert!(rows.iter().all(|row| row["also"].contains("refracted rays elsewhere")));
    assert!(rows.iter().all(|row| !row["also"].contains("shadow rays")), "{rows:?}");
}

#[test]
fn spheres_precision_and_light_buffer_on_a_scene_of_spheres() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!(
        "accuracy sphere-test precision light-buffer --scene balls:2 --quick --rounds 3 --trials \
         4000 -o {}",
        folder.path().display()
    );
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
    let rows = rows(folder.path());
    assert!(error_of(&rows, "sphere-test", "naive") > 0.0);
    assert_eq!(error_of(&rows, "sphere-test", "rearranged"), 0.0);
    assert_eq!(error_of(&rows, "sphere-test", "f64"), 0.0);
    assert_eq!(error_of(&rows, "precision", "f64"), 0.0);
    assert_eq!(error_of(&rows, "light-buffer", "64^2"), 0.0);
}

#[test]
fn sampled_effects_state_the_error_of_their_reference() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!(
        "accuracy soft-shadows effect-gating --scene balls:1 --quick --rounds 3 -o {}",
        folder.path().display()
    );
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
    let rows = rows(folder.path());
    let soft: Vec<&Row> = rows.iter().filter(|r| r["axis"] == "soft-shadows").collect();
    assert!(soft.len() >= 3);
    for row in &soft {
        let (error, own) = (number(row, "error"), number(row, "reference_error"));
        assert!(own > 0.0);
        assert_eq!(row["below_reference"] == "true", error < 10.0 * own, "{row:?}");
    }
    assert_eq!(soft[0]["variant"], "left out");
    let ratio = |row: &Row| number(row, "ratio_to_cheapest");
    assert!(soft[1..].iter().any(|row| ratio(row) == 1.0), "ratios are to samples");
    assert!(ended.out.contains("effects: the price of each in scenes that use it"));
    let lines = ended.out.lines().filter(|line| line.starts_with("soft-shadows  "));
    let (advice, prices): (Vec<&str>, Vec<&str>) =
        lines.partition(|line| line.contains("half the error takes"));
    assert_eq!((advice.len(), prices.len()), (1, soft.len() - 1), "{}", ended.out);
    assert!(number(soft[0], "error") > 2.0 * number(soft[soft.len() - 1], "error"));
    let gating = rows.iter().filter(|r| r["axis"] == "effect-gating");
    assert!(gating.clone().count() == 3 && gating.clone().all(|r| number(r, "error") == 0.0));
}

#[test]
fn right_answers_have_a_price_step_by_step() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!(
        "accuracy right-answers --scene pavilion,teapot:3 --quick --rounds 3 --trials 3000 -o {}",
        folder.path().display()
    );
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
    let rows = rows(folder.path());
    for scene in ["pavilion", "teapot:3"] {
        for (subject, steps) in [("obvhs-cwbvh", 5), ("uniform-grid", 7), ("wide-bvh", 5)] {
            let is_of = |r: &&Row| r["scene"] == scene && r["subject"] == subject;
            let of: Vec<&Row> = rows.iter().filter(is_of).collect();
            assert_eq!(of.len(), steps, "{scene} {subject}");
            assert!(number(of[0], "error") > 0.0, "{scene} {subject}");
            assert_eq!(number(of[steps - 1], "error"), 0.0, "{scene} {subject}");
            assert!(ended.out.contains(&format!("{scene}, {subject}, step by step")));
        }
    }
}

/// A list that answers every k-th ray with a miss, whichever that is: its answers while it is
/// timed are not those that were judged.
pub struct Fickle<S> {
    ids: Vec<u32>,
    scalar: std::marker::PhantomData<S>,
}

static TRAVERSALS: AtomicU32 = AtomicU32::new(0);

impl<S: Scalar> Structure<S> for Fickle<S> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        let ids = (0..prims.len() as u32).collect();
        Ok(Self { ids, scalar: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, _: &Ray<S>, sink: &mut K) {
        // a prime: no number of rays makes it the same one in each pass
        if !TRAVERSALS.fetch_add(1, Ordering::Relaxed).is_multiple_of(101) {
            let _ = sink.test(&self.ids);
        }
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

static FICKLE: StructureInfo = StructureInfo {
    params: accel_core::structures::uniform_grid::INFO.params,
    ..planted("uniform-grid", "a liar in the place of a grid")
};

static PLANTED: &[Entry] = &[
    accel_core::entry!(bvh::WideBvh, bvh::INFO),
    accel_core::entry!(crate::accuracy::Fickle, FICKLE),
];

#[test]
fn a_variant_whose_answers_change_while_timed_is_caught() {
    let arguments = "accuracy mailbox --scene balls:1 --quick --rounds 3";
    let ended = run_with(PLANTED, &InstalledScenes, &SystemClock::default(), arguments);
    assert_eq!(ended.code, 1, "{}", ended.out);
    assert!(
        ended.out.contains("FAULT") && ended.out.contains("differ between timing and judging"),
        "{}",
        ended.out
    );
}

#[test]
fn axes_are_listed() {
    let ended = run("list axes");
    assert_eq!(ended.code, 0);
    assert!(
        ended.out.lines().count() == 17 && ended.out.contains("voxel-traversal  "),
        "{}",
        ended.out
    );
}

#[test]
fn unknown_axes_are_errors_and_unfit_scenes_warnings() {
    let ended = run("accuracy voxeltraversal");
    assert_eq!(ended.code, 2);
    assert!(ended.err.contains("did you mean 'voxel-traversal'?"), "{}", ended.err);
    let ended = run("accuracy triangle-test --scene balls:1 --quick --rounds 3");
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.contains("surrounded by triangles"), "{}", ended.err);
    // one axis of several
    let ended = run("accuracy triangle-test mailbox --scene balls:1 --quick --rounds 3");
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.contains("warning: triangle-test: scene balls:1"), "{}", ended.err);
}

#[test]
fn variants_are_rows_of_a_run_and_their_wrong_hits_known() {
    let ended =
        run("run teapot:3 --quick --rays primary -s wide-bvh,wide-bvh:triangle-test=watertight,\
         wide-bvh:triangle-test=pluecker,uniform-grid:traversal=f64,\
         uniform-grid:insertion=padded-exact");
    // another t in the last bits is known, not wrong
    assert_eq!(ended.code, 0, "{}\n{}", ended.out, ended.err);
    let ended = run("run balls:1 --quick -s obvhs-bvh2 --set rays.offset=nonsense");
    assert_eq!(ended.code, 2);
    assert!(ended.err.contains("error-bound"), "{}", ended.err);
}
