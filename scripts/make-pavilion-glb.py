#!/usr/bin/env python3
"""Writes scenes/pavilion.glb: a round pavilion of instanced columns, a dome and a few objects.

All geometry is computed here; the result is released under CC0-1.0. Only the standard library is
used, and the output is the same bytes on every run:

    python3 scripts/make-pavilion-glb.py scenes/pavilion.glb
"""
import json
import math
import struct
import sys

COLUMNS = 10
RADIUS = 4.0
EYE, AT = (7.0, 3.0, 15.0), (0.0, 3.4, 0.0)

buffer = bytearray()
views, accessors = [], []


def accessor(values, kind, component, code, target):
    """Appends numbers to the buffer; returns the index of an accessor for them."""
    while len(buffer) % 4:
        buffer.append(0)
    start = len(buffer)
    width = 3 if kind == "VEC3" else 1
    for value in values:
        buffer.extend(struct.pack("<" + code * width, *(value if width == 3 else (value,))))
    views.append({"buffer": 0, "byteOffset": start, "byteLength": len(buffer) - start, "target": target})
    entry = {"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind}
    if kind == "VEC3":
        exact = [struct.unpack("<3f", struct.pack("<3f", *v)) for v in values]
        entry["min"] = [min(v[i] for v in exact) for i in range(3)]
        entry["max"] = [max(v[i] for v in exact) for i in range(3)]
    accessors.append(entry)
    return len(accessors) - 1


def primitive(positions, normals, indices, material):
    return {
        "attributes": {
            "POSITION": accessor(positions, "VEC3", 5126, "f", 34962),
            "NORMAL": accessor(normals, "VEC3", 5126, "f", 34962),
        },
        "indices": accessor(indices, "SCALAR", 5123, "H", 34963),
        "material": material,
    }


def turned(profile, segments, material):
    """A surface of revolution about y; `profile` lists (radius, height, normal r, normal y)."""
    positions, normals, indices = [], [], []
    for r, y, nr, ny in profile:
        for s in range(segments):
            a = 2 * math.pi * s / segments
            positions.append((r * math.cos(a), y, r * math.sin(a)))
            normals.append((nr * math.cos(a), ny, nr * math.sin(a)))
    for row in range(len(profile) - 1):
        for s in range(segments):
            t = (s + 1) % segments
            a, b = row * segments + s, row * segments + t
            c, d = a + segments, b + segments
            if profile[row][0] > 0:
                indices += [a, c, b]
            if profile[row + 1][0] > 0:
                indices += [b, c, d]
    return primitive(positions, normals, indices, material)


def arc(radius, centre_y, start, stop, steps, flip=1):
    """Profile points of a circular arc, angles in degrees from the equator."""
    points = []
    for i in range(steps + 1):
        a = math.radians(start + (stop - start) * i / steps)
        c = 0.0 if abs(math.cos(a)) < 1e-12 else math.cos(a)
        points.append((radius * c, centre_y + radius * math.sin(a), flip * c, flip * math.sin(a)))
    return points


def column():
    """Base, fluted-looking shaft of slight entasis, and capital."""
    profile = []
    for i in range(9):
        h = i / 8
        profile.append((0.30 - 0.05 * h + 0.02 * math.sin(math.pi * h), 0.2 + 2.6 * h, 1, 0.02))
    base = [(0.42, 0.0, 1, 0), (0.42, 0.12, 1, 0), (0.36, 0.2, 0.7, 0.7)]
    capital = [(0.34, 2.85, 0.7, -0.7), (0.42, 2.95, 1, 0), (0.42, 3.0, 1, 0)]
    return turned(base + profile + capital, 24, 1)


def disc(radius, y, segments, material):
    return turned([(radius, y, 0, 1), (0.0, y, 0, 1)], segments, material)


def torus(big, small, segments, sides, material):
    ring = []
    for i in range(sides + 1):
        a = 2 * math.pi * i / sides
        ring.append((big + small * math.cos(a), small * math.sin(a), math.cos(a), math.sin(a)))
    return turned(ring, segments, material)


meshes = [
    {"name": "floor", "primitives": [disc(6.0, 0.0, 48, 0), turned([(6.0, -0.3, 1, 0), (6.0, 0.0, 1, 0)], 48, 0)]},
    {"name": "column", "primitives": [column()]},
    {"name": "dome", "primitives": [
        turned(arc(4.6, 3.2, 0, 90, 12), 48, 2),
        turned(arc(4.4, 3.2, 0, 90, 12, -1), 48, 2),
        turned([(4.6, 3.0, 1, 0), (4.6, 3.2, 1, 0)], 48, 2),
        turned([(3.6, 3.0, 0, -1), (4.6, 3.0, 0, -1)], 48, 2),
    ]},
    {"name": "sphere", "primitives": [turned(arc(0.7, 0.0, -90, 90, 16), 32, 3)]},
    {"name": "ring", "primitives": [torus(1.0, 0.12, 40, 12, 4)]},
]

nodes = [
    {"name": "pavilion", "children": []},
    {"name": "floor", "mesh": 0},
    {"name": "dome", "mesh": 2},
    {"name": "sphere", "mesh": 3, "translation": [0, 1.2, 0]},
    {"name": "ring", "mesh": 4, "translation": [0, 1.2, 0], "rotation": [math.sin(math.radians(20)), 0, 0, math.cos(math.radians(20))]},
    {"name": "small ring", "mesh": 4, "translation": [0, 1.2, 0], "scale": [0.85, 0.85, 0.85],
     "rotation": [0, 0, math.sin(math.radians(-25)), math.cos(math.radians(-25))]},
    {"name": "camera", "camera": 0, "translation": list(EYE)},
    {"name": "sun", "translation": [9, 12, 8], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    {"name": "lamp", "translation": [0, 3.2, 0], "extensions": {"KHR_lights_punctual": {"light": 1}}},
]
# The camera's rotation: yaw about y, then pitch about x.
dx, dy, dz = (at - eye for at, eye in zip(AT, EYE))
yaw, pitch = math.atan2(-dx, -dz), math.atan2(dy, math.hypot(dx, dz))
sy, cy, sp, cp = math.sin(yaw / 2), math.cos(yaw / 2), math.sin(pitch / 2), math.cos(pitch / 2)
nodes[6]["rotation"] = [cy * sp, sy * cp, -sy * sp, cy * cp]
nodes[0]["children"] = [1, 2, 3, 4, 5]
for i in range(COLUMNS):
    a = 2 * math.pi * (i + 0.5) / COLUMNS
    nodes.append({"name": f"column {i}", "mesh": 1, "translation": [RADIUS * math.cos(a), 0, RADIUS * math.sin(a)]})
    nodes[0]["children"].append(len(nodes) - 1)


def material(name, color, metallic, roughness):
    factors = {"baseColorFactor": color + [1], "metallicFactor": metallic, "roughnessFactor": roughness}
    return {"name": name, "pbrMetallicRoughness": factors}


document = {
    "asset": {"version": "2.0", "generator": "scripts/make-pavilion-glb.py", "copyright": "CC0-1.0"},
    "extensionsUsed": ["KHR_lights_punctual"],
    "extensions": {"KHR_lights_punctual": {"lights": [
        {"type": "point", "name": "sun", "color": [1, 0.95, 0.85], "intensity": 1000},
        {"type": "point", "name": "lamp", "color": [0.6, 0.7, 1], "intensity": 500},
    ]}},
    "scene": 0,
    "scenes": [{"name": "pavilion", "nodes": [0, 6, 7, 8]}],
    "nodes": nodes,
    "cameras": [{"type": "perspective", "perspective": {"yfov": math.radians(42), "aspectRatio": 1, "znear": 0.1}}],
    "materials": [
        material("stone", [0.55, 0.52, 0.47], 0, 1),
        material("marble", [0.85, 0.83, 0.8], 0, 0.6),
        material("plaster", [0.75, 0.68, 0.58], 0, 1),
        material("steel", [0.9, 0.9, 0.92], 1, 0.1),
        material("brass", [0.8, 0.6, 0.25], 1, 0.4),
    ],
    "meshes": meshes,
    "accessors": accessors,
    "bufferViews": views,
    "buffers": [{"byteLength": len(buffer)}],
}

# Nine digits are more than an f32 holds, and hide the last bits of the mathematics library.
rounded = json.loads(json.dumps(document), parse_float=lambda t: round(float(t), 9))
text = json.dumps(rounded, separators=(",", ":")).encode()
text += b" " * (-len(text) % 4)
while len(buffer) % 4:
    buffer.append(0)
out = struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(buffer))
out += struct.pack("<I4s", len(text), b"JSON") + text
out += struct.pack("<I4s", len(buffer), b"BIN\0") + bytes(buffer)
with open(sys.argv[1] if len(sys.argv) > 1 else "scenes/pavilion.glb", "wb") as file:
    file.write(out)
