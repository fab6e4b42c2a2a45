//! `rtbench sweep --sizes` end to end: slopes, limits, wrong rows, processes.

use std::collections::HashMap;
use std::process::Command;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};
use std::time::Duration;

use crate::common::{Ended, Folder, PLANTED, planted, run, run_in_world, run_stepping, run_with};
use accel_core::params::config::Settings;
use accel_core::primitives::Primitives;
use accel_core::query::sink::Sink;
use accel_core::structure::{BuildError, Structure, StructureInfo, StructureStats};
use accel_core::structures::brute_force::BruteForce;
use accel_core::structures::{Entry, obvhs};
use accel_core::{Ray, Scalar, occluders};
use measurement::record::{RunRecord, Verdict};
use measurement::rounds::trial::{BuildLimits, TrialBuild, TrialOutcome};
use measurement::scenes::InstalledScenes;
use measurement::settings::Precision;
use measurement::system::clock::{Clock, SteppingClock};
use measurement::system::world::World;

/// Three sizes of 16, 64 and 256 triangles, on few rays.
const SIZES: &str = "sweep tetra --sizes 16,64,256 --size 16 --rounds 2";

type Row = HashMap<String, String>;

fn csv(folder: &Folder, name: &str) -> Vec<Row> {
    csv::Reader::from_reader(folder.text(name).as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("CSV that parses back")
}

/// The verdicts of a row at each size.
fn verdicts(record: &RunRecord, row: &str) -> Vec<Verdict> {
    let of = |scene: &measurement::record::SceneRecord| {
        scene.rows.iter().find(|r| r.label() == row).map(|r| r.verdict)
    };
    record.scenes.iter().filter_map(of).collect()
}

fn slope(record: &RunRecord, row: &str, quantity: &str) -> Option<(f64, Option<[f64; 2]>, u64)> {
    let slope = record.scale.as_ref()?.slope(row, quantity)?;
    Some((slope.slope, slope.low.zip(slope.high).map(|(a, b)| [a, b]), slope.sizes))
}

#[test]
fn sizes_become_rows_slopes_and_plots() {
    let folder = Folder::new();
    let command = format!("{SIZES} -s uniform-grid,obvhs-cwbvh -o {}", folder.path());
    let ended = run_stepping(&command);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let rows = csv(&folder, "sweep.csv");
    let of = |column: &str| rows.iter().map(|r| r[column].clone()).collect::<Vec<_>>();
    assert_eq!(of("scene"), ["tetra:2", "tetra:2", "tetra:3", "tetra:3", "tetra:4", "tetra:4"]);
    assert_eq!(of("asked_primitives")[2..5], ["64", "64", "256"]);
    assert_eq!(of("primitives")[3..5], ["64", "256"], "the true counts");
    assert!(of("peak_build_bytes").iter().all(|n| n == "1048576"));
    assert!(of("reason").iter().all(String::is_empty));
    // a build of one step of the clock, a millisecond
    assert_eq!(of("build_ns_per_primitive")[..1], ["62500.000000000"]);
    let per_ray: f64 = rows[0]["trace_ns_per_ray"].parse().unwrap();
    let (seconds, rays): (f64, f64) =
        (rows[0]["trace_s"].parse().unwrap(), rows[0]["rays"].parse().unwrap());
    assert!((per_ray * rays / seconds / 1e9 - 1.0).abs() < 1e-6);
    let record = folder.record();
    assert_eq!(record.settings.rays, ["primary", "shadow"]);
    let kinds: Vec<&String> = record.scenes[0].rays.keys().collect();
    assert_eq!(kinds, ["primary", "shadow"]);
    let primary: Vec<u64> = record.scenes.iter().map(|s| s.rays["primary"]).collect();
    assert_eq!(primary, [256; 3], "the same number at every size");
    let (build, interval, sizes) = slope(&record, "uniform-grid", "build").unwrap();
    assert!(build.abs() < 1e-9 && interval.is_some() && sizes == 3, "the clock always says 1 ms");
    let memory = slope(&record, "uniform-grid", "memory").unwrap().0;
    assert!((0.5..1.5).contains(&memory), "{memory}");
    assert_eq!(csv(&folder, "slopes.csv").len(), 2 * 4);
    let svg = folder.text("sweep.svg");
    let tree = roxmltree::Document::parse(&svg).expect("well-formed XML");
    let texts: Vec<&str> = tree.descendants().filter_map(|n| n.text()).collect();
    for text in ["tetra: build time (s)", "uniform-grid (0.00)", "primitives"] {
        assert!(texts.contains(&text), "{text}: {texts:?}");
    }
    for text in ["tetra: slopes over", "[95%]", "tetra:4: 256 primitives"] {
        assert!(ended.out.contains(text) && folder.text("sweep.md").contains(text), "{text}");
    }
}

/// Nanoseconds that builds of [`Quadratic`] took.
static WORK: AtomicU64 = AtomicU64::new(0);

/// Brute force whose build takes the square of the number of primitives on [`WorkClock`].
struct Quadratic<S>(BruteForce<S>);

impl<S: Scalar> Structure<S> for Quadratic<S> {
    type Config = ();

    fn build(prims: &dyn Primitives<S>, settings: &Settings<()>) -> Result<Self, BuildError> {
        WORK.fetch_add(1000 * (prims.len() * prims.len()) as u64, SeqCst);
        <BruteForce<S> as Structure<S>>::build(prims, settings).map(Self)
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        self.0.traverse(ray, sink);
    }

    fn stats(&self) -> StructureStats {
        Structure::<S>::stats(&self.0)
    }
}

static QUADRATIC_INFO: StructureInfo = planted("quadratic", "takes its time");

static SLOW: &[Entry] = &[
    accel_core::entry!(obvhs::cwbvh::ObvhsCwBvh, obvhs::cwbvh::INFO),
    accel_core::entry!(crate::sweep_sizes::Quadratic, QUADRATIC_INFO),
];

/// Clock that advances by build times, and a microsecond per reading.
struct WorkClock(SteppingClock);

impl Clock for WorkClock {
    fn now(&self) -> Duration {
        self.0.now() + Duration::from_nanos(WORK.load(SeqCst))
    }
}

#[test]
fn a_quadratic_build_has_the_slope_two() {
    let folder = Folder::new();
    let clock = WorkClock(SteppingClock::new(Duration::from_micros(1)));
    let command = format!("{SIZES} --rays primary -s quadratic -o {}", folder.path());
    let ended = run_with(SLOW, &InstalledScenes, &clock, &command);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let record = folder.record();
    let (build, interval, _) = slope(&record, "quadratic", "build").unwrap();
    let [low, high] = interval.unwrap();
    assert!(low <= 2.0 && 2.0 <= high && low > 1.9 && high < 2.1, "{build} [{low}, {high}]");
    assert!(slope(&record, "quadratic", "trace").unwrap().0 < 0.5, "tracing is not what grew");
}

#[test]
fn wrong_answers_are_shown_as_such_and_have_no_slope() {
    let folder = Folder::new();
    // of more triangles, so few rays do not meet the first
    let few = "sweep tetra --sizes 16,64 --size 16 --rounds 2";
    let ended = run_stepping(&format!("{few} -s dropper,uniform-grid -o {}", folder.path()));
    assert_eq!(ended.code, 4, "{}", ended.out);
    let record = folder.record();
    assert_eq!(verdicts(&record, "dropper"), [Verdict::Wrong; 2]);
    assert_eq!(slope(&record, "dropper", "build"), None);
    assert!(slope(&record, "uniform-grid", "build").is_some());
    let rows = csv(&folder, "sweep.csv");
    let wrong = rows.iter().filter(|row| row["structure"] == "dropper");
    assert!(wrong.clone().all(|row| row["build_s"].is_empty() && row["verdict"] == "wrong"));
    assert!(ended.out.contains("wrong: "), "{}", ended.out);
}

/// Runs in a world where trials end so.
fn run_tried(trial_build: fn(&TrialBuild) -> TrialOutcome, arguments: &str) -> Ended {
    let clock = SteppingClock::new(Duration::from_millis(1));
    let world = World { trial_build, ..World::fixed() };
    run_in_world(&PLANTED, occluders::REGISTRY, &InstalledScenes, &clock, &world, arguments)
}

#[test]
fn rows_over_a_limit_are_named_and_not_retried() {
    let trials = |trial: &TrialBuild| match (trial.row.as_str(), trial.scene.as_str()) {
        ("uniform-grid", "tetra:3") => {
            TrialOutcome::OverLimit("building took more than 60 s".into())
        }
        ("uniform-grid", "tetra:4") => panic!("tried again"),
        _ => TrialOutcome::Ended { peak_bytes: None },
    };
    let folder = Folder::new();
    let command = format!("{SIZES} -s uniform-grid,obvhs-cwbvh -o {}", folder.path());
    let ended = run_tried(trials, &command);
    assert_eq!(ended.code, 0, "a limit is no failure: {}", ended.err);
    let record = folder.record();
    let (ok, over) = (Verdict::Ok, Verdict::OverLimit);
    assert_eq!(verdicts(&record, "uniform-grid"), [ok, over, over]);
    assert_eq!(verdicts(&record, "obvhs-cwbvh"), [ok; 3]);
    let reasons: Vec<String> =
        csv(&folder, "sweep.csv").into_iter().map(|mut r| r.remove("reason").unwrap()).collect();
    assert_eq!(reasons[2], "building took more than 60 s");
    assert_eq!(
        reasons[4],
        "not tried: over a limit at tetra:3 already: building took more than 60 s"
    );
    assert!(ended.out.contains(&reasons[2]) && ended.out.contains(&reasons[4]), "{}", ended.out);
    assert_eq!(slope(&record, "uniform-grid", "build"), None, "one size");
    assert_eq!(slope(&record, "obvhs-cwbvh", "peak"), None, "no peak is known");
    let svg = folder.text("sweep.svg");
    assert!(svg.contains("not ok at some size: uniform-grid"));
    assert!(!svg.contains("peak memory"), "a panel without points is left out");
}

#[test]
fn a_size_without_a_row_is_not_loaded() {
    let trials = |trial: &TrialBuild| match trial.scene.as_str() {
        "tetra:2" => TrialOutcome::Ended { peak_bytes: Some(7) },
        _ => TrialOutcome::OverLimit("loading the scene took more than 1 MiB of memory".into()),
    };
    let folder = Folder::new();
    let ended = run_tried(trials, &format!("{SIZES} -s obvhs-cwbvh -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let record = folder.record();
    assert_eq!((record.scenes[2].primitives, record.scenes[2].rays.len()), (256, 0));
    assert!(record.scenes[1].source.starts_with("not loaded"));
    assert!(record.scenes[1].rows[0].is_reference);
    assert!(ended.out.contains("not loaded: every row is over a limit"), "{}", ended.out);
}

#[test]
fn a_trial_that_dies_loses_its_row_and_fails() {
    let trials = |trial: &TrialBuild| match trial.row.as_str() {
        "uniform-grid" => TrialOutcome::Died("the process ended with signal 6".into()),
        _ => TrialOutcome::Ended { peak_bytes: None },
    };
    let folder = Folder::new();
    let command = format!("{SIZES} -s uniform-grid,obvhs-cwbvh -o {}", folder.path());
    let ended = run_tried(trials, &command);
    assert_eq!(ended.code, 1, "{}", ended.err);
    assert_eq!(verdicts(&folder.record(), "uniform-grid"), [Verdict::Panicked; 3]);
    assert!(ended.out.contains("signal 6"), "{}", ended.out);
}

/// The program as a process, which starts others.
fn process(arguments: &str) -> RunRecord {
    let folder = Folder::new();
    let ended = Command::new(env!("CARGO_BIN_EXE_rtbench"))
        .args(arguments.split_whitespace())
        .args(["--quick", "--rounds", "1", "-o", &folder.path()])
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "{arguments}: {said}");
    folder.record()
}

#[test]
#[cfg(target_os = "linux")]
fn processes_measure_the_peak_and_keep_the_limits() {
    let record = process("sweep hare --sizes 20k -s uniform-grid,light-buffer,obvhs-cwbvh");
    for row in &record.scenes[0].rows {
        let (peak, bytes) =
            (row.peak_build_bytes.unwrap(), row.stats.as_ref().unwrap().memory_bytes);
        assert!(row.verdict == Verdict::Ok && peak > bytes / 2, "{}: {peak}, {bytes}", row.label());
    }
    let of = |record: &RunRecord| {
        let row = &record.scenes[0].rows[0];
        (row.verdict, row.error.clone().unwrap_or_default())
    };
    let (verdict, reason) = of(&process("sweep tetra --sizes 64 -s obvhs-cwbvh --max-memory 1MiB"));
    assert_eq!(verdict, Verdict::OverLimit);
    assert!(reason.contains("more than 1.00 MiB of memory"), "{reason}");
    let (verdict, reason) = of(&process("sweep hare --sizes 20k -s kd-tree --time-limit 1us"));
    assert_eq!(verdict, Verdict::OverLimit);
    assert!(reason.starts_with("building took more than"), "{reason}");
}

#[test]
fn a_child_that_is_not_rtbench_is_an_error() {
    // the program that trials start is the running one: here, this test
    let trial = TrialBuild {
        scene: "tetra:1".into(),
        view: Default::default(),
        row: "uniform-grid".into(),
        threads: 1,
        precision: Precision::F32,
        limits: BuildLimits { seconds: 60.0, bytes: 1 << 40 },
    };
    let TrialOutcome::Died(reason) = trial.run() else { panic!("it cannot have built anything") };
    assert!(reason.contains("exit status"), "{reason}");
}

#[test]
fn scenes_without_the_sizes_are_usage_errors() {
    for (arguments, said) in [
        ("kitchen --sizes 1e3", "does not come in sizes; those that do: balls, gears"),
        ("kitchn --sizes 1e3", "unknown scene"),
        ("hare --sizes 1e3..1e9", "its sizes go from 8 to 19996488"),
        ("balls --sizes 1", "the nearest size of balls has 11 primitives"),
        ("hare --sizes 1e6..1e3", "is not below"),
        ("hare --sizes many", "1e3..1e7"),
        ("hare balls --sizes 1e3", "one generated scene"),
        ("hare --sizes 1e3 -s kd-tree -p max-leaf", "cannot be used with"),
        ("hare -s kd-tree,octree -p max-leaf --values 1", "one structure"),
        ("hare --sizes 1e3 -s light-buffer --rays primary", "answers shadow rays only"),
        ("hare --sizes 1e3 -s unifrom-grid", "did you mean 'uniform-grid'?"),
        ("hare --sizes 1e3 --max-memory lots", "8GiB"),
        ("hare --sizes 1e3 --max-memory 8", "8GiB"),
    ] {
        let ended = run(&format!("sweep {arguments}"));
        assert_eq!((ended.code, ended.out.as_str()), (2, ""), "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
    }
}
