//! Exports: complete, readable again, and the same for the same seed.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::common::{Ended, Folder, PLANTED, row, run_stepping, run_with};
use accel_core::structures::REGISTRY;
use measurement::record::SCHEMA_VERSION;
use measurement::record::Warning;
use measurement::scenes::{
    InstalledScenes, KnownScene, LoadError, LoadedScene, SceneCatalogue, SceneRef, SceneSource,
};
use measurement::system::clock::{Clock, SteppingClock, SystemClock};

pub const HEADER: &str = "scene,primitives,structure,settings,resolution,n_in,n_v,n_ev,n_oiv,n_it,\
    n_ts,n_ets,n_eets,saved_part,answers,rays,memory_bytes,pending_cells,build_s,build_s_low,build_s_high,\
    trace_s,trace_s_low,trace_s_high,render_s,first_image_s,ratio_to_reference,ratio_low,\
    ratio_high,reference,primary_mrays,shadow_mrays,secondary_mrays,diffuse_mrays,mismatches,verdict,build_outliers,trace_outliers,edge_mismatches,origin,\
    query,ratio_primary,ratio_primary_low,ratio_primary_high,ratio_shadow,ratio_shadow_low,\
    ratio_shadow_high,ratio_reflected,ratio_reflected_low,ratio_reflected_high,ratio_diffuse,\
    ratio_diffuse_low,ratio_diffuse_high,picture_s,picture_to_obvhs";

#[test]
fn the_csv_has_exactly_these_columns_and_a_row_for_each_scene_structure_and_setting() {
    let folder = Folder::new();
    let ended = run_stepping(&format!(
        "run tetra:2 balls:1 --size 24 -s uniform-grid,uniform-grid:density=1,obvhs-cwbvh -o {}",
        folder.path()
    ));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let text = folder.text("results.csv");
    assert_eq!(text.lines().next(), Some(HEADER));
    let rows = folder.csv();
    assert_eq!(rows.len(), 6);
    assert!(rows.iter().all(|r| r["verdict"] == "ok" && r["mismatches"] == "0"));
    let grid = &rows[1];
    assert_eq!(
        (grid["structure"].as_str(), grid["settings"].as_str()),
        ("uniform-grid", "density=1")
    );
    assert_eq!(grid["resolution"].split('x').count(), 3);
    for number in ["n_v", "n_it", "n_ts", "rays", "memory_bytes", "build_s", "trace_s"] {
        assert!(grid[number].parse::<f64>().is_ok_and(|x| x > 0.0), "{number}: {}", grid[number]);
    }
    let cwbvh = &rows[2];
    assert_eq!(cwbvh["ratio_to_reference"].parse::<f64>(), Ok(1.0));
    assert!(folder.text("results.md").contains("| uniform-grid density=1 |"));
}

/// Over the real registry alone.
fn run_real(arguments: &str) -> Ended {
    run_with(REGISTRY, &InstalledScenes, &SystemClock::default(), arguments)
}

#[test]
fn mailboxes_and_building_on_demand_are_reported() {
    let folder = Folder::new();
    let ended = run_real(&format!(
        "run tetra:4 --size 24 -s uniform-grid:density=8:mailbox=hash,recursive-grid:build=lazy -o {}",
        folder.path()
    ));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let rows = folder.csv();
    let number = |row: usize, column: &str| rows[row][column].parse::<f64>();
    assert!(number(0, "saved_part").is_ok_and(|x| x > 0.0 && x < 1.0));
    assert_eq!(rows[0]["pending_cells"], "");
    assert!(number(1, "pending_cells").is_ok() && number(1, "first_image_s").is_ok());
    assert_eq!(rows[1]["saved_part"], "");
    assert!(ended.out.contains("uniform-grid density=8 mailbox=hash: the mailbox saved"));
    assert!(ended.out.contains("recursive-grid build=lazy:") && ended.out.contains("first image"));
}

