#!/usr/bin/env python3
"""Writes a wavy sheet of N x N x 2 triangles as OBJ or GLB: big-scene.py obj|glb N FILE.

N = 2237 gives 10,008,338 triangles over 5,008,644 shared vertices. For measuring what loaders take:
    /usr/bin/time -v rtbench scenes info FILE
"""
import array
import json
import math
import struct
import sys


def height(i, j):
    return math.sin(i * 0.01) * math.cos(j * 0.013) * 20


def write_obj(n, out):
    out.write(f"# a sheet of {2 * n * n} triangles\n".encode())
    for j in range(n + 1):
        row = "".join(f"v {i} {height(i, j):.6f} {j}\n" for i in range(n + 1))
        out.write(row.encode())
    for j in range(n):
        a = j * (n + 1) + 1
        b = a + n + 1
        row = "".join(
            f"f {a + i} {b + i} {a + i + 1}\nf {a + i + 1} {b + i} {b + i + 1}\n" for i in range(n)
        )
        out.write(row.encode())


def write_glb(n, out):
    vertices, indices = (n + 1) * (n + 1), 6 * n * n
    sizes = [12 * vertices, 4 * indices]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
             "min": [0, -20, 0], "max": [n, 20, n]},
            {"bufferView": 1, "componentType": 5125, "count": indices, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": sizes[0]},
            {"buffer": 0, "byteOffset": sizes[0], "byteLength": sizes[1]},
        ],
        "buffers": [{"byteLength": sum(sizes)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    out.write(b"glTF" + struct.pack("<II", 2, 12 + 8 + len(text) + 8 + sum(sizes)))
    out.write(struct.pack("<I", len(text)) + b"JSON" + text)
    out.write(struct.pack("<I", sum(sizes)) + b"BIN\0")
    for j in range(n + 1):
        row = array.array("f", (x for i in range(n + 1) for x in (i, height(i, j), j)))
        out.write(row.tobytes())
    for j in range(n):
        a, b = j * (n + 1), (j + 1) * (n + 1)
        row = array.array(
            "I",
            (x for i in range(n) for x in (a + i, b + i, a + i + 1, a + i + 1, b + i, b + i + 1)),
        )
        out.write(row.tobytes())


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ("obj", "glb"):
        sys.exit(__doc__)
    with open(sys.argv[3], "wb") as out:
        {"obj": write_obj, "glb": write_glb}[sys.argv[1]](int(sys.argv[2]), out)


main()
