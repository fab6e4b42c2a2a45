#!/usr/bin/env python3
"""Types into bash, zsh and fish and presses Tab, with the completions that `rtbench completions` prints.

Each line below is begun, completed and must then hold what is expected. A shell that is not installed is named, and
none at all is a failure. A completion that is not there must not be found.

usage: [RTBENCH=target/release/rtbench] scripts/completions-try.py [bash|zsh|fish]...
"""
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RTBENCH = Path(os.environ.get("RTBENCH", ROOT / "target/release/rtbench")).resolve()
# what is typed, and what stands there behind Tab
CASES = [
    ("rtbench repro", "rtbench reproduce"),
    ("rtbench run teap", "rtbench run teapot"),
    ("rtbench run gears-t", "rtbench run gears-tess"),
    ("rtbench run teapot --struct", "rtbench run teapot --structures"),
    ("rtbench run teapot --structures two-", "rtbench run teapot --structures two-level-grid"),
    ("rtbench run teapot -s octree:subd", "rtbench run teapot -s octree:subdivision="),
    ("rtbench run teapot -s kd-tree:kernel=sc", "rtbench run teapot -s kd-tree:kernel=scalar"),
    ("rtbench sweep teapot -s uniform-grid -p mailbox-", "rtbench sweep teapot -s uniform-grid -p mailbox-slots"),
    ("rtbench scenes valid", "rtbench scenes validate"),
    ("rtbench list stru", "rtbench list structures"),
    ("rtbench run teapot --sort mem", "rtbench run teapot --sort memory"),
    ("rtbench completions fi", "rtbench completions fish"),
]
# several names in one argument
LISTS = [("rtbench run teapot -s kd-tree,oct", "rtbench run teapot -s kd-tree,octree")]
NOTHING = "rtbench run xyzz"
START = {
    "bash": ["bash", "--norc", "--noprofile", "-i"],
    "zsh": ["zsh", "-f", "-i"],
    "fish": ["fish", "--no-config", "-i"],
}
# a prompt that is not found in what is typed, and no colours
SETUP = {
    "bash": "PS1='REA''DY> '; bind 'set enable-bracketed-paste off'; bind 'set bell-style none'; . {file}",
    "zsh": "PS1='REA''DY> '; unsetopt zle_bracketed_paste prompt_sp; autoload -U compinit; compinit -u -d {folder}/dump; . {file}",
}


class Terminal:
    """A shell behind a terminal."""

    def __init__(self, shell, folder):
        env = {"PATH": f"{folder}:{os.environ['PATH']}", "TERM": "dumb", "HOME": str(folder), "COLUMNS": "200"}
        pid, self.file = pty.fork()
        if pid == 0:
            os.chdir(folder)
            os.execvpe(shell, START[shell], env)

    def read(self, until=None, quiet=0.4, at_most=10.0):
        text, begin = "", time.time()
        while time.time() - begin < at_most:
            if not select.select([self.file], [], [], quiet)[0]:
                if until is None or until in text:
                    break
                continue
            text += os.read(self.file, 65536).decode(errors="replace")
        return re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]|\x07|\r", "", text)

    def send(self, text):
        os.write(self.file, text.encode())


def in_terminal(shell, folder, file):
    """A function from what is typed to what stands there after Tab."""
    terminal = Terminal(shell, folder)
    terminal.read()
    terminal.send(SETUP[shell].format(file=file, folder=folder) + "\n")
    terminal.read("READY> ")

    def completed(typed):
        terminal.send(typed)
        terminal.read()
        terminal.send("\t")
        shown = terminal.read()
        terminal.send("\x15")  # the line is given up
        terminal.read()
        # a terminal without a cursor shows only what was added
        return typed + shown if typed not in shown else shown[shown.rindex(typed):]

    return completed


def in_fish(folder, file):
    """fish says itself what it would complete: candidates for the last word, with their descriptions."""

    def completed(typed):
        env = {**os.environ, "HOME": str(folder), "PATH": f"{folder}:{os.environ['PATH']}"}
        asked = f"source {file}; complete --do-complete '{typed}'"
        ended = subprocess.run(["fish", "--no-config", "-c", asked], env=env, text=True, capture_output=True, cwd=folder)
        candidates = [line.split("\t")[0] for line in ended.stdout.splitlines()]
        begun = typed.rsplit(" ", 1)[0]
        return f"{begun} {os.path.commonprefix(candidates)}" if candidates else typed + ended.stderr

    return completed


def main():
    wanted = sys.argv[1:] or list(START)
    tried, failed = 0, 0
    for shell in wanted:
        if not shutil.which(shell):
            print(f"completions-try: {shell} is not installed")
            continue
        tried += 1
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "rtbench").symlink_to(RTBENCH)
            file = Path(folder) / f"rtbench.{shell}"
            file.write_text(subprocess.run([RTBENCH, "completions", shell], text=True, check=True, capture_output=True).stdout)
            completed = in_fish(folder, file) if shell == "fish" else in_terminal(shell, folder, file)
            for typed, expected in CASES + LISTS:
                shown = completed(typed)
                if not shown.startswith(expected):
                    failed += 1
                    print(f"completions-try: {shell}: {typed!r} becomes {shown!r}, expected {expected!r}")
            shown = completed(NOTHING)
            if shown.strip() != NOTHING:
                failed += 1
                print(f"completions-try: {shell}: {NOTHING!r} becomes {shown!r}: there is no such scene")
            print(f"completions-try: {shell}: {len(CASES + LISTS) + 1} lines")
    if failed or not tried:
        sys.exit(f"completions-try: {failed} wrong, {tried} shells tried")


if __name__ == "__main__":
    main()
