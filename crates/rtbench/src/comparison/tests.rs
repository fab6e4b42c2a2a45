use measurement::record::SceneRecord;
use regex_lite::Regex;

use super::ComparisonOutcome::*;
use super::*;
use measurement::record::made_up::run;

const OLD: [f64; 7] = [1.0, 1.01, 0.99, 1.02, 0.98, 1.0, 1.01];

fn times(factor: f64) -> [f64; 7] {
    OLD.map(|t| t * factor)
}

/// Two scenes of a reference and two rows.
fn record(grid: f64, tree: f64) -> RunRecord {
    let (grid, tree) = (times(grid), times(tree));
    let rows: [(&str, &[f64]); 3] =
        [("obvhs-cwbvh", &OLD), ("uniform-grid", &grid), ("kd-tree sah=0", &tree)];
    run(&[("balls", &rows), ("tetra", &rows)])
}

fn choice() -> ComparisonSettings {
    ComparisonSettings {
        metrics: default_metrics(),
        shows_equal: false,
        filter: None,
        margin: 0.05,
        threshold: None,
        is_forced: false,
    }
}

fn compared(
    old: &RunRecord,
    new: &RunRecord,
    choice: &ComparisonSettings,
) -> Result<Comparison, CompareError> {
    let named = |letter, path, run| NamedRun { letter, path, run };
    compare(named("A", "old.json", old), named("B", "new.json", new), choice)
}

fn refused(old: &RunRecord, new: &RunRecord, choice: &ComparisonSettings) -> String {
    compared(old, new, choice).unwrap_err().to_string()
}

fn forced(old: &RunRecord, new: &RunRecord, choice: ComparisonSettings) -> Comparison {
    compared(old, new, &ComparisonSettings { is_forced: true, ..choice }).unwrap()
}

/// Outcomes by scene, row and metric.
fn outcomes(comparison: &Comparison) -> Vec<(String, ComparisonOutcome)> {
    let of = |s: &SceneComparison| {
        let name = s.scene.clone();
        let line = |e: &Entry| (format!("{name}/{}/{}", e.label(), e.metric), e.outcome);
        s.entries.iter().map(line).collect::<Vec<_>>()
    };
    comparison.scenes.iter().flat_map(of).collect()
}

fn outcome(comparison: &Comparison, of: &str) -> ComparisonOutcome {
    let all = outcomes(comparison);
    all.iter().find(|(line, _)| line == of).unwrap_or_else(|| panic!("{of} of {all:?}")).1
}

#[test]
fn a_planted_slowdown_is_found_and_unchanged_rows_are_reported_unchanged() {
    let comparison = compared(&record(2.0, 3.0), &record(2.6, 3.0), &choice()).unwrap();
    for scene in ["balls", "tetra"] {
        for metric in ["build", "trace", "ratio"] {
            let of = |row| outcome(&comparison, &format!("{scene}/{row}/{metric}"));
            assert_eq!(of("uniform-grid"), Slower, "{metric}");
            assert_eq!(of("kd-tree sah=0"), NoDifference, "{metric}");
        }
    }
    let is_grid = |e: &&Entry| e.metric == "trace" && e.structure == "uniform-grid";
    let change = comparison.scenes[0].entries.iter().find(is_grid).unwrap().change;
    assert!((change.ratio.unwrap().median - 1.3).abs() < 1e-9 && change.p.unwrap() < 0.01);
    // exact metrics are equal and counted; the reference's ratio to itself is not compared
    assert_eq!(comparison.equal, 2 * 3 * 10);
    assert_eq!(comparison.scenes[0].entries.len(), 8);
    let is_grid = |m: &&Mean| m.structure == "uniform-grid" && m.metric == "trace";
    let mean = comparison.means.iter().find(is_grid).unwrap();
    assert_eq!((mean.scenes, mean.outcome), (2, Slower));
    assert!((mean.ratio.unwrap().median - 1.3).abs() < 1e-9);
    assert!(mean.ratio.unwrap().low > change.ratio.unwrap().low, "two scenes say more than one");
    let faster = compared(&record(2.0, 3.0), &record(1.6, 3.0), &choice()).unwrap();
    assert_eq!(outcome(&faster, "tetra/uniform-grid/trace"), Faster);
}

