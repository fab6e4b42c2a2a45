#!/usr/bin/env python3
"""Searches rules behind the figures that Havran and Sixta (1999) printed, by their whole numbers.

usage: search-figures.py grids|hierarchy|planes SCENES REFERENCE.csv

SCENES is a folder with lattice.nff.gz and the like, as SPD prints them; REFERENCE.csv is
results/published/havran1999_grids.csv.

grids: settings of HUG that print one grid alone (N_IN = 1). Every combination of choices (what spheres and what other
primitives grow by on insertion, on which sides; what the root's box grows by; how thin boxes are treated) is scored by
the sum of |ours - published| over N_EV and N_OIV. Cells an axis are those of s (n / volume)^(1/3), truncated, plus 1,
for the first n that gives N_V. The best for the scenes of the first half, in alphabetical order, is scored on the others.

hierarchy: nodes, and nodes with objects as children, that inserting boxes one by one (Goldsmith and Salmon 1987) gives
over all primitives in file order and in one random order: f = 1.0, where tetra and lattice have orphans alone.

planes: tetra in HUG's grid of 16 x 16 x 16, whose cell planes are faces of its cubes. On each axis planes up to one are
reached by the cubes below, those from another on by the cubes above, or the other way about; the same on every axis.
"""

import csv
import gzip
import itertools
import math
import random
import sys
from pathlib import Path


def boxes(path):
    """Kind and box of every primitive of an NFF file."""
    words = gzip.open(path, "rt", encoding="ascii").read().split("\n")
    found, at = [], 0
    while at < len(words):
        line = words[at].split()
        at += 1
        if not line:
            continue
        if line[0] in ("p", "pp"):
            count = int(line[1])
            points = [[float(w) for w in words[at + k].split()[:3]] for k in range(count)]
            at += count
            lo = [min(p[k] for p in points) for k in range(3)]
            hi = [max(p[k] for p in points) for k in range(3)]
        elif line[0] == "s":
            x = [float(w) for w in line[1:5]]
            lo, hi = [c - x[3] for c in x[:3]], [c + x[3] for c in x[:3]]
        elif line[0] == "c":
            x = [float(w) for w in line[1:]]
            while len(x) < 8:
                x += [float(w) for w in words[at].split()]
                at += 1
            axis = [x[4 + k] - x[k] for k in range(3)]
            length = math.sqrt(sum(a * a for a in axis))
            reach = [math.sqrt(max(0.0, 1.0 - (a / length) ** 2)) for a in axis]
            lo = [min(x[k] - reach[k] * x[3], x[4 + k] - reach[k] * x[7]) for k in range(3)]
            hi = [max(x[k] + reach[k] * x[3], x[4 + k] + reach[k] * x[7]) for k in range(3)]
        else:
            continue
        found.append((line[0][0], lo, hi))
    return found


def resolution(lo, hi, cells):
    """Cells an axis for the first number of primitives that gives so many cells."""
    size = [h - l for l, h in zip(lo, hi)]
    for n in range(1, cells + 1):
        scale = (n / math.prod(size)) ** (1 / 3)
        axes = [int(s * scale) + 1 for s in size]
        if math.prod(axes) >= cells:
            return axes if math.prod(axes) == cells else None
    return None


def counted(found, cells, choice):
    """N_EV and N_OIV of one grid, or None where no number of primitives gives its cells."""
    sphere, other, sides, root, thin = choice
    lo = [min(b[1][k] for b in found) - root for k in range(3)]
    hi = [max(b[2][k] for b in found) + root for k in range(3)]
    axes = resolution(lo, hi, cells)
    if axes is None:
        return None
    step = [(h - l) / n for l, h, n in zip(lo, hi, axes)]
    full, references = set(), 0
    for kind, low, high in found:
        pad = sphere if kind == "s" else other
        ranges = []
        for k in range(3):
            a, b = low[k], high[k]
            if b - a < thin:
                a, b = (a + b - thin) / 2, (a + b + thin) / 2
            a, b = a - pad * (sides != "high"), b + pad * (sides != "low")
            first, last = (min(max(math.floor((x - lo[k]) / step[k]), 0), axes[k] - 1) for x in (a, b))
            ranges.append(range(first, last + 1))
        references += math.prod(len(r) for r in ranges)
        full.update(itertools.product(*ranges))
    return math.prod(axes) - len(full), references


