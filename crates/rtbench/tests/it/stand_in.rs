//! Scenes in which another row stands in for the reference, which cannot be built there or is
//! wrong: who reads the results sees which, and nothing mixes ratios to one with ratios to another.

use std::time::Duration;

use accel_core::params::config::Settings;
use accel_core::primitives::Primitives;
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats};
use accel_core::structures::{Entry, obvhs, uniform_grid};
use accel_core::{Ray, Scalar};
use measurement::record::{RunRecord, SceneRecord, Verdict, Warning};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SteppingClock;
use serde_json::Value;

use crate::common::{Dropper, Ended, Folder, PLANTED, planted, run_with};

/// Brute force over few primitives; more it refuses.
struct Small<S>(Vec<u32>, std::marker::PhantomData<S>);

impl<S: Scalar> Structure<S> for Small<S> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, settings: &Settings<()>) -> Result<Self, BuildError> {
        let (structure, needed) = (settings.structure(), prims.len() as u128);
        let refused = BuildError::TooLarge { structure, what: "primitives", needed, limit: 8 };
        let ids = (0..prims.len() as u32).collect();
        if needed > 8 { Err(refused) } else { Ok(Self(ids, std::marker::PhantomData)) }
    }

    fn traverse<K: Sink<S>>(&self, _: &Ray<S>, sink: &mut K) {
        let _ = sink.test(&self.0);
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

static REFERENCE: StructureInfo = planted("obvhs-cwbvh", "in place of the default reference");

/// The default reference is not built over more than 8 primitives: not over `tetra:2`.
static REFUSING: &[Entry] = &[
    accel_core::entry!(Small, REFERENCE),
    accel_core::entry!(obvhs::bvh2::ObvhsBvh2, obvhs::bvh2::INFO),
    accel_core::entry!(uniform_grid::UniformGrid, uniform_grid::INFO),
];

/// It is wrong.
static WRONG: &[Entry] = &[
    accel_core::entry!(Dropper, REFERENCE),
    accel_core::entry!(obvhs::bvh2::ObvhsBvh2, obvhs::bvh2::INFO),
    accel_core::entry!(uniform_grid::UniformGrid, uniform_grid::INFO),
];

static DEFECT: StructureInfo =
    StructureInfo { known_defect: |_| Some("drops hits on purpose"), ..REFERENCE };

/// It is wrong, and known to be.
static DEFECTIVE: &[Entry] = &[
    accel_core::entry!(Dropper, DEFECT),
    accel_core::entry!(obvhs::bvh2::ObvhsBvh2, obvhs::bvh2::INFO),
    accel_core::entry!(uniform_grid::UniformGrid, uniform_grid::INFO),
];

const RUN: &str = "run tetra:1 tetra:2 --size 16 --rounds 5 --seed 7 --by-kind \
                   -s uniform-grid,obvhs-bvh2,obvhs-cwbvh";

fn run(registry: &[Entry], arguments: &str) -> Ended {
    let clock = SteppingClock::new(Duration::from_millis(1));
    run_with(registry, &InstalledScenes, &clock, arguments)
}

/// The results of [`RUN`], which ends with that code.
fn results(registry: &[Entry], code: u8) -> Folder {
    let folder = Folder::new();
    let ended = run(registry, &format!("{RUN} -o {}", folder.path()));
    assert_eq!(ended.code, code, "{}{}", ended.out, ended.err);
    folder
}

fn reference(scene: &SceneRecord) -> String {
    let mut own = scene.rows.iter().filter(|row| row.is_reference);
    let label = own.next().expect("a reference").label();
    assert!(own.next().is_none());
    label
}

fn warning(record: &RunRecord) -> &Warning {
    let is_meant = |w: &&Warning| matches!(w, Warning::OtherReference { .. });
    record.warnings.iter().find(is_meant).expect("a warning")
}

#[test]
fn a_scene_that_refuses_the_reference_has_ratios_to_the_next_row() {
    let folder = Folder::new();
    let ended = run(REFUSING, &format!("{RUN} -o {}", folder.path()));
    // a row could not be measured
    assert_eq!(ended.code, 1, "{}{}", ended.out, ended.err);
    let record = folder.record();
    assert_eq!(record.settings.reference, "obvhs-cwbvh");
    let references: Vec<String> = record.scenes.iter().map(reference).collect();
    assert_eq!(references, ["obvhs-cwbvh", "uniform-grid"]);
    assert_eq!(record.scenes[1].rows[2].verdict, Verdict::NotBuilt);
    for row in &record.scenes[1].rows[..2] {
        assert!(row.ratio.is_some() && row.build_ratio.is_some(), "{}", row.label());
        assert!(row.ratio_by_kind.contains_key("primary"), "{}", row.label());
    }
    let said = warning(&record).to_string();
    let both = "obvhs-cwbvh was not built or is wrong, so ratios are to uniform-grid in tetra:2";
    assert!(said.contains(both) && ended.err.contains(both), "{said}: {}", ended.err);
    // no mean is over both
    for row in &record.summary {
        assert_eq!(row.scenes, 1, "{}", row.structure);
        let of_first = record.scenes[0].rows.iter().find(|r| r.structure == row.structure).unwrap();
        let medians = [&row.ratio, &of_first.ratio].map(|r| r.as_ref().map(|r| r.median));
        assert_eq!(medians[0], medians[1], "{}", row.structure);
    }
    let unbuilt = record.summary.iter().find(|row| row.structure == "obvhs-cwbvh").unwrap();
    assert_eq!(unbuilt.not_built_scenes, 1);
}

#[test]
fn tables_files_and_the_page_name_the_row_that_stands_in() {
    let folder = results(REFUSING, 1);
    let csv = folder.csv();
    let of = |scene: &str, structure: &str| {
        let is_meant = |row: &&std::collections::HashMap<String, String>| {
            row["scene"] == scene && row["structure"] == structure
        };
        csv.iter().find(is_meant).unwrap()["reference"].clone()
    };
    assert_eq!(of("tetra:1", "obvhs-bvh2"), "obvhs-cwbvh");
    assert_eq!(of("tetra:2", "obvhs-bvh2"), "uniform-grid");
    assert_eq!(of("tetra:2", "obvhs-cwbvh"), "", "it has no ratio");
    let markdown = folder.text("results.md");
    for said in [
        "Ratios are to uniform-grid, as obvhs-cwbvh is not built here.",
        "Ratios to obvhs-cwbvh: geometric means over 1 scene(s).",
        "Means leave out scenes whose ratios are to another row: uniform-grid in tetra:2.",
        "rays per second over those of uniform-grid",
        "warning: other reference: obvhs-cwbvh",
    ] {
        assert!(markdown.contains(said), "{said}: {markdown}");
    }
    assert_eq!(run(REFUSING, &format!("report {}", folder.path())).code, 0);
    let page = folder.text("report.html");
    for said in [
        "Ratios are to obvhs-cwbvh (uniform-grid in tetra:2).",
        "tetra:2: times over those of uniform-grid",
        "Times over those of obvhs-cwbvh, geometric means over 1 scene(s)",
        "other reference: obvhs-cwbvh",
    ] {
        assert!(page.contains(said), "{said}");
    }
}

#[test]
fn a_time_series_of_ratios_has_one_reference() {
    let folder = Folder::new();
    run(REFUSING, &format!("{RUN} --export-github-smaller {}/smaller.json", folder.path()));
    let all: Vec<Value> = serde_json::from_str(&folder.text("smaller.json")).unwrap();
    let units = |scene: &str| -> Vec<&str> {
        let own = all.iter().filter(|m| m["name"].as_str().unwrap().starts_with(scene));
        own.map(|m| m["unit"].as_str().unwrap()).collect()
    };
    let (both, other) = (units("tetra:1"), units("tetra:2"));
    assert!(both.contains(&"ratio") && both.contains(&"s"), "{both:?}");
    assert!(!other.contains(&"ratio") && other.contains(&"s"), "{other:?}");
}

#[test]
fn a_wrong_reference_is_replaced() {
    let folder = results(WRONG, 4);
    let record = folder.record();
    for scene in &record.scenes {
        assert_eq!(reference(scene), "uniform-grid");
        assert_eq!(scene.rows[2].verdict, Verdict::Wrong);
        assert!(scene.rows[1].ratio.is_some() && scene.rows[2].ratio.is_none());
    }
    // there is but one reference, though not the one that was meant
    assert!(record.summary.iter().filter(|row| row.ratio.is_some()).all(|row| row.scenes == 2));
    let markdown = folder.text("results.md");
    assert!(markdown.contains("Ratios to uniform-grid: geometric means over 2 scene(s)."));
    assert!(markdown.contains("Ratios are to uniform-grid, as obvhs-cwbvh is wrong here."));
}

#[test]
fn a_reference_with_a_known_defect_stays() {
    let folder = results(DEFECTIVE, 0);
    let record = folder.record();
    for scene in &record.scenes {
        assert_eq!(reference(scene), "obvhs-cwbvh");
        let [grid, bvh, own] = &scene.rows[..] else { panic!() };
        assert!(own.verdict == Verdict::WrongAsShipped && own.mismatches > 0);
        // brute force decides where it differs: all others are right
        assert_eq!(scene.oracle.reference.as_deref(), Some("uniform-grid"));
        assert!([grid, bvh].iter().all(|row| row.verdict == Verdict::Ok && row.ratio.is_some()));
    }
    assert!(!record.warnings.iter().any(|w| matches!(w, Warning::OtherReference { .. })));
    let markdown = folder.text("results.md");
    assert!(markdown.contains("Ratios to obvhs-cwbvh: geometric means over 2 scene(s)."));
    assert!(markdown.contains("wrong (as shipped)") && markdown.contains("drops hits on purpose"));
}

#[test]
fn obvhs_as_its_authors_use_it_is_the_reference_where_it_is_among_the_rows() {
    let of = |rows: &str, options: &str| {
        let folder = Folder::new();
        let command = format!("run tetra:2 --size 8 --rounds 1 {options} -s {rows} -o");
        let ended = run(accel_core::structures::REGISTRY, &format!("{command} {}", folder.path()));
        assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
        let record = folder.record();
        assert_eq!(reference(&record.scenes[0]), record.settings.reference);
        record.settings.reference
    };
    let robust = "obvhs-cwbvh:adapter=robust";
    assert_eq!(of(&format!("hug,{robust},obvhs-cwbvh"), ""), "obvhs-cwbvh");
    assert_eq!(of(&format!("hug,{robust}"), ""), "obvhs-cwbvh adapter=robust");
    assert_eq!(of("hug,obvhs-bvh2", ""), "hug");
    assert_eq!(of("hug,obvhs-cwbvh", "--reference hug"), "hug");
    // an occluder is compared with it, too
    assert_eq!(of("light-buffer", "--rays shadow"), "obvhs-cwbvh");
}

#[test]
fn runs_are_not_compared_where_their_references_differ() {
    let (built, refused) = (results(&PLANTED, 0), results(REFUSING, 1));
    let compare = |options: &str| {
        let paths = format!("{} {}", built.path(), refused.path());
        let ended = run(&PLANTED, &format!("compare {paths} -m all {options}"));
        assert_eq!(ended.code, 0, "{}", ended.err);
        ended.out
    };
    let said = "scene tetra:2: ratios to obvhs-cwbvh in A, to uniform-grid in B,";
    let out = compare("");
    assert!(out.contains(&format!("{said} not compared")), "{out}");
    let forced = compare("--force");
    assert!(forced.contains(&format!("{said} compared by --force")), "{forced}");
    let ratios = |options: &str| -> Vec<Value> {
        let comparisons: Value = serde_json::from_str(&compare(options)).unwrap();
        let scenes = comparisons[0]["scenes"].as_array().unwrap().iter();
        let of = |scene: &Value| {
            let entries = scene["entries"].as_array().unwrap().iter();
            let is_ratio = |e: &&Value| e["metric"].as_str().unwrap().contains("ratio");
            entries.filter(is_ratio).count().into()
        };
        let means = comparisons[0]["means"].as_array().unwrap().iter();
        let bvh = |m: &&Value| m["structure"] == "obvhs-bvh2" && m["metric"] == "ratio";
        let over = means.clone().find(bvh).map_or(Value::Null, |m| m["scenes"].clone());
        scenes.map(of).chain([over]).collect()
    };
    let [of_first, of_other, over] = &ratios("--format json")[..] else { panic!() };
    assert!(of_first.as_u64() > Some(0));
    assert_eq!((of_other.as_u64(), over.as_u64()), (Some(0), Some(1)));
    let [_, of_other, over] = &ratios("--format json --force")[..] else { panic!() };
    assert!(of_other.as_u64() > Some(0) && over.as_u64() == Some(2));
}

#[test]
fn a_check_judges_no_ratios_to_another_row() {
    let (built, refused) = (results(&PLANTED, 0), results(REFUSING, 1));
    let check = |folder: &Folder, options: &str| {
        let baseline = format!("--baseline {}/results.json", folder.path());
        run(REFUSING, &format!("check {baseline} {options}"))
    };
    // that it is not built any more is the regression
    let ended = check(&built, "--all");
    assert_eq!(ended.code, 3, "{}{}", ended.out, ended.err);
    let said = ended.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("was ok, is not built"), "{}", ended.out);
    assert!(said.contains("ratios were to obvhs-cwbvh, are to uniform-grid"), "{}", ended.out);
    // where it was not built before either, the same row stands in, whatever is asked for
    for options in ["--all", "--all -s obvhs-bvh2"] {
        let ended = check(&refused, options);
        assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
        let said = "ratios to obvhs-cwbvh (uniform-grid in tetra:2) in the same rounds";
        assert!(ended.out.contains(said), "{}", ended.out);
        assert!(!ended.out.contains("ratios were to"), "{}", ended.out);
    }
}

#[test]
fn shards_have_no_substitute_reference() {
    // each part has other rows: they would have other references
    let (folder, joined) = (Folder::new(), Folder::new());
    let parts: Vec<String> = (1..=2)
        .map(|index| {
            let path = format!("{}/{index}", folder.path());
            let part = format!(
                "run tetra:2 --size 16 --rounds 3 -s uniform-grid,obvhs-bvh2,obvhs-cwbvh \
                                --shard {index}/2 -o {path}"
            );
            assert_eq!(run(REFUSING, &part).code, 1);
            path
        })
        .collect();
    let merged = run(REFUSING, &format!("merge {} -o {}", parts.join(" "), joined.path()));
    assert_eq!(merged.code, 1, "{}", merged.err);
    let record = joined.record();
    let rows = &record.scenes[0].rows;
    let labels: Vec<String> = rows.iter().map(|row| row.label()).collect();
    assert_eq!(labels, ["uniform-grid", "obvhs-bvh2", "obvhs-cwbvh"]);
    assert_eq!(reference(&record.scenes[0]), "obvhs-cwbvh");
    assert!(rows.iter().all(|row| row.ratio.is_none()));
    assert!(rows[0].trace_s.is_some() && rows[1].trace_s.is_some());
}