#[test]
fn counters_are_compared_exactly() {
    let (old, mut new) = (record(2.0, 3.0), record(2.0, 3.0));
    new.scenes[1].rows[1].work.as_mut().unwrap().intersection_tests += 1;
    new.scenes[1].rows[1].stats.as_mut().unwrap().n_ev = 5;
    let comparison = compared(&old, &new, &choice()).unwrap();
    assert_eq!(outcome(&comparison, "tetra/uniform-grid/n_it"), More);
    assert_eq!(outcome(&comparison, "tetra/uniform-grid/n_ev"), More);
    assert_eq!(comparison.equal, 58);
    let mean = |metric| comparison.means.iter().find(|m| m.metric == metric);
    let n_it = mean("n_it").unwrap().ratio.unwrap().median;
    assert!((n_it - (513.0f64 / 512.0).sqrt()).abs() < 1e-12);
    assert_eq!(mean("n_ev"), None, "what rises from 0 has no mean");
    let all =
        ComparisonSettings { metrics: METRICS.iter().collect(), shows_equal: true, ..choice() };
    let comparison = compared(&old, &new, &all).unwrap();
    assert_eq!(comparison.equal, 0);
    assert_eq!(outcome(&comparison, "tetra/uniform-grid/n_ts"), Equal);
}

#[test]
fn filter_and_threshold_choose_what_is_shown() {
    let (old, new) = (record(2.0, 3.0), record(2.2, 3.9));
    let filter = Some(Regex::new("^tetra/.*grid.*/trace$").unwrap());
    let shown = compared(&old, &new, &ComparisonSettings { filter, ..choice() }).unwrap();
    assert_eq!(outcomes(&shown), [("tetra/uniform-grid/trace".to_owned(), Slower)]);
    assert_eq!((shown.means.len(), shown.means[0].scenes), (1, 1));
    let above = ComparisonSettings { threshold: Some(0.2), ..choice() };
    let shown = compared(&old, &new, &above).unwrap();
    assert!(outcomes(&shown).iter().all(|(line, _)| line.contains("kd-tree")), "{shown:?}");
    assert_eq!((outcomes(&shown).len(), shown.below_threshold), (6, 10));
    let filter = Some(Regex::new("hug").unwrap());
    let error = refused(&old, &new, &ComparisonSettings { filter, ..choice() });
    assert!(
        error.starts_with("--filter 'hug' matches nothing among A: old.json, B: new.json"),
        "{error}"
    );
}

#[test]
fn incomparable_results_are_refused_with_all_reasons_unless_forced() {
    let (old, mut new) = (record(2.0, 3.0), record(2.0, 3.0));
    new.settings.threads = 2;
    new.settings.seed = 9;
    new.scenes[1].sha256 = "ef".into();
    let error = refused(&old, &new, &choice());
    assert_eq!(
        error,
        "cannot be compared (A: old.json, B: new.json): threads: 1, then 2; seed: 1, then 9; \
         scene tetra: sha256: cd, then ef; compare anyway with --force"
    );
    let forced = forced(&old, &new, choice());
    assert_eq!(forced.notes[0], "threads: 1, then 2; compared by --force");
    assert_eq!((forced.notes.len(), forced.scenes[1].entries.len()), (3, 8));
}