def search_grids(scenes, reference):
    """Prints the best choices for half of the scenes, and what they do in the other half."""
    figures = {}
    with open(reference, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["structure"] == "hug":
                figures.setdefault((row["scene"], row["params"]), {})[row["counter"]] = row["value"]
    wanted = {}
    for (scene, _), row in sorted(figures.items()):
        if row["N_IN"] == "1" and (scenes / f"{scene}.nff.gz").exists():
            wanted.setdefault(scene, set()).add(tuple(int(row[c]) for c in ("N_V", "N_EV", "N_OIV")))
    found = {scene: boxes(scenes / f"{scene}.nff.gz") for scene in wanted}
    choices = itertools.product(
        (0.0, 0.01), (0.0, 0.001, 0.01), ("both", "low", "high"), (0.0, 0.001, 0.01), (0.0, 0.01)
    )
    scored = []
    for choice in choices:
        score, shown = {}, []
        for scene, targets in wanted.items():
            for cells, empty, references in sorted(targets):
                ours = counted(found[scene], cells, choice)
                off = 10**6 if ours is None else abs(ours[0] - empty) + abs(ours[1] - references)
                score[scene] = score.get(scene, 0) + off
                shown.append(f"{scene} {cells}: {ours} for {(empty, references)}")
        scored.append((score, choice, shown))
    fitted = sorted(wanted)[: len(wanted) // 2]
    scored.sort(key=lambda entry: sum(entry[0][scene] for scene in fitted))
    for score, choice, shown in scored[:5]:
        print("sphere {}, other {}, sides {}, root {}, thin {}".format(*choice))
        print(f"  fitted on {', '.join(fitted)}: off by {sum(score[s] for s in fitted)};", end=" ")
        print(f"held out: {', '.join(f'{s} {off}' for s, off in score.items() if s not in fitted)}")
        for line in shown:
            print(f"  {line}")


def area(lo, hi):
    """Surface of a box."""
    x, y, z = (h - l for l, h in zip(lo, hi))
    return 2 * (x * y + y * z + z * x)


def joined(a, b):
    """The box around two."""
    return [min(x, y) for x, y in zip(a[0], b[0])], [max(x, y) for x, y in zip(a[1], b[1])]


def inserted(items, by_growth, last, ties):
    """Nodes, and those with objects, after insertion one by one; a node is [box, parent, children or None]."""
    nodes = [[items[0], None, None]]
    root = 0
    for item in items[1:]:
        at, inherited, best = root, 0.0, (math.inf, None, False)
        while nodes[at][2] is not None:
            box, _, children = nodes[at]
            grown = area(*joined(box, item))
            growth = (grown - area(*box)) * len(children)
            if inherited + growth + grown < best[0]:
                best = (inherited + growth + grown, at, False)
            inherited += growth
            next_at, least = None, math.inf
            for child in children:
                both = area(*joined(nodes[child][0], item))
                value = both - area(*nodes[child][0]) if by_growth else both
                if value < least or last and value == least:
                    next_at, least = child, value
                if nodes[child][2] is None:
                    cost = inherited + both
                    if cost < best[0] or ties and cost == best[0]:
                        best = (cost, child, True)
            at = next_at
        if best[1] is None:
            best = (0.0, root, True)
        _, target, is_pair = best
        nodes.append([item, target, None])
        leaf = len(nodes) - 1
        if is_pair:
            parent = nodes[target][1]
            nodes.append([joined(nodes[target][0], item), parent, [target, leaf]])
            pair = len(nodes) - 1
            nodes[target][1] = nodes[leaf][1] = pair
            if parent is None:
                root = pair
            else:
                nodes[parent][2] = [pair if c == target else c for c in nodes[parent][2]]
            target = pair
        else:
            nodes[target][2].append(leaf)
        while target is not None:
            nodes[target][0] = joined(nodes[target][0], item)
            target = nodes[target][1]
    inner = [n for n in nodes if n[2] is not None]
    return len(inner), sum(any(nodes[c][2] is None for c in n[2]) for n in inner)


def search_hierarchy(scenes, _):
    """Prints the nodes of every variant beside the published ones."""
    for scene, published in (("tetra", (3087, 2629)), ("lattice", (6123, 5342))):
        items = [(lo, hi) for _, lo, hi in boxes(scenes / f"{scene}.nff.gz")]
        shuffled = random.Random(1).sample(items, len(items))
        for order, chosen in (("file", items), ("random", shuffled)):
            for variant in itertools.product((False, True), repeat=3):
                setting = dict(zip(("by_growth", "last", "ties"), variant))
                print(scene, order, setting, inserted(chosen, *variant), published)


def search_planes(scenes, _):
    """Prints the patterns that come nearest to the published 3017 empty cells with 16396 references."""
    corners = {tuple(round((x + 1) * 16) for x in lo) for _, lo, _ in boxes(scenes / "tetra.nff.gz")}
    scored = []
    for inner, first, second in itertools.product((False, True), range(16), range(1, 17)):
        ranges = []
        for cube in range(32):
            plane, below = (cube + 1) // 2, cube % 2
            low_part, high_part = plane <= first, plane >= second
            reaches = (high_part if inner else low_part) if below else (low_part if inner else high_part)
            others = (plane,) if below else (plane - 1,)
            ranges.append({cube // 2, *(c for c in others if reaches and 0 <= c < 16)})
        full, references = set(), 0
        for corner in corners:
            cells = list(itertools.product(*(ranges[c] for c in corner)))
            references += 4 * len(cells)
            full.update(cells)
        off = abs(4096 - len(full) - 3017) + abs(references - 16396)
        scored.append((off, inner, first, second, 4096 - len(full), references))
    for off, inner, first, second, empty, references in sorted(scored)[:5]:
        print(f"off by {off}: {empty} empty, {references} references; up to {first}, from {second}, swapped {inner}")


def main():
    """Runs one search."""
    searches = {"grids": search_grids, "hierarchy": search_hierarchy, "planes": search_planes}
    if len(sys.argv) != 4 or sys.argv[1] not in searches:
        sys.exit(__doc__)
    searches[sys.argv[1]](Path(sys.argv[2]), sys.argv[3])


if __name__ == "__main__":
    main()
