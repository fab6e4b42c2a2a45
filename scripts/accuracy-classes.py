#!/usr/bin/env python3
"""Two records of `rtbench accuracy` side by side: which variants cost what in both, and which changed.

usage: accuracy-classes.py [--at-least PERCENT] OLD/accuracy.json NEW/accuracy.json

A variant's class is what it takes beyond the cheapest of its axis, scene and subject, as in summary.md, by the whole
interval: free (less than 5% more), costs (more than that), inconclusive (5% is in it). Lists those whose class changed,
with both figures; prints how many stayed, also those of axes as a whole and on the front, and by the classes that
records had until November 2026 (free where the interval contains 1 and ends below 1.1; else under 10% or more, by the
median). Fails where less than PERCENT of the variants stayed in their class.
"""

import argparse
import json
import math
import sys


NOTICED = 1.05


def price(ratio):
    """The class of a ratio with its interval."""
    if ratio["median"] is None:
        return "no time"
    if ratio["high"] < NOTICED:
        return "free"
    return "inconclusive" if ratio["low"] <= NOTICED else "costs"


def price_of_before(ratio):
    """The class that it had until November 2026."""
    if ratio["median"] is None:
        return "no time"
    if ratio["low"] <= 1.0:
        return "free" if ratio["high"] < 1.1 else "inconclusive"
    return "under 10%" if ratio["median"] < 1.1 else "more"


def rows(path):
    """Variants by axis, scene, subject and name."""
    with open(path, encoding="utf-8") as file:
        run = json.load(file)
    return {
        (axis["axis"], scene["scene"], scene.get("subject", ""), row["variant"]): row
        for axis in run["axes"]
        for scene in axis["scenes"]
        for row in scene["rows"]
    }


def figure(row):
    ratio = row["ratio"]
    return f"{ratio['median']:.2f} [{ratio['low']:.2f}, {ratio['high']:.2f}]"


def percent(part, of):
    return f"{part} of {of} ({100 * part / of:.0f}%)"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--at-least", type=float, default=0.0, metavar="PERCENT")
    args = parser.parse_args()
    old, new = rows(args.old), rows(args.new)
    both = [key for key in new if key in old]
    if not both:
        sys.exit("accuracy-classes: no variant is in both")
    print("| axis | scene | variant | before | now | class before | class now |")
    print("| --- | --- | --- | ---: | ---: | --- | --- |")
    same = as_before = standing = held = told = 0
    apart = []
    for key in both:
        a, b = old[key], new[key]
        before, now = price(a["ratio"]), price(b["ratio"])
        same += before == now
        as_before += price_of_before(a["ratio"]) == price_of_before(b["ratio"])
        standing += a["standing"] == b["standing"]
        held += b["ratio"]["low"] <= a["ratio"]["median"] <= b["ratio"]["high"]
        # a class that is inconclusive contradicts none
        contradicts = "inconclusive" not in (before, now) and before != now
        told += not contradicts
        apart.append(abs(math.log(b["ratio"]["median"] / a["ratio"]["median"])))
        if before != now:
            axis, scene, subject, variant = key
            place = f"{scene}, {subject}" if subject else scene
            print(f"| {axis} | {place} | {variant} | {figure(a)} | {figure(b)} | {before} | {now} |")
    apart.sort()
    at = lambda share: 100 * (math.exp(apart[min(len(apart) - 1, int(share * len(apart)))]) - 1)
    print()
    print(f"same class: {percent(same, len(both))}; none that contradicts: {percent(told, len(both))}")
    print(f"same class of those until November 2026: {percent(as_before, len(both))}")
    print(f"same place (front, ~front, -): {percent(standing, len(both))}")
    print(f"medians before within the interval now: {percent(held, len(both))}")
    print(f"ratios apart: {at(0.5):.1f}% in the middle, {at(0.9):.1f}% nine of ten, {at(1.0):.1f}% most")
    print(f"only before: {len(old) - len(both)}, only now: {len(new) - len(both)}")
    sys.exit(0 if 100 * same >= args.at_least * len(both) else 1)


main()