#[test]
fn across_machines_only_ratios_and_counters_are_compared() {
    let (old, mut new) = (record(2.0, 3.0), record(2.6, 3.0));
    new.machine.cpu = Some("Other CPU".into());
    let comparison = compared(&old, &new, &choice()).unwrap();
    let shown: Vec<String> = outcomes(&comparison).into_iter().map(|(line, _)| line).collect();
    assert!(shown.len() == 4 && shown.iter().all(|line| line.ends_with("/ratio")), "{shown:?}");
    assert_eq!(comparison.equal, 60);
    assert!(comparison.notes[0].starts_with("processor: Test CPU, then Other CPU; times in"));
    let seconds = ComparisonSettings {
        metrics: vec![measurement::record::metrics::named("trace").unwrap()],
        ..choice()
    };
    let error = refused(&old, &new, &seconds);
    assert!(
        error.contains("processor: Test CPU, then Other CPU; compare anyway with --force"),
        "{error}"
    );
    let forced = forced(&old, &new, seconds);
    assert_eq!(outcome(&forced, "tetra/uniform-grid/trace"), Slower);
    new.machine = old.machine.clone();
    new.settings.reference = "kd-tree".into();
    let comparison = compared(&old, &new, &choice()).unwrap();
    assert!(outcomes(&comparison).iter().all(|(line, _)| !line.ends_with("/ratio")));
    assert!(comparison.notes[0].contains("ratios to the reference are not compared"));
}

#[test]
fn everything_left_out_is_named() {
    let (mut old, mut new) = (record(2.0, 3.0), record(2.0, 3.0));
    old.scenes[0].rows.remove(1);
    new.scenes[0].rows.remove(2);
    new.scenes[1].rows[1].verdict = Verdict::Wrong;
    new.scenes[1].rows[2].rays = 128;
    new.scenes.push(SceneRecord { name: "rings".into(), ..new.scenes[0].clone() });
    new.planned = vec!["x".into(); 8];
    new.warnings = vec![measurement::record::Warning::NoisyMachine { spread: 0.5 }];
    let comparison = compared(&old, &new, &choice()).unwrap();
    let left = |scene: usize| -> Vec<String> {
        let left = comparison.scenes[scene].left_out.iter();
        left.map(|l| format!("{}: {}", l.label(), l.why)).collect()
    };
    assert_eq!(left(0), ["uniform-grid: only in B", "kd-tree sah=0: only in A"]);
    assert_eq!(
        left(1),
        ["uniform-grid: wrong in B", "kd-tree sah=0: trace, ratio over other rays, not compared"]
    );
    assert!(outcomes(&comparison).iter().all(|(line, _)| !line.contains("uniform-grid")));
    let forced = forced(&old, &new, choice());
    assert!(forced.scenes[1].left_out[1].why.ends_with("over other rays, compared by --force"));
    assert_eq!(outcome(&forced, "tetra/kd-tree sah=0/trace"), NoDifference);
    assert_eq!(outcome(&comparison, "tetra/kd-tree sah=0/build"), NoDifference);
    let said = &comparison.notes;
    assert_eq!(said[0], "B is incomplete: 3 of 8 scenes");
    assert!(said[1].starts_with("B: noisy machine"));
    assert_eq!(said[2..], ["only in B: rings"]);
    old.scenes.truncate(1);
    new.scenes.remove(0);
    let error = refused(&old, &new, &choice());
    assert!(error.ends_with("no scene in common: balls, then tetra, rings"), "{error}");
}

#[test]
fn changed_answers_are_reported_and_samples_of_other_rays_ignored() {
    let (old, mut new) = (record(2.0, 3.0), record(2.0, 3.0));
    new.scenes[1].rows[1].answers_sha256 = Some("ba".into());
    let comparison = compared(&old, &new, &choice()).unwrap();
    assert_eq!(comparison.answers_changed, ["tetra: uniform-grid"]);
    new.scenes[0].rows[1].verdict = Verdict::WrongAsShipped;
    let comparison = compared(&old, &new, &choice()).unwrap();
    assert_eq!(comparison.scenes[0].left_out[0].why, "ok in A, wrong (as shipped) in B, compared");
    new.scenes[1].rows[1].checked_rays = 128;
    assert!(compared(&old, &new, &choice()).unwrap().answers_changed.is_empty());
}

