"""The smallest characters that show something: a skinned tube along a column of joints, as GLB."""

import json
import math
import struct

HUMAN = ["hips", "spine", "chest", "neck", "head"]


def encode(document, binary=b""):
    """A GLB of a glTF document (a dict, or text as it is) and its buffer."""
    text = document if isinstance(document, str) else json.dumps(document)
    chunk = text.encode() + b" " * (-len(text.encode()) % 4)
    binary += b"\0" * (-len(binary) % 4)
    length = 12 + 8 + len(chunk) + (8 + len(binary) if binary else 0)
    out = struct.pack("<4sII", b"glTF", 2, length) + struct.pack("<I4s", len(chunk), b"JSON") + chunk
    if binary:
        out += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return out


def tube(names=HUMAN, change=None, vertex=None, rings=9, sides=8, unit=1.0):
    """A tube 1.6 m tall around a straight chain of joints `names`, weights shared by neighbours.

    `vertex(i, position, joints, weights)` may return other values for vertex i; `change(document)`
    may alter the glTF before it is written; `unit` is how many of the file's units a metre has.
    """
    spacing = 1.6 * unit / len(names)
    positions, joints, weights, triangles = [], [], [], []
    for ring in range(rings):
        height = 1.6 * unit * ring / (rings - 1)
        along = min(height / spacing, len(names) - 1)
        low = min(int(along), len(names) - 2) if len(names) > 1 else 0
        share = along - low if len(names) > 1 else 0.0
        for side in range(sides):
            angle = 2 * math.pi * side / sides
            radius = 0.15 * unit
            values = ([radius * math.cos(angle), height, radius * math.sin(angle)],
                      [low, min(low + 1, len(names) - 1), 0, 0], [1 - share, share, 0.0, 0.0])
            if vertex:
                values = vertex(len(positions), *values) or values
            for target, value in zip((positions, joints, weights), values):
                target.append(value)
    for ring in range(rings - 1):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            triangles += [a, a + sides, b, b, a + sides, b + sides]

    binary, views, accessors = b"", [], []

    def add(data, component, kind, count, **more):
        nonlocal binary
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "type": kind,
                          "count": count, **more})
        binary += data + b"\0" * (-len(data) % 4)

    flat = [c for p in positions for c in p]
    add(struct.pack(f"<{len(flat)}f", *flat), 5126, "VEC3", len(positions),
        min=[min(p[k] for p in positions) for k in range(3)],
        max=[max(p[k] for p in positions) for k in range(3)])
    add(bytes(j for four in joints for j in four), 5121, "VEC4", len(joints))
    add(struct.pack(f"<{4 * len(weights)}f", *(w for four in weights for w in four)), 5126, "VEC4", len(weights))
    add(struct.pack(f"<{len(triangles)}H", *triangles), 5123, "SCALAR", len(triangles))
    inverse = [v for k in range(len(names)) for v in (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -spacing * k, 0, 1)]
    add(struct.pack(f"<{len(inverse)}f", *inverse), 5126, "MAT4", len(names))

    nodes = [{"name": name, "translation": [0, spacing if k else 0, 0],
              **({"children": [k + 1]} if k + 1 < len(names) else {})} for k, name in enumerate(names)]
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, len(names)]}],
        "nodes": [*nodes, {"name": "body", "mesh": 0, "skin": 0}],
        "skins": [{"joints": list(range(len(names))), "inverseBindMatrices": 4}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2}, "indices": 3}]}],
        "buffers": [{"byteLength": len(binary)}], "bufferViews": views, "accessors": accessors,
    }
    if change:
        change(document)
    return encode(document, binary)


def with_strays(data, joint="hand_L", heights=(0.54, 0.57, 0.6)):
    """A GLB of `backbend body` with one vertex of the belly's middle at each of these shares of its height bound
    to `joint` alone."""
    length, = struct.unpack_from("<I", data, 12)
    document, out = json.loads(data[20:20 + length]), bytearray(data)
    attributes = document["meshes"][0]["primitives"][0]["attributes"]

    def start(name):
        accessor = document["accessors"][attributes[name]]
        view = document["bufferViews"][accessor["bufferView"]]
        return 28 + length + view.get("byteOffset", 0) + accessor.get("byteOffset", 0), accessor

    (at, points), (joints, kind), (weights, _) = start("POSITION"), start("JOINTS_0"), start("WEIGHTS_0")
    assert kind["componentType"] == 5121, kind
    position = [struct.unpack_from("<3f", data, at + 12 * i) for i in range(points["count"])]
    tall = max(y for _, y, _ in position)
    bound = [document["nodes"][node]["name"] for node in document["skins"][0]["joints"]].index(joint)
    for share in heights:
        # The front is toward +Z; what is far from the middle plane or from this height counts against it.
        vertex = max(range(len(position)), key=lambda i: position[i][2] - 10 * abs(position[i][0]) -
                     10 * abs(position[i][1] - share * tall))
        out[joints + 4 * vertex:joints + 4 * vertex + 4] = bytes([bound, 0, 0, 0])
        struct.pack_into("<4f", out, weights + 16 * vertex, 1, 0, 0, 0)
    return bytes(out)
