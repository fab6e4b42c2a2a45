//! A wrong structure must be found out, must not show a time, and must end the run with 4.

use accel_core::params::config::Settings;
use accel_core::primitives::Primitives;
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats};
use accel_core::structures::{Entry, brute_force, find, uniform_grid};
use accel_core::{Ray, Scalar, Vector};
use measurement::record::{Verdict, Warning};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SystemClock;
use studies::run::lines::wrong_rays;

use crate::common::{
    DECLARED, Folder, PLANTED, SILENT, SILENT_SHADOWS, SilentAll, SilentShadows, WRONG_FIRST,
    WRONG_ONLY, planted, row, run_with,
};

fn run(registry: &[Entry], arguments: &str) -> crate::common::Ended {
    run_with(registry, &InstalledScenes, &SystemClock::default(), arguments)
}

#[test]
fn a_structure_that_drops_a_primitive_is_wrong_and_has_no_times() {
    let folder = Folder::new();
    let arguments = "run tetra:2 --quick -s obvhs-cwbvh,dropper,brute-force -o";
    let ended = run(&PLANTED, &format!("{arguments} {}", folder.path()));
    assert_eq!(ended.code, 4, "{}{}", ended.out, ended.err);
    let line = ended.out.lines().find(|l| l.starts_with("dropper")).unwrap();
    assert_eq!(line.matches("wrong").count(), 5, "four times and the verdict: {line}");
    let record = folder.record();
    let wrong = row(&record, "dropper");
    assert_eq!(wrong.verdict, Verdict::Wrong);
    assert!(wrong.mismatches > 0 && wrong.example.as_ref().is_some_and(|e| e.contains("ray")));
    assert!(wrong.samples.is_empty() && wrong.trace_s.is_none() && wrong.ratio.is_none());
    assert_eq!(row(&record, "obvhs-cwbvh").verdict, Verdict::Ok);
    assert_eq!(row(&record, "brute-force").verdict, Verdict::Ok);
    let csv = folder.csv();
    let wrong = csv.iter().find(|r| r["structure"] == "dropper").unwrap();
    assert_eq!(wrong["verdict"], "wrong");
    for times in ["build_s", "trace_s", "render_s", "ratio_to_reference", "primary_mrays"] {
        assert_eq!(wrong[times], "", "{times}");
    }
    assert!(folder.text("results.md").contains("| wrong |"));
    let summary = record.summary.iter().find(|s| s.structure == "dropper").unwrap();
    assert_eq!((summary.verdict, summary.ratio), (Verdict::Wrong, None));
}

