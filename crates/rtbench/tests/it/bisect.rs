//! `rtbench bisect`: commits that are small scripts, each of which prints a time.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use crate::common::{Ended, Folder, run_stepping};

/// A repository whose commits have those files as `bench.sh`; none: it is not there.
struct Repository {
    folder: Folder,
    commits: Vec<String>,
}

impl Repository {
    fn new(scripts: &[Option<String>]) -> Self {
        let folder = Folder::new();
        let mut made = Self { folder, commits: Vec::new() };
        made.git(&["init", "--quiet"]);
        for (i, script) in scripts.iter().enumerate() {
            let path = Path::new(&made.folder.path()).join("bench.sh");
            match script {
                Some(script) => {
                    std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
                    let mode = std::fs::Permissions::from_mode(0o755);
                    std::fs::set_permissions(&path, mode).unwrap();
                }
                None => std::fs::remove_file(&path).unwrap(),
            }
            made.git(&["add", "--all"]);
            made.git(&["commit", "--quiet", "--allow-empty", "-m", &format!("change {i}")]);
            let id = made.git(&["rev-parse", "HEAD"]);
            made.commits.push(id);
        }
        made
    }

    fn git(&self, arguments: &[&str]) -> String {
        let ended = Command::new("git")
            .args([
                "-C",
                &self.folder.path(),
                "-c",
                "user.name=n",
                "-c",
                "user.email=e@example.org",
            ])
            .args(arguments)
            .output()
            .unwrap();
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        String::from_utf8(ended.stdout).unwrap().trim().to_owned()
    }

    fn bisect(&self, good: usize, bad: usize, more: &str) -> Ended {
        run_stepping(&format!(
            "bisect {} {} --repository {} --build true --binary bench.sh --rounds 9 {more}",
            self.commits[good],
            self.commits[bad],
            self.folder.path()
        ))
    }

    fn short(&self, i: usize) -> String {
        self.commits[i].chars().take(10).collect()
    }
}

/// Prints that time; a file that says which commit it is, so that no two are the same.
fn timed(i: usize, milliseconds: f64) -> Option<String> {
    Some(format!("# {i}\necho 'hello'\necho 'sort: {milliseconds} ms'\necho 'parse: 3 ms'"))
}

fn steps(n: usize, slow_from: usize) -> Vec<Option<String>> {
    (0..n).map(|i| timed(i, if i >= slow_from { 12.0 } else { 10.0 })).collect()
}

#[test]
fn the_planted_commit_is_found_and_nothing_is_left_behind() {
    let repository = Repository::new(&steps(9, 6));
    let ended = repository.bisect(0, 8, "");
    assert_eq!((ended.code, ended.err.as_str()), (0, ""), "{}", ended.out);
    let first = format!("{} is the first slow commit", repository.short(6));
    assert!(ended.out.contains(&first), "{}", ended.out);
    for (head, i, ratio) in [("before", 5, "1.00 [1.00, 1.00]"), ("it", 6, "1.20 [1.20, 1.20]")] {
        let line = ended.out.lines().find(|line| line.starts_with(&format!("  {head}: ")));
        let line = line.unwrap_or_else(|| panic!("{}", ended.out));
        assert!(line.contains(&repository.short(i)) && line.contains(&format!("change {i}")));
        assert!(line.contains(ratio), "{line}");
    }
    assert!(ended.out.contains("  after: "), "{}", ended.out);
    // the bad one, then halves: four commits of eight were asked
    let asked =
        ended.out.lines().filter(|line| line.starts_with("bad ") || line.starts_with("good "));
    assert_eq!(asked.count(), 4, "{}", ended.out);
    assert_eq!(repository.git(&["worktree", "list"]).lines().count(), 1);
    assert_eq!(repository.git(&["status", "--porcelain"]), "");
}

#[test]
fn what_cannot_be_built_or_told_is_skipped() {
    let mut scripts = steps(9, 6);
    scripts[4] = None;
    // every other turn fast, every other slow, the copy as the program: nothing can be told
    let counter = Folder::new();
    let file = format!("{}/count", counter.path());
    scripts[5] = Some(format!(
        "n=$(cat {file} 2>/dev/null || echo 0); echo $((n + 1)) > {file}\n\
         if [ $((n / 2 % 2)) = 0 ]; then echo 'sort: 10 ms'; else echo 'sort: 13 ms'; fi"
    ));
    let repository = Repository::new(&scripts);
    let ended = repository.bisect(0, 8, "");
    assert_eq!(ended.code, 0, "{}", ended.err);
    let (five, six) = (repository.short(5), repository.short(6));
    assert!(ended.out.contains("the build left no bench.sh"), "{}", ended.out);
    let one_of = format!("The first slow commit is one of {}, {five}, {six}", repository.short(4));
    assert!(ended.out.contains(&one_of), "{}", ended.out);
    let skipped =
        ended.out.lines().find(|line| line.starts_with("skipped") && line.contains(&five));
    assert!(skipped.is_some_and(|line| line.contains("sort 1.")), "{}", ended.out);
}

#[test]
fn nothing_to_find_is_said() {
    let repository = Repository::new(&steps(4, 9));
    let ended = repository.bisect(0, 3, "");
    assert_eq!(ended.code, 1);
    assert!(ended.err.contains("is not certainly slower than"), "{}", ended.err);
    // less than the threshold is not slow, and more than a smaller one is
    let mut scripts = steps(4, 9);
    scripts[2] = timed(2, 10.4);
    scripts[3] = timed(3, 10.4);
    let repository = Repository::new(&scripts);
    assert_eq!(repository.bisect(0, 3, "").code, 1);
    let ended = repository.bisect(0, 3, "-t 2%");
    let first = format!("{} is the first slow commit", repository.short(2));
    assert!(ended.out.contains(&first), "{}{}", ended.out, ended.err);
}

#[test]
fn what_makes_no_sense_is_an_error() {
    let mut scripts = steps(3, 1);
    scripts.push(Some("exit 3".to_owned()));
    let repository = Repository::new(&scripts);
    let backwards = repository.bisect(1, 0, "");
    assert_eq!(backwards.code, 2);
    assert!(backwards.err.contains("nothing lies between"), "{}", backwards.err);
    let of = |good: &str, bad: &str, more: &str| {
        let folder = repository.folder.path();
        run_stepping(&format!("bisect {good} {bad} --repository {folder} {more}"))
    };
    let unknown = of("nonsense", &repository.commits[1], "--binary bench.sh --build true");
    assert_eq!(unknown.code, 1);
    assert!(unknown.err.contains("no commit `nonsense`"), "{}", unknown.err);
    let unbuilt = of(&repository.commits[0], &repository.commits[1], "--binary x --build false");
    assert!(unbuilt.code == 1 && unbuilt.err.contains("the build ended with"), "{}", unbuilt.err);
    let row = of(&repository.commits[0], &repository.commits[1], "-- teapot");
    assert!(row.code == 2 && row.err.contains("SCENE/STRUCTURE"), "{}", row.err);
    assert_eq!(of(&repository.commits[0], &repository.commits[1], "").code, 2, "no rows");
    // the good one must run; a bad one that does not is none
    let broken = repository.bisect(0, 3, "");
    assert!(broken.code == 1 && broken.err.contains("exit status: 3"), "{}", broken.err);
    let empty = Folder::new();
    let none = run_stepping(&format!("bisect a b --repository {} -- t/s", empty.path()));
    assert!(none.code == 1 && none.err.contains(&empty.path()), "{}", none.err);
    assert_eq!(repository.git(&["worktree", "list"]).lines().count(), 1);
}
