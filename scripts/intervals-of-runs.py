#!/usr/bin/env python3
"""Do the intervals of runs of one table hold what the other runs found? See process-trials.sh.

usage: intervals-of-runs.py RESULTS.JSON...
"""

import json
import sys
from itertools import permutations

LEAST_HELD, MOST_APART = 0.80, 0.01


def ratios(path):
    """Ratios to the reference by scene and row: median, low, high, levels."""
    with open(path, encoding="utf-8") as file:
        run = json.load(file)
    found = {}
    for scene in run["scenes"]:
        for row in scene["rows"]:
            ratio = row["ratio"]
            if ratio and not row["is_reference"]:
                name = f"{scene['name']}: {row['structure']} {row['settings']}".strip()
                found[name] = (ratio["median"], ratio["low"], ratio["high"], row.get("levels"))
    return found, run.get("floor")


def main(paths):
    runs = [ratios(path) for path in paths]
    if len(runs) < 2:
        sys.exit("intervals-of-runs: two runs at least are needed")
    names = sorted(set.intersection(*(set(run) for run, _ in runs)))
    print("row, medians of the runs, held, apart, runs that say two levels")
    all_held = all_apart = pairs = 0
    for name in names:
        own = [run[name] for run, _ in runs]
        held = sum(b[1] <= a[0] <= b[2] for a, b in permutations(own, 2))
        apart = sum(a[1] > b[2] or b[1] > a[2] for a, b in permutations(own, 2))
        count = len(own) * (len(own) - 1)
        levels = sum(bool(one[3]) for one in own)
        medians = " ".join(f"{one[0]:.2f}" for one in own)
        print(f"{name}, {medians}, {held} of {count}, {apart // 2}, {levels}")
        all_held, all_apart, pairs = all_held + held, all_apart + apart, pairs + count
    floors = [floor["floor"] for _, floor in runs if floor]
    if floors:
        print("A/A floors:", " ".join(f"{100 * floor:.1f}%" for floor in floors))
    held, apart = all_held / pairs, all_apart / pairs
    print(f"{len(names)} rows, {len(runs)} runs: {100 * held:.1f}% of the other runs' medians lie in a "
          f"run's interval, {100 * apart:.2f}% of pairs are disjoint")
    sys.exit(0 if held >= LEAST_HELD and apart <= MOST_APART else 1)


main(sys.argv[1:])