#[test]
fn a_declared_defect_is_shown_and_is_no_failure() {
    let folder = Folder::new();
    let ended = run(DECLARED, &format!("run tetra:2 --quick -s all -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let record = folder.record();
    let shipped = row(&record, "dropper");
    assert_eq!(shipped.verdict, Verdict::WrongAsShipped);
    assert!(shipped.mismatches > 0 && shipped.trace_s.is_some());
    assert!(ended.out.contains("wrong (as shipped)") && ended.out.contains("forgets on purpose"));
    // the plots of the report say beside its name how many rays are wrong
    let report = run(DECLARED, &format!("report {} --no-pictures", folder.path()));
    assert_eq!(report.code, 0, "{}", report.err);
    let defect = format!("({})", wrong_rays(shipped.mismatches, shipped.checked_rays));
    let page = folder.text("report.html");
    assert!(page.matches(&defect).count() >= 2, "wide and narrow: {defect}");
}

#[test]
fn a_row_that_the_oracle_refutes_is_not_asked_first() {
    let folder = Folder::new();
    let ended = run(WRONG_FIRST, &format!("run tetra:2 --quick -o {}", folder.path()));
    assert_eq!(ended.code, 4);
    let record = folder.record();
    let oracle = &record.scenes[0].oracle;
    assert_eq!(oracle.reference.as_deref(), Some("brute-force"));
    assert!(oracle.refused.iter().any(|r| r.starts_with("dropper")), "{oracle:?}");
    assert!(ended.err.contains("not asked first"), "{}", ended.err);
    assert_eq!(row(&record, "dropper").verdict, Verdict::Wrong);
}

#[test]
fn without_any_right_structure_brute_force_decides_on_its_sample() {
    let folder = Folder::new();
    let ended = run(WRONG_ONLY, &format!("run tetra:2 --quick -o {}", folder.path()));
    assert_eq!(ended.code, 4);
    let record = folder.record();
    assert_eq!(record.scenes[0].oracle.reference, None);
    let row = row(&record, "dropper");
    assert_eq!(row.verdict, Verdict::Wrong);
    assert!(row.mismatches > 0 && row.checked_rays >= row.mismatches);
}

#[test]
fn real_structures_are_right_on_mixed_primitives_in_both_precisions() {
    for precision in ["f32", "f64"] {
        let folder = Folder::new();
        let real = "brute-force,uniform-grid,obvhs-bvh2,obvhs-cwbvh";
        let arguments = format!("run balls:2 gears:1 --quick -s {real} --precision {precision} -o");
        // those of the crate, not lines of our own, which would be compiled as tests are: slow
        let ended =
            run(accel_core::structures::REGISTRY, &format!("{arguments} {}", folder.path()));
        assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
        let record = folder.record();
        assert_eq!(record.settings.precision, precision);
        for scene in &record.scenes {
            assert_eq!(scene.oracle.reference.as_deref(), Some("wide-bvh"));
            assert!(scene.oracle.checked > 100 && scene.oracle.refused.is_empty());
            assert!(scene.rows.iter().all(|r| r.mismatches == 0 && r.checked_rays > 0));
            let total: u64 = scene.rays.values().sum();
            assert!(scene.rows.iter().filter(|r| r.checked_rays == total).count() >= 3);
        }
    }
}

/// Brute force that loses all hits of few rays, too few for the oracle's sample.
struct SeldomWrong<S> {
    ids: Vec<u32>,
    scalar: std::marker::PhantomData<S>,
}

static SELDOM: StructureInfo = planted("seldom", "loses the hits of few rays");
static ALIKE: StructureInfo = planted("alike", "loses the same hits");

impl<S: Scalar> Structure<S> for SeldomWrong<S> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, _: &Settings<()>) -> Result<Self, BuildError> {
        Ok(Self { ids: (0..prims.len() as u32).collect(), scalar: std::marker::PhantomData })
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        sink.elementary_step(false);
        let numbers = ray.direction.to_dvec3() * 1e7;
        let number = (numbers.x + numbers.y + numbers.z) as i64;
        if number.rem_euclid(499) != 0 {
            let _ = sink.test(&self.ids);
        }
    }

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

#[test]
fn brute_force_decides_where_rows_differ_whichever_is_asked_first() {
    let wrong_first: Vec<Entry> = [
        accel_core::entry!(crate::verdicts::SeldomWrong, SELDOM),
        accel_core::entry!(crate::verdicts::SeldomWrong, ALIKE),
    ]
    .into_iter()
    .chain(find("kd-tree").copied())
    .collect();
    // two that are wrong alike, checked before the one that is right, and after it
    for rows in ["seldom,alike,kd-tree", "kd-tree,alike"] {
        let folder = Folder::new();
        let arguments = format!("run tetra:2 --quick --size 128 -s {rows} -o {}", folder.path());
        let ended = run(&wrong_first, &arguments);
        assert_eq!(ended.code, 4, "{}{}", ended.out, ended.err);
        let record = folder.record();
        // it passed the sample, and is found out all the same
        let oracle = &record.scenes[0].oracle;
        assert_eq!(oracle.reference.as_deref(), Some("seldom"));
        assert!(oracle.refused.is_empty(), "{:?}", oracle.refused);
        let verdict = |name: &str| (row(&record, name).verdict, row(&record, name).mismatches);
        assert_eq!(verdict("kd-tree"), (Verdict::Ok, 0));
        let lost = verdict("alike").1;
        assert_eq!(verdict("alike"), (Verdict::Wrong, lost));
        assert!(lost > 0);
        if rows.starts_with("seldom") {
            assert_eq!(verdict("seldom"), (Verdict::Wrong, lost));
            let example = row(&record, "seldom").example.clone().unwrap();
            assert!(example.contains("no hit, expected primitive"), "{example}");
        }
    }
}

/// It can be built nowhere.
struct Refuses<S>(std::marker::PhantomData<S>);

static REFUSES: StructureInfo = planted("refuses", "cannot be built");

impl<S: Scalar> Structure<S> for Refuses<S> {
    type Config = ();

    fn build(_: &dyn Primitives<S>, settings: &Settings<()>) -> Result<Self, BuildError> {
        let structure = settings.structure();
        Err(BuildError::TooLarge { structure, what: "anything", needed: 1, limit: 0 })
    }

    fn traverse<K: Sink<S>>(&self, _: &Ray<S>, _: &mut K) {}

    fn stats(&self) -> StructureStats {
        StructureStats::default()
    }
}

static FAULTY: &[Entry] = &[
    accel_core::entry!(crate::verdicts::Refuses, REFUSES),
    accel_core::entry!(SilentAll, SILENT),
    accel_core::entry!(SilentShadows, SILENT_SHADOWS),
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
    accel_core::entry!(uniform_grid::UniformGrid, uniform_grid::INFO),
];

/// The structure that would be asked for answers first writes none.
static SILENT_FIRST: &[Entry] = &[
    accel_core::entry!(SilentAll, SILENT),
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
];
static SHADOWS_FIRST: &[Entry] = &[
    accel_core::entry!(SilentShadows, SILENT_SHADOWS),
    accel_core::entry!(brute_force::BruteForce, brute_force::INFO),
];

#[test]
fn unwritten_batch_answers_are_wrong_for_every_ray() {
    for (kind, name) in [("shadow", "silent-shadows"), ("shadow", "silent"), ("primary", "silent")]
    {
        let folder = Folder::new();
        let arguments = format!("run tetra:2 --quick -s {name},uniform-grid --rays {kind} -o");
        let ended = run(FAULTY, &format!("{arguments} {}", folder.path()));
        assert_eq!(ended.code, 4, "{kind}: {}{}", ended.out, ended.err);
        let record = folder.record();
        let silent = row(&record, name);
        assert_eq!(silent.verdict, Verdict::Wrong, "{kind}");
        // not one answer passes for one that happened to be right
        assert!(silent.checked_rays > 100 && silent.mismatches == silent.checked_rays, "{kind}");
        assert_eq!(row(&record, "uniform-grid").verdict, Verdict::Ok, "{kind}");
    }
}

#[test]
fn structures_without_answers_are_not_asked_first() {
    let arguments = "run tetra:2 --quick -s brute-force --rays primary,shadow";
    for (registry, said) in [
        (SILENT_FIRST, "not asked first: silent: primary ray "),
        (SHADOWS_FIRST, "not asked first: silent-shadows: shadow ray "),
    ] {
        let ended = run(registry, arguments);
        assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
        assert!(ended.err.contains(said), "{}", ended.err);
    }
}

#[test]
fn another_row_stands_in_for_a_reference_that_cannot_be_built() {
    let folder = Folder::new();
    let arguments = "run tetra:2 --quick --reference refuses -s brute-force,uniform-grid -o";
    let ended = run(FAULTY, &format!("{arguments} {}", folder.path()));
    // what was asked for could not be measured
    assert_eq!(ended.code, 1, "{}{}", ended.out, ended.err);
    let record = folder.record();
    assert_eq!(record.settings.reference, "refuses");
    let refused = row(&record, "refuses");
    assert_eq!((refused.verdict, refused.is_reference), (Verdict::NotBuilt, false));
    // not brute force, which is before it but measured on a sample of the rays
    let stands_in = row(&record, "uniform-grid");
    assert!(stands_in.is_reference);
    assert_eq!(stands_in.ratio.as_ref().map(|r| r.median), Some(1.0));
    assert!(row(&record, "brute-force").ratio.as_ref().is_some_and(|r| r.median > 0.0));
    let summary = |name: &str| record.summary.iter().find(|s| s.structure == name).unwrap();
    assert_eq!((summary("refuses").scenes, summary("refuses").not_built_scenes), (0, 1));
    for name in ["brute-force", "uniform-grid"] {
        assert!(summary(name).scenes == 1 && summary(name).ratio.is_some(), "{name}");
    }
    let instead = [("tetra:2".to_owned(), "uniform-grid".to_owned())].into();
    let warning = Warning::OtherReference { reference: "refuses".into(), instead };
    assert!(record.warnings.contains(&warning), "{:?}", record.warnings);
    assert!(ended.err.contains("ratios are to uniform-grid in tetra:2"), "{}", ended.err);
}
