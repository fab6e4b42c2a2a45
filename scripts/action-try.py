#!/usr/bin/env python3
"""Runs the workflow of docs/ci.md as a host would, in a fresh repository of a small library.

The library is the plugin of peers/minimal-cpp. Its change is, one after the other: nothing, a slow-down, a wrong
answer; the action compiles rtbench or takes a binary of a release. What stands for GitHub here is the least that the
workflow needs: steps, inputs, expressions that are names, the files of GITHUB_OUTPUT and the like, and a `gh` that
keeps comments in a folder. Fails where an exit code, the summary or the comments are not what they should be.

usage: [RTBENCH=target/release/rtbench] scripts/action-try.py    (needs git, make, a C++ compiler, PyYAML)
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent
RTBENCH = Path(os.environ.get("RTBENCH", ROOT / "target/release/rtbench")).resolve()
ACTION = "rtbench/rtbench@"
# seconds, not minutes; the host's compiler is not what is tried
SMALLER = {"hare:40 --quick -s mine": "tetra:4 --quick --rounds 3 -s mine", "rounds": "--rounds 9"}
FAKE_GH = r"""#!/bin/sh
# gh api of comments: a file each
method=GET
for argument; do
    case $argument in
    body=@*) body=${argument#body=@} ;;
    PATCH | POST) method=$argument ;;
    esac
