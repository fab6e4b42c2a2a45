//! The Slurm recipe of docs/ci.md as it stands there, with a part that has a wrong row. Scenes and
//! rows are smaller, and a script stands in for `sbatch`: it runs jobs at once and honours their
//! dependencies.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use super::{compiled, root};
use crate::common::{Folder, row};
use measurement::record::Verdict;

/// Keeps the exit codes of each job in a file; a job whose dependency is not met never runs.
const SBATCH: &str = r#"#!/bin/bash
array= after=
for argument in "$@"; do
    case $argument in
    --array=*) array=${argument#*=} ;;
    --dependency=*) after=${argument#*=} ;;
    --parsable) ;;
    *) script=$argument ;;
    esac
done
mkdir -p jobs
job=$(($(ls jobs | wc -l) + 1))
: > jobs/$job
echo $job
case $after in
afterok:*) if grep -qv '^0$' "jobs/${after#*:}"; then exit 0; fi ;;
afterany:* | "") ;;
*) exit 1 ;;
esac
[ -n "$array" ] || array=$(sed -n 's/^#SBATCH --array=//p' "$script")
for task in $(seq ${array%-*} ${array#*-}); do
    code=0
    SLURM_ARRAY_TASK_ID=$task bash "$script" >> log 2>&1 || code=$?
    echo $code >> jobs/$job
done
[ -n "$array" ] || { bash "$script" >> log 2>&1; echo $? >> jobs/$job; }
"#;

/// A folder with the recipe's files and programs.
struct Cluster(Folder);

impl Cluster {
    fn new(plugin: &Path) -> Self {
        let cluster = Self(Folder::new());
        let rtbench = format!(
            "#!/bin/sh\ncase $1 in run) exec {0} \"$@\" --plugin {1} ;; *) exec {0} \"$@\" ;; esac\n",
            env!("CARGO_BIN_EXE_rtbench"),
            plugin.display()
        );
        std::fs::create_dir(cluster.path("bin")).unwrap();
        for (name, text) in [("bin/sbatch", SBATCH), ("bin/rtbench", &rtbench)] {
            cluster.write(name, text);
            let mode = std::fs::Permissions::from_mode(0o755);
            std::fs::set_permissions(cluster.path(name), mode).unwrap();
        }
        let chapter = std::fs::read_to_string(root().join("docs/ci.md")).unwrap();
        let recipe = chapter.split("### Slurm").nth(1).unwrap();
        let blocks: Vec<&str> = recipe.split("```").skip(1).step_by(2).collect();
        let [array, merge, sent, ..] = blocks[..] else { panic!("{recipe}") };
        let block = |text: &str| text.strip_prefix("sh\n").unwrap().to_owned();
        let small = "run tetra:2 tetra:3 --size 12 --rounds 2 \
                     -s uniform-grid:density=1,uniform-grid,minimal-cpp,obvhs-cwbvh --shard";
        let array = replaced(&block(array), "run real --time-budget 30m --shard", small);
        let array = replaced(&replaced(&array, "1-8", "1-3"), "ID/8", "ID/3");
        cluster.write("array.sh", &array);
        let others = " part-4 part-5 part-6 part-7 part-8";
        cluster.write("merge.sh", &replaced(&block(merge), others, ""));
        cluster.write("send.sh", &replaced(&block(sent), "rtbench scenes fetch\n", ""));
        cluster
    }

    fn path(&self, name: &str) -> String {
        format!("{}/{name}", self.0.path())
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Runs a line of a shell.
    fn shell(&self, line: &str) {
        let path = format!("{}:{}", self.path("bin"), std::env::var("PATH").unwrap());
        let mut shell = Command::new("bash");
        shell.args(["-euc", line]).current_dir(self.0.path()).env("PATH", path);
        let ended = shell.output().unwrap();
        let said = String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned();
        assert!(ended.status.success(), "{said}{}", self.0.text("log"));
    }

    /// Exit codes of a job's tasks.
    fn codes(&self, job: u32) -> Vec<String> {
        self.0.text(&format!("jobs/{job}")).lines().map(str::to_owned).collect()
    }
}

fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "no '{from}' in: {text}");
    text.replace(from, to)
}

#[test]
fn shards_with_wrong_rows_are_merged_and_unfinished_ones_are_named() {
    let library = Folder::new();
    let minimal = std::fs::read_to_string(root().join("peers/minimal-cpp/minimal.cpp")).unwrap();
    let source = format!("{}/minimal.cpp", library.path());
    let dropping = replaced(&minimal, "drops = fault == \"drop\"", "drops = true");
    std::fs::write(&source, dropping).unwrap();
    let Some(plugin) = compiled(&library, &source, &["-pthread"]) else { return };
    let cluster = Cluster::new(&plugin);
    cluster.shell("bash -eu send.sh");
    let mut codes = cluster.codes(1);
    codes.sort_unstable();
    assert_eq!(codes, ["0", "4", "4"], "{}", cluster.0.text("log"));
    assert_eq!(cluster.codes(2), ["4"], "merge says it of the whole: {}", cluster.0.text("log"));
    let whole = std::fs::read_to_string(cluster.path("all/results.json")).unwrap();
    let whole: measurement::record::RunRecord = serde_json::from_str(&whole).unwrap();
    assert_eq!(row(&whole, "minimal-cpp").verdict, Verdict::Wrong);
    assert_eq!(row(&whole, "uniform-grid").verdict, Verdict::Ok);

    // two parts that were ended are both named, and sent again
    std::fs::remove_dir_all(cluster.path("all")).unwrap();
    for part in ["part-1", "part-3"] {
        let journal = cluster.path(&format!("{part}/run.jsonl"));
        let text = std::fs::read_to_string(&journal).unwrap();
        // the manifest alone
        std::fs::write(&journal, text.split_inclusive('\n').take(1).collect::<String>()).unwrap();
        let record = cluster.path(&format!("{part}/results.json"));
        let text = std::fs::read_to_string(&record).unwrap();
        let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
        json["complete"] = false.into();
        json["scenes"] = serde_json::json!([]);
        std::fs::write(&record, json.to_string()).unwrap();
    }
    std::fs::rename(cluster.path("part-2"), cluster.path("lost")).unwrap();
    cluster.write("log", "");
    cluster.shell("sbatch merge.sh");
    assert_eq!(cluster.codes(3), ["1"]);
    let said = cluster.0.text("log");
    for part in ["shard 1/3 has 0 of", "cannot read part-2", "shard 3/3 has 0 of"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    std::fs::rename(cluster.path("lost"), cluster.path("part-2")).unwrap();
    cluster.shell("sbatch --array=1 array.sh; sbatch --array=3 array.sh; sbatch merge.sh");
    assert_eq!(cluster.codes(6), ["4"], "{}", cluster.0.text("log"));

    // planted: a dependency that a wrong row does not meet
    let afterok = Cluster::new(&plugin);
    let sent = replaced(&afterok.0.text("send.sh"), "afterany", "afterok");
    afterok.write("send.sh", &sent);
    afterok.shell("bash -eu send.sh");
    assert!(afterok.codes(2).is_empty() && !Path::new(&afterok.path("all")).exists());
}