#[test]
fn the_lecture_is_put_beside_today() {
    let folder = Folder::new();
    let ended = run_real(&format!(
        "reproduce zachmann2007 --scenes tetra --quick --size 16 -o {}",
        folder.path()
    ));
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.out.contains("tetra: then uniform D=20.0 won, 1.44 times"), "{}", ended.out);
    let text = folder.text("zachmann2007.csv");
    assert_eq!(text.lines().count(), 7);
    assert!(text.contains("tetra,recursive,recursive-grid,ok,3.615384615,"), "{text}");
    let ended = run_real(
        "reproduce zachmann2007 --scenes teapot,tetra --quick --size 8 --rounds 1 --as-published",
    );
    let lines: Vec<Vec<&str>> =
        ended.out.lines().map(|line| line.split_whitespace().collect()).collect();
    let has = |line: &[&str]| lines.iter().any(|l| l == line);
    for line in
        [["structure", "teapot", "tetra"], ["recursive", "22.67", "7.23"], ["adaptive", "-", "-"]]
    {
        assert!(has(&line), "{line:?}: {}", ended.out);
    }
    let of = |title: &str| lines.iter().position(|l| l.join(" ") == title).expect("a title");
    let ours = &lines[of("T_R[s], this machine") + 2..][..6];
    assert!(ours.iter().all(|l| l.last().unwrap().parse::<f64>().is_ok()), "{ours:?}");
    for refused in ["--scenes lattice", "--reference hug", "--structures hug"] {
        let ended = run_real(&format!("reproduce zachmann2007 {refused}"));
        assert_eq!(ended.code, 2, "{refused}: {}", ended.err);
    }
    let ended = run_real("reproduce havran1999 --scenes tetra --structures hugs");
    assert!(ended.code == 2 && ended.err.contains("Octree84-C"), "{}", ended.err);
}

#[test]
fn json_holds_the_environment_and_every_sample() {
    let folder = Folder::new();
    let ended = run_stepping(&format!(
        "run tetra:2 --size 24 --rounds 6 -s uniform-grid,obvhs-cwbvh --rays primary,shadow -o {}",
        folder.path()
    ));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let record = folder.record();
    assert_eq!(record.schema_version, SCHEMA_VERSION);
    assert!(record.compiler.rustc.is_some() && record.compiler.target.is_some());
    assert!(record.machine.threads > 0 && !record.machine.os.is_empty());
    assert_eq!(record.settings.rays, ["primary", "shadow"]);
    assert_eq!(record.settings.reference, "obvhs-cwbvh");
    let scene = &record.scenes[0];
    assert_eq!((scene.name.as_str(), scene.primitives), ("tetra:2", 16));
    assert_eq!(scene.rays["primary"], 24 * 24);
    for row in &scene.rows {
        let rounds: Vec<u32> = row.samples.iter().map(|s| s.round).collect();
        assert_eq!(rounds, [0, 1, 2, 3, 4, 5]);
        for sample in &row.samples {
            let kinds: Vec<&str> = sample.trace_s.keys().map(String::as_str).collect();
            assert_eq!(kinds, ["primary", "shadow"]);
            assert!(sample.reference_trace_s.is_some());
        }
    }
}

#[test]
fn times_are_those_of_the_clock() {
    let folder = Folder::new();
    let arguments = "run tetra:2 --size 24 -s uniform-grid,obvhs-cwbvh --rays primary,shadow";
    run_stepping(&format!("{arguments} -o {}", folder.path()));
    let record = folder.record();
    let grid = row(&record, "uniform-grid");
    // One step of a millisecond for the build and for each of two kinds of rays.
    let near = |x: f64, y: f64| (x - y).abs() < 1e-12;
    assert!(grid.build_s.is_some_and(|e| near(e.median, 1e-3) && near(e.high, 1e-3)));
    assert!(grid.trace_s.is_some_and(|e| near(e.median, 2e-3) && near(e.low, 2e-3)));
    assert!(grid.ratio.is_some_and(|e| near(e.median, 1.0)));
    assert!(grid.render_s.is_some_and(|s| near(s, 1e-3)));
    assert!(near(grid.mrays["primary"], 24.0 * 24.0 / 1e-3 / 1e6));
}

#[test]
fn a_seed_fixes_schedule_and_work() {
    let positions = |seed: u64| {
        let folder = Folder::new();
        let arguments = format!("run tetra:2 --size 16 --seed {seed} -s all,brute-force -o");
        let ended = run_stepping(&format!("{arguments} {}", folder.path()));
        assert_eq!(ended.code, 4, "the planted structure is wrong: {}", ended.err);
        let rows = folder.record().scenes.remove(0).rows;
        rows.into_iter()
            .map(|r| (r.work, r.samples.iter().map(|s| s.position).collect::<Vec<_>>()))
            .collect::<Vec<_>>()
    };
    let first = positions(7);
    assert_eq!(first, positions(7));
    assert_ne!(first, positions(8));
}

