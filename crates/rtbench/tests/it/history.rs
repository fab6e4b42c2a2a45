//! `rtbench history`: the site of a planted step and of noise alone, machines apart, folders that
//! are none.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{Ended, Folder, files_below, run_stepping};
use measurement::record::RunRecord;
use measurement::record::made_up;
use roxmltree::{Document, ParsingOptions};
use rtbench::history::{History, visits};
use statistics::change_points::Sensitivity;
use statistics::random::Random;

/// The first second of the first run, and the seconds from one to the next: a day.
const BEGINNING: u64 = 1_795_000_000;
const DAY: u64 = 86_400;

/// The commit of a run.
fn commit(i: u64) -> String {
    format!("{i:02}{}", "c".repeat(38))
}

/// A run of that night: `grid` takes `step` times as long from the 13th on; 1% of noise.
fn record(i: u64, step: f64) -> RunRecord {
    let mut random = Random::new(i, "night");
    let mut noisy = |seconds: f64| -> Vec<f64> {
        let mut around = || seconds * (0.99 + 0.02 * (random.next_u64() as f64 / u64::MAX as f64));
        (0..5).map(|_| around()).collect()
    };
    let slow = if i >= 12 { step } else { 1.0 };
    let rows = [("bvh", vec![1.0; 5]), ("grid", noisy(3.0 * slow)), ("grid density=4", noisy(2.0))];
    let rows: Vec<(&str, &[f64])> = rows.iter().map(|(name, times)| (*name, &times[..])).collect();
    let mut run = made_up::run(&[("tetra", &rows), ("a/b <c>", &rows[..2])]);
    run.tool.git_revision = Some(commit(i));
    run.started_unix_s = BEGINNING + i * DAY;
    for row in run.scenes.iter_mut().flat_map(|scene| &mut scene.rows) {
        row.figure(1);
    }
    run
}

fn keep(folder: &Folder, name: &str, run: &RunRecord) {
    let within = Path::new(&folder.path()).join(name);
    std::fs::create_dir_all(&within).unwrap();
    std::fs::write(within.join("results.json"), serde_json::to_string(run).unwrap()).unwrap();
}

/// Twenty of them, named so that the order of names is not theirs.
fn nights(step: f64) -> Folder {
    let folder = Folder::new();
    (0..20).for_each(|i| keep(&folder, &format!("night-{}", 20 - i), &record(i, step)));
    folder
}

fn site_of(folder: &Folder, more: &str) -> (Folder, Ended) {
    let site = Folder::new();
    let ended = run_stepping(&format!("history {} -o {}/site {more}", folder.path(), site.path()));
    (site, ended)
}

/// All pages of a site by their paths within it.
fn pages(site: &Folder) -> BTreeMap<PathBuf, String> {
    let root = Path::new(&site.path()).join("site");
    let page = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        (path.strip_prefix(&root).unwrap().to_owned(), text)
    };
    files_below(&root).into_iter().map(page).collect()
}

fn parsed(page: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(page, options).expect("a page that is well-formed XML")
}

fn text(page: &str) -> String {
    let tree = parsed(page);
    let texts = tree.descendants().filter(|n| n.is_text()).filter_map(|n| n.text());
    texts.collect::<Vec<_>>().join(" ")
}

#[test]
fn a_planted_step_is_found_at_its_commit_and_every_link_leads_somewhere() {
    let (site, ended) = site_of(&nights(1.08), "");
    assert_eq!(ended.code, 0, "{}", ended.err);
    let pages = pages(&site);
    let index = text(&pages[Path::new("index.html")]);
    let said = "12cccccccc";
    let before = "11cccccccc";
    assert!(
        index.contains(said) && index.contains("6 series changed: 6 slower, 0 faster"),
        "{index}"
    );
    assert!(index.contains("20 runs of 20 commits on 1 machine(s), 2026-11-18 to 2026-12-07"));
    // one page per scene, a structure and a quantity; of two scenes: all rays, build, primary rays
    assert_eq!(pages.len(), 1 + 2 + 2 * 3, "{:?}", pages.keys());
    let page = text(&pages[Path::new("tetra/grid-primary.html")]);
    let command = format!("git bisect start {said} {before}");
    assert!(page.contains("slower") && page.contains(&command), "{page}");
    assert!(
        page.contains("1.08 [1.0") && page.contains("No change was found."),
        "one setting of two"
    );
    for (path, page) in &pages {
        let tree = parsed(page);
        assert_eq!(tree.descendants().filter(|n| n.has_tag_name("script")).count(), 1, "{path:?}");
        for link in tree.descendants().filter_map(|n| n.attribute("href")) {
            let (file, place) = link.split_once('#').unwrap_or((link, ""));
            let mut target = path.parent().unwrap().to_owned();
            for part in Path::new(file) {
                if part == ".." { assert!(target.pop()) } else { target.push(part) }
            }
            let target = if file.is_empty() { path.clone() } else { target };
            let found = pages.get(&target).unwrap_or_else(|| panic!("{path:?}: {link}"));
            let has = |n: roxmltree::Node<'_, '_>| n.attribute("id") == Some(place);
            assert!(place.is_empty() || parsed(found).descendants().any(has), "{path:?}: {link}");
        }
    }
    // an earlier site is replaced; what is no site is not
    let later = nights(1.0);
    let again = format!("history {} -o {}/site", later.path(), site.path());
    assert_eq!(run_stepping(&again).code, 0);
    std::fs::write(format!("{}/site/index.html", site.path()), "mine").unwrap();
    let ended = run_stepping(&again);
    assert!(ended.code == 1 && ended.err.contains("exists"), "{}", ended.err);
}