done
[ -z "$NO_COMMENTS" ] || { echo "HTTP 403: Resource not accessible by integration" >&2; exit 1; }
echo "$method" >> "$COMMENTS/calls"
case $method in
GET) ls "$COMMENTS" | grep -x '[0-9]*' || true ;;
PATCH) cp "$body" "$COMMENTS/1" ;;
POST) cp "$body" "$COMMENTS/1" ;;
esac
"""
# takes the binary that there is for what it would compile
FAKE_CARGO = r"""#!/bin/sh
while [ "$1" != --root ]; do shift; done
mkdir -p "$2/bin" && cp "$RTBENCH" "$2/bin/rtbench"
"""
MAKEFILE = """mine.so: mine.cpp
\t$(CXX) -std=c++17 -O2 -fPIC -shared -I. -o $@ mine.cpp
"""


def fail(message):
    sys.exit(f"action-try: {message}")


def documented_workflow():
    """The workflow of docs/ci.md."""
    blocks = re.findall(r"```yaml\n(.*?)```", (ROOT / "docs/ci.md").read_text(), re.S)
    parsed = [yaml.safe_load(block) for block in blocks]
    whole = next((b for b in parsed if isinstance(b, dict) and b.get("name") == "speed"), None)
    if not whole:
        fail("docs/ci.md has no workflow `speed`")
    return whole


class Host:
    """What stands for GitHub: a folder, a repository in it, variables."""

    def __init__(self, folder):
        self.folder = folder
        self.origin = folder / "origin"
        self.bin = folder / "bin"
        self.bin.mkdir()
        for name, text in [("gh", FAKE_GH), ("cargo", FAKE_CARGO)]:
            (self.bin / name).write_text(text)
            (self.bin / name).chmod(0o755)
        self.comments = folder / "comments"
        self.comments.mkdir()
        self.github = {
            "base_ref": "main",
            "event_name": "pull_request",
            "token": "none",
            "action_repository": "rtbench/rtbench",
        }
        self.server = folder / "server"
        self.matrix = None

    def git(self, *arguments):
        who = ["-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "init.defaultBranch=main"]
        subprocess.run(["git", *who, "-C", self.origin, *arguments], check=True, stdout=subprocess.DEVNULL)

    def library(self):
        self.origin.mkdir()
        self.git("init", "-q")
        source = (ROOT / "peers/minimal-cpp/minimal.cpp").read_text()
        files = {"mine.cpp": source.replace('"minimal-cpp"', '"mine"'), "Makefile": MAKEFILE}
        files["rtbench.h"] = (ROOT / "crates/plugins/include/rtbench.h").read_text()
        for name, text in files.items():
            (self.origin / name).write_text(text)
        self.git("add", ".")
        self.git("commit", "-qm", "a library")
        self.git("checkout", "-qb", "change")

    def change(self, file, old, new):
        """The branch `change` is the library with one text replaced."""
        self.git("reset", "-q", "--hard", "main")
        text = (self.origin / file).read_text()
        if old not in text:
            fail(f"{file} has no `{old}`")
        (self.origin / file).write_text(text.replace(old, new))
        self.git("commit", "-qam", "a change", "--allow-empty")

    def expanded(self, text, scopes):
        def value(match):
            if match[1].strip() == "toJSON(matrix)":
                return json.dumps(self.matrix, indent=2)
            scope, _, name = match[1].strip().partition(".")
            found = scopes[scope]
            for part in name.split(".")[:-1]:
                found = found[part]
            return str(found.get(name.split(".")[-1], ""))

        return re.sub(r"\$\{\{(.*?)\}\}", value, str(text))

    def run(self, job, permitted=True):
        """All steps of a job: its exit code and its summary."""
        work = Path(tempfile.mkdtemp(dir=self.folder))
        temp = Path(tempfile.mkdtemp(dir=self.folder))
        summary = temp / "summary.md"
        env = {
            "GITHUB_ACTIONS": "true",
            "GITHUB_REF": "refs/pull/7/merge",
            "GITHUB_REPOSITORY": "me/mine",
            "GITHUB_SERVER_URL": self.server.as_uri(),
            "GITHUB_WORKFLOW": "speed",
            "GITHUB_JOB": "speed",
            "GITHUB_STEP_SUMMARY": str(summary),
            "RUNNER_TEMP": str(temp),
            "RTBENCH": str(RTBENCH),
            "COMMENTS": str(self.comments),
            "NO_COMMENTS": "" if permitted else "1",
            "HOME": os.environ.get("HOME", "/"),
        }
        path = [str(self.bin), *os.environ["PATH"].split(":")]
        log = []

        def shell(script, more, cwd):
            files = {name: temp / name for name in ("GITHUB_OUTPUT", "GITHUB_PATH")}
            for file in files.values():
                file.write_text("")
            all_of_it = {**env, "PATH": ":".join(path), **{k: str(v) for k, v in files.items()}, **more}
            command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", script]
            ended = subprocess.run(command, cwd=cwd, env=all_of_it, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            log.append(ended.stdout)
            path[:0] = files["GITHUB_PATH"].read_text().split()
            outputs = dict(line.split("=", 1) for line in files["GITHUB_OUTPUT"].read_text().splitlines())
            return ended.returncode, outputs

        def action(given):
            described = yaml.safe_load((ROOT / "action.yml").read_text())
            unknown = set(given) - set(described["inputs"])
            if unknown:
                fail(f"action.yml has no inputs {unknown}")
            scopes = {"github": self.github, "steps": {}}
            inputs = {k: self.expanded(v.get("default", ""), scopes) for k, v in described["inputs"].items()}
            inputs |= {k: self.expanded(v, scopes) for k, v in given.items()}
            scopes["inputs"] = inputs
            for step in described["runs"]["steps"]:
                condition = step.get("if", "")
                if condition not in ("", "inputs.comment == 'true' && github.event_name == 'pull_request'"):
                    fail(f"a condition that is not known here: {condition}")
                if condition and inputs["comment"] != "true":
                    continue
                more = {k: self.expanded(v, scopes) for k, v in step.get("env", {}).items()}
                code, outputs = shell(step["run"], {**more, "GITHUB_ACTION_PATH": str(ROOT)}, work)
                if "id" in step:
                    scopes["steps"][step["id"]] = {"outputs": outputs}
                if code:
                    return code
            return 0

        code = 0
        for step in job["steps"]:
            uses, given = step.get("uses", ""), step.get("with", {})
            if uses.startswith("actions/checkout@"):
                branch = self.expanded(given.get("ref", "change"), {"github": self.github})
                clone = ["git", "clone", "-qb", branch, self.origin, work / given["path"]]
                subprocess.run(clone, check=True)
            elif uses.startswith(ACTION):
                code = action(given)
            elif "run" in step:
                code, _ = shell(step["run"], {}, work)
            else:
                fail(f"a step that is not known here: {step}")
            if code:
                break
        return code, summary.read_text() if summary.exists() else "", "\n".join(log)


def expect(what, ended, code, *said):
    found, summary, log = ended
    missing = [text for text in said if text not in summary + log]
    if found != code or missing:
        print(log, summary, sep="\n", file=sys.stderr)
        fail(f"{what}: exit code {found}, expected {code}; not said: {missing}")
    print(f"action-try: {what}: exit code {code}" + "".join(f", `{text}`" for text in said))


def main():
    if not RTBENCH.exists():
        fail("there is no rtbench: cargo build --release, or RTBENCH=FILE")
    workflow = documented_workflow()
    job = workflow["jobs"]["speed"]
    # of YAML's rules, `on` is true
    if workflow[True] != "pull_request" or workflow["permissions"] != {"contents": "read", "pull-requests": "write"}:
        fail("the workflow is not of pull requests, or asks for other permissions")
    own = job["steps"][-1]["with"]
    if own["run"] not in SMALLER:
        fail(f"another run in docs/ci.md: {own['run']}")
    own["run"] = SMALLER[own["run"]]
    own["check"] = SMALLER["rounds"]
    with tempfile.TemporaryDirectory() as folder:
        host = Host(Path(folder))
        host.library()
        host.change("mine.cpp", "most triangles of a leaf", "largest leaf")
        expect("a change of a comment", host.run(job), 0, "rtbench check: ")
        calls = (host.comments / "calls").read_text().split()
        host.change("mine.cpp", '"4", RTBENCH_INTEGER, 1, 64', '"64", RTBENCH_INTEGER, 1, 64')
        expect("a slow-down", host.run(job), 3, "# rtbench check: regression", "::error")
        calls = (host.comments / "calls").read_text().split()
        if calls != ["GET", "POST", "GET", "PATCH"] or "regression" not in (host.comments / "1").read_text():
            fail(f"comments: {calls}, expected one that is written anew")
        expect("a slow-down, no permission to comment", host.run(job, permitted=False), 3, "::warning::no comment")
        host.matrix = {"compiler": "gcc", "os": "ubuntu-24.04"}
        host.run(job)
        markers = {text.splitlines()[0] for text in [(host.comments / "1").read_text()]}
        if markers != {"<!-- rtbench speed speed compiler:gcc,os:ubuntu-24.04 -->"}:
            fail(f"the marker of a job of a matrix: {markers}")
        host.matrix = None
        host.change("mine.cpp", 'drops = fault == "drop"', "drops = true")
        expect("a wrong answer", host.run(job), 4, "drops a hit")
        # a release in the place of the compiler
        release = host.server / "rtbench/rtbench/releases/download/v0.0.0"
        system = {"Linux": "unknown-linux-gnu", "Darwin": "apple-darwin"}[os.uname().sysname]
        package = [ROOT / "scripts/package.sh", f"{os.uname().machine}-{system}", "default", "tried", release]
        subprocess.run(package, env={**os.environ, "BINARY": str(RTBENCH)}, check=True)
        own |= {"version": "v0.0.0", "target": "tried"}
        host.change("mine.cpp", "most triangles of a leaf", "largest leaf")
        expect("a binary of a release", host.run(job), 0, "rtbench-tried.tar.gz: OK")
        with open(release / "rtbench-tried.tar.gz", "ab") as archive:
            archive.write(b"more")
        expect("a binary that is another", host.run(job), 1, "rtbench-tried.tar.gz: FAILED")


if __name__ == "__main__":
    main()
