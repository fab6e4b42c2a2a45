#!/usr/bin/env python3
"""Makes folders of results as CI would keep them, from one: for a look at `rtbench history`.

    scripts/planted-history.py RESULTS OUT_DIR [RUNS]

RESULTS is a folder of `rtbench run -o`. Each of the RUNS (24) is a copy of its first two scenes with another
commit and day and 1% of noise in its ratios. From two thirds on, `kd-tree` is 12% slower at tracing and, from one
third on, builds of `uniform-grid` are 20% faster: the site must list both, at their commits, and no other change.
Every third run is of another machine, on which all ratios are a tenth higher.
"""
import hashlib, json, os, random, sys


def scaled(estimate, by):
    if estimate:
        for end in estimate:
            estimate[end] *= by


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    results, out = sys.argv[1:3]
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 24
    with open(os.path.join(results, "results.json"), encoding="utf-8") as file:
        text = file.read()
    noise = random.Random(1)
    for run in range(runs):
        record = json.loads(text)
        record["scenes"] = record["scenes"][:2]
        record["tool"]["git_revision"] = hashlib.sha1(str(run).encode()).hexdigest()
        record["started_unix_s"] += 86400 * (run - runs)
        other = run % 3 == 2
        if other:
            record["machine"]["cpu"] = "Another Processor"
        for row in (row for scene in record["scenes"] for row in scene["rows"]):
            row["samples"] = []
            slow = 1.12 if row["structure"] == "kd-tree" and run >= runs * 2 // 3 else 1.0
            fast = 1 / 1.2 if row["structure"] == "uniform-grid" and run >= runs // 3 else 1.0
            if row["is_reference"]:
                continue
            trace = [row["ratio"], *row.get("ratio_by_kind", {}).values()]
            for estimate, by in [(e, slow) for e in trace] + [(row["build_ratio"], fast)]:
                scaled(estimate, by * (1.1 if other else 1.0) * noise.gauss(1.0, 0.01))
        folder = os.path.join(out, f"run-{run:03}")
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, "results.json"), "w", encoding="utf-8") as file:
            json.dump(record, file)


main()