#[test]
fn noise_alone_has_no_change() {
    let (site, ended) = site_of(&nights(1.0), "");
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(text(&pages(&site)[Path::new("index.html")]).contains("No change was found."));
}

#[test]
fn a_slower_machine_is_a_separate_line_and_not_a_change() {
    let folder = Folder::new();
    for i in 0..20 {
        // the second half on another machine, where everything is slower
        let mut run = if i < 10 { record(i, 1.0) } else { record(i + 2, 1.3) };
        if i >= 10 {
            run.machine.cpu = Some("another".into());
        }
        keep(&folder, &format!("night-{i}"), &run);
    }
    let visits = visits(&[PathBuf::from(folder.path())], None).unwrap();
    let history = History::new(visits, &Sensitivity::default(), 1);
    assert_eq!(history.benches.len(), 2);
    for (key, lines) in &history.lines {
        assert_eq!(lines.len(), 2, "{key:?}");
        for line in lines {
            let own = line.points.iter().map(|point| history.bench_of[point.visit]);
            assert!(own.into_iter().all(|bench| bench == line.bench));
        }
    }
    assert_eq!(history.changes().count(), 0, "together they would have one");
    let (_, ended) = site_of(&folder, "");
    assert_eq!(ended.code, 0, "{}", ended.err);
}

/// A repository in which each commit was made on the day before the one before it.
fn repository(commits: u64) -> (Folder, Vec<String>) {
    let folder = Folder::new();
    let git = |arguments: &[&str], when: u64| {
        let date = format!("{when} +0000");
        let ended = Command::new("git")
            .args(["-C", &folder.path(), "-c", "user.name=n", "-c", "user.email=e@example.org"])
            .args(arguments)
            .env("GIT_COMMITTER_DATE", &date)
            .env("GIT_AUTHOR_DATE", &date)
            .output()
            .unwrap();
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        String::from_utf8(ended.stdout).unwrap().trim().to_owned()
    };
    git(&["init", "--quiet"], 0);
    let ids = (0..commits).map(|i| {
        let subject = format!("change {i}");
        git(&["commit", "--quiet", "--allow-empty", "-m", &subject], BEGINNING - i * DAY);
        git(&["rev-parse", "HEAD"], 0)
    });
    let ids = ids.collect();
    (folder, ids)
}

#[test]
fn a_repository_says_the_order_and_the_subjects() {
    let (repository, ids) = repository(3);
    let folder = Folder::new();
    for (i, id) in (0..).zip(&ids) {
        let mut run = record(i, 1.0);
        run.tool.git_revision = Some(id.clone());
        keep(&folder, &format!("night-{i}"), &run);
    }
    let of = |repository: Option<&Path>| -> Vec<String> {
        let visits = visits(&[folder.path().into()], repository).unwrap();
        visits.iter().map(|visit| visit.name.clone()).collect()
    };
    assert_eq!(of(None), ["night-0", "night-1", "night-2"]);
    assert_eq!(of(Some(Path::new(&repository.path()))), ["night-2", "night-1", "night-0"]);
    let (site, ended) = site_of(&folder, &format!("--repository {}", repository.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(text(&pages(&site)[Path::new("index.html")]).contains("change 2"));
}

#[test]
fn unreadable_inputs_are_errors_that_name_them() {
    let empty = Folder::new();
    let (_, ended) = site_of(&empty, "");
    assert_eq!(ended.code, 1);
    assert!(ended.err.contains(&empty.path()) && ended.err.contains("no results.json"));
    let (_, ended) = site_of(&nights(1.0), "--repository /nowhere");
    assert!(ended.code == 1 && ended.err.contains("/nowhere"), "{}", ended.err);
    let nights = nights(1.0);
    let (repository, _) = repository(1);
    let (_, ended) = site_of(&nights, &format!("--repository {}", repository.path()));
    assert!(ended.code == 1 && ended.err.contains("no commit `"), "{}", ended.err);
    assert!(ended.err.contains("results.json"), "which record: {}", ended.err);
    let bad = Path::new(&nights.path()).join("night-7/results.json");
    std::fs::write(&bad, "{\n  \"schema_version\": nonsense").unwrap();
    let (_, ended) = site_of(&nights, "");
    assert!(ended.code == 1 && ended.err.contains("night-7"), "{}", ended.err);
    assert!(ended.err.contains("line 2, column"), "{}", ended.err);
    let missing = run_stepping("history /nowhere -o /nowhere/site");
    assert!(missing.code == 1 && missing.err.contains("/nowhere"), "{}", missing.err);
    for usage in ["history", "history DIR"] {
        assert_eq!(run_stepping(usage).code, 2, "{usage}");
    }
    let mut without_git = Command::new(env!("CARGO_BIN_EXE_rtbench"));
    without_git.env("PATH", "/nowhere").args(["history", &nights.path(), "--repository", "."]);
    let ended = without_git.args(["-o", "/nowhere/site"]).output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.code() == Some(1) && said.contains("cannot start git"), "{said}");
}