#[test]
fn an_interval_not_confirmed_by_the_rank_test_is_inconclusive() {
    // the later rounds lie in two heaps
    let heaps = [1.0, 1.0, 1.01, 1.01, 2.0, 2.01, 2.0, 2.01, 2.0];
    let level = [1.0, 1.01, 1.02, 1.0, 1.01, 1.02, 1.0, 1.01, 1.02];
    let of = |times: &[f64]| run(&[("tetra", &[("obvhs-cwbvh", &level), ("hug", times)])]);
    let two = of(&[1.5, 1.5, 1.5]);
    let comparison = compared(&of(&[1.0, 1.0, 1.0]), &two, &choice()).unwrap();
    assert_eq!(outcome(&comparison, "tetra/hug/trace"), Inconclusive, "three rounds");
    let said = comparison.notes.iter().find(|note| note.starts_with("3 rounds cannot be"));
    assert!(said.is_some_and(|note| note.contains("run --rounds 5")), "{:?}", comparison.notes);
    let comparison = compared(&of(&level), &of(&heaps), &choice()).unwrap();
    assert_eq!(outcome(&comparison, "tetra/hug/trace"), Inconclusive, "two heaps");
}

/// Times around 1 that are drawn anew for each run.
fn drawn(seed: u64, rows: usize) -> RunRecord {
    let mut random = statistics::random::Random::new(seed, "runs of one program");
    let mut times = || -> Vec<f64> {
        (0..9).map(|_| 1.0 + 0.3 * random.next_u64() as f64 / u64::MAX as f64).collect()
    };
    let names: Vec<String> = (0..rows).map(|i| format!("row{i}")).collect();
    let all: Vec<Vec<f64>> = (0..rows).map(|_| times()).collect();
    let rows: Vec<(&str, &[f64])> =
        names.iter().zip(&all).map(|(name, times)| (name.as_str(), &times[..])).collect();
    run(&[("tetra", &rows)])
}

#[test]
fn two_runs_of_one_program_differ_in_no_row_and_in_no_mean() {
    let mut alarms = 0;
    for seed in 0..40 {
        let (old, new) = (drawn(2 * seed, 12), drawn(2 * seed + 1, 12));
        let comparison = compared(&old, &new, &choice()).unwrap();
        for mean in comparison.means.iter().filter(|mean| mean.outcome != Equal) {
            let label = format!("tetra/{}/{}", mean.structure, mean.metric);
            assert_eq!(mean.outcome, outcome(&comparison, &label), "one scene, one verdict");
        }
        alarms += usize::from(outcomes(&comparison).iter().any(|(_, o)| o.is_change()));
    }
    // one comparison in twenty may have one
    assert!(alarms <= 4, "{alarms} of 40");
}

#[test]
fn the_floor_of_either_run_is_noise() {
    let old = record(2.0, 3.0);
    let mut new = record(2.6, 3.0);
    new.floor = measurement::record::FloorRecord::of([("planted".to_owned(), 1.4)].into_iter());
    let comparison = compared(&old, &new, &choice()).unwrap();
    assert_eq!(outcome(&comparison, "tetra/uniform-grid/trace"), Inconclusive);
    assert_eq!(outcome(&comparison, "tetra/kd-tree sah=0/trace"), NoDifference);
}

#[test]
fn runs_without_a_common_row_are_an_error() {
    let (old, mut new) = (record(2.0, 3.0), record(2.0, 3.0));
    for row in new.scenes.iter_mut().flat_map(|scene| &mut scene.rows) {
        row.structure = format!("{}2", row.structure);
    }
    let error = refused(&old, &new, &choice());
    assert!(error.contains("no row in common") && error.contains("--match"), "{error}");
}

#[test]
fn two_rounds_have_no_interval() {
    let few = run(&[("tetra", &[("obvhs-cwbvh", &[1.0, 1.0]), ("hug", &[2.0, 9.0])])]);
    let comparison = compared(&few, &few, &choice()).unwrap();
    assert_eq!(outcome(&comparison, "tetra/hug/trace"), TooFewRounds);
}