#[test]
fn a_larger_time_budget_makes_more_rounds() {
    let folder = Folder::new();
    let arguments = "run tetra:2 --size 16 -s obvhs-cwbvh --rays primary --time-budget 1s";
    let ended = run_stepping(&format!("{arguments} -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let rounds = row(&folder.record(), "obvhs-cwbvh").samples.len();
    assert!((50..1000).contains(&rounds), "{rounds}");
    let arguments = arguments.replace("1s", "1ms");
    let ended = run_stepping(&format!("{arguments} --quick --overwrite -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert_eq!(row(&folder.record(), "obvhs-cwbvh").samples.len(), 3, "the least there is");
}

#[test]
fn slow_rows_are_compared_on_the_same_rays() {
    let folder = Folder::new();
    let arguments = "run tetra:4 --size 48 -s brute-force,obvhs-cwbvh --rounds 2 -j 2";
    let clock = SystemClock::default();
    let ended =
        run_with(&PLANTED, &InstalledScenes, &clock, &format!("{arguments} -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let record = folder.record();
    let (brute, fast) = (row(&record, "brute-force"), row(&record, "obvhs-cwbvh"));
    assert!(brute.rays <= fast.rays && brute.stride >= 1);
    assert!(brute.ratio.is_some_and(|e| e.median > 1.0));
    assert!(brute.samples.iter().all(|s| s.reference_trace_s.is_some()));
}

#[test]
fn an_unnamed_reference_is_added_when_asked_for() {
    let folder = Folder::new();
    let arguments =
        "run tetra:2 --size 16 --rounds 1 -s uniform-grid --reference obvhs-bvh2:preset=fast";
    let ended = run_stepping(&format!("{arguments} -o {}", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let record = folder.record();
    assert!(row(&record, "obvhs-bvh2 preset=fast").is_reference);
    assert_eq!(record.settings.reference, "obvhs-bvh2 preset=fast");
    assert_eq!(record.scenes[0].rows.len(), 2);
}

fn scene_of(name: &str) -> SceneRef {
    SceneCatalogue::embedded().unwrap().resolve(&[name.to_owned()]).unwrap().remove(0)
}

/// Two scenes; when the second is loaded, the first must be in the files already.
#[derive(Debug, Clone)]
struct Watching {
    scene: SceneRef,
    csv: PathBuf,
    seen: Arc<std::sync::Mutex<Vec<usize>>>,
}

impl KnownScene for Watching {
    fn known(&self) -> &SceneRef {
        &self.scene
    }
    fn known_mut(&mut self) -> &mut SceneRef {
        &mut self.scene
    }
    fn load(&self) -> Result<LoadedScene, LoadError> {
        let lines = std::fs::read_to_string(&self.csv).map_or(0, |text| text.lines().count());
        self.seen.lock().unwrap().push(lines);
        self.scene.load()
    }
}

impl SceneSource for Watching {
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
        let of =
            |name| Box::new(Self { scene: scene_of(name), ..self.clone() }) as Box<dyn KnownScene>;
        Ok(names.iter().flat_map(|_| ["tetra:1", "tetra:2"]).map(of).collect())
    }
}

#[test]
fn finished_scenes_are_written_before_the_next_begins() {
    let folder = Folder::new();
    let csv = PathBuf::from(folder.path()).join("results.csv");
    let scenes = Watching { scene: scene_of("tetra:1"), csv, seen: Arc::default() };
    let arguments = format!("run both --quick -s uniform-grid,obvhs-cwbvh -o {}", folder.path());
    let ended = run_with(&PLANTED, &scenes, &SystemClock::default(), &arguments);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert_eq!(*scenes.seen.lock().unwrap(), [1, 3], "the header, then the first scene's rows");
    assert_eq!(folder.csv().len(), 4);
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().flatten().collect();
    assert_eq!(left.len(), 4, "three outputs, the journal, no temporary files: {left:?}");
}

#[test]
fn a_failing_scene_loses_only_its_own_rows() {
    #[derive(Debug)]
    struct Failing(SceneRef);
    impl KnownScene for Failing {
        fn known(&self) -> &SceneRef {
            &self.0
        }
        fn known_mut(&mut self) -> &mut SceneRef {
            &mut self.0
        }
        fn load(&self) -> Result<LoadedScene, LoadError> {
            InstalledScenes.resolve(&["no-such-scene".to_owned()])?.remove(0).load()
        }
    }
    struct Both;
    impl SceneSource for Both {
        fn resolve(&self, _: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
            let mut scenes = InstalledScenes.resolve(&["tetra:1".to_owned()])?;
            let mut failing = Failing(scene_of("tetra:1"));
            failing.0.name = "failing".into();
            scenes.insert(0, Box::new(failing));
            Ok(scenes)
        }
    }
    let clock = SystemClock::default();
    let ended = run_with(&PLANTED, &Both, &clock, "run both --quick -s obvhs-cwbvh");
    assert_eq!(ended.code, 1);
    assert!(ended.err.contains("error: ") && ended.out.contains("tetra:1: 4 primitives"));
}

#[test]
fn outliers_are_counted_and_shown_and_a_noisy_machine_is_warned_of() {
    // a clock that jumps: one reading in 50 takes 40 steps
    struct Jumping(SteppingClock, std::sync::atomic::AtomicU32);
    impl Clock for Jumping {
        fn now(&self) -> Duration {
            let reading = self.1.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
            (0..if reading.is_multiple_of(50) { 40 } else { 1 })
                .fold(Duration::ZERO, |_, _| self.0.now())
        }
    }
    let clock = Jumping(SteppingClock::new(Duration::from_micros(10)), Default::default());
    let folder = Folder::new();
    let ended = run_with(
        &PLANTED,
        &InstalledScenes,
        &clock,
        &format!(
            "run tetra:2 --size 8 --rounds 30 -s uniform-grid,obvhs-cwbvh -o {}",
            folder.path()
        ),
    );
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.out.contains("Outliers (Tukey), included in all figures: "));
    let record = folder.record();
    let row = row(&record, "uniform-grid");
    assert_eq!(row.samples.len(), 30);
    let found = row.outliers.trace[1];
    assert!((1..10).contains(&found), "{found}");
    assert_eq!(folder.csv()[0]["trace_outliers"], found.to_string());
    assert!(!ended.err.contains("warning"), "few outliers are no noise: {}", ended.err);
}

#[test]
fn warnings_are_printed_and_kept() {
    let folder = Folder::new();
    let ended = run_stepping(&format!(
        "run tetra:2 --size 8 --rounds 3 -s obvhs-cwbvh -o {}",
        folder.path()
    ));
    assert_eq!(ended.code, 0);
    assert!(
        ended.err.starts_with("warning: too few rounds: the range of 3 holds"),
        "{}",
        ended.err
    );
    assert_eq!(folder.record().warnings, [Warning::TooFewRounds { rounds: 3 }]);
    assert!(folder.text("results.md").contains("- warning: too few rounds: "));
    let quiet = run_stepping("run tetra:2 --size 8 -s obvhs-cwbvh");
    assert_eq!((quiet.code, quiet.err.as_str()), (0, ""));
}

/// Of one round and of three there is no interval of 95%, and nothing is significant: not on the
/// screen, not in the tables, not in the report.
#[test]
fn few_rounds_have_no_interval_and_no_significance() {
    for (rounds, heading) in [
        ("--rounds 1", "One round: figures without intervals."),
        (
            "--quick",
            "3 rounds: brackets are the least and the largest of 3, no 95% intervals; nothing here is \
             significant.",
        ),
    ] {
        let folder = Folder::new();
        let run = "run tetra:1 tetra:2 --size 8 -s uniform-grid,brute-force,obvhs-cwbvh";
        let ended = run_stepping(&format!("{run} {rounds} -o {}", folder.path()));
        assert_eq!(ended.code, 0, "{}", ended.err);
        let report = run_stepping(&format!("report {} --no-pictures", folder.path()));
        assert_eq!(report.code, 0, "{}", report.err);
        for text in [ended.out, folder.text("results.md"), folder.text("report.html")] {
            let words: Vec<&str> = text.split_whitespace().collect();
            let text = words.join(" ");
            assert!(text.contains(heading), "{rounds}: {text}");
            let rest = text.replace(heading, "");
            for claim in ["95%", "significant"] {
                let place = rest.find(claim).map(|at| &rest[at.saturating_sub(80)..at + 20]);
                assert_eq!(place, None, "{rounds}");
            }
        }
    }
}
