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


def decode(data):
    """The glTF document and the buffer of a GLB that encode() made."""
    length, = struct.unpack_from("<I", data, 12)
    return json.loads(data[20:20 + length]), bytearray(data[28 + length:])


def with_sparse_positions(data):
    """The same GLB with positions that stand in a sparse accessor alone, without a base."""
    document, binary = decode(data)
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]]
    count = accessor["count"]
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 2 * count})
    binary += struct.pack(f"<{count}H", *range(count)) + b"\0" * (-2 * count % 4)
    accessor["sparse"] = {
        "count": count, "indices": {"bufferView": len(document["bufferViews"]) - 1, "componentType": 5123},
        "values": {"bufferView": accessor.pop("bufferView")}}
    document["buffers"][0]["byteLength"] = len(binary)
    return encode(document, bytes(binary))


def with_bind_matrix(data, joint, change):
    """The same GLB; `change(matrix)` gives the inverse bind matrix of a joint anew (16 numbers by columns)."""
    document, binary = decode(data)
    accessor = document["accessors"][document["skins"][0]["inverseBindMatrices"]]
    start = document["bufferViews"][accessor["bufferView"]]["byteOffset"] + 64 * joint
    struct.pack_into("<16f", binary, start, *change(struct.unpack_from("<16f", binary, start)))
    return encode(document, bytes(binary))


def of_three_meshes(number=True):
    """A figure of three meshes, each on a skin of its own: the body, the arms and the legs, whose joints hang from
    other roots than the spine's, with numbers in their names as web exporters add them."""
    nodes, skins, meshes, views, accessors, binary = [], [], [], [], [], bytearray()

    def add(data, component, kind, count, **more):
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "type": kind, "count": count, **more})
        binary.extend(data + b"\0" * (-len(data) % 4))
        return len(accessors) - 1

    def node(name, parent, at):
        label = f"b_{name}_{len(nodes):02d}" if number else name
        nodes.append({"name": label, "at": at})
        start = nodes[parent]["at"] if parent is not None else (0, 0, 0)
        nodes[-1]["translation"] = [a - b for a, b in zip(at, start)]
        if parent is not None:
            nodes[parent].setdefault("children", []).append(len(nodes) - 1)
        return len(nodes) - 1

    def mesh(name, chains):
        """One mesh of a tube about each chain of joints, all on one skin."""
        joints = [joint for chain in chains for joint in chain]
        positions, bound, weights, triangles = [], [], [], []
        for chain in chains:
            points = [nodes[joint]["at"] for joint in chain]
            tip = [2 * b - a for a, b in zip(points[-2], points[-1])]
            first, rings = len(positions), 4 * len(chain) + 1
            along = [b - a for a, b in zip(points[0], points[-1])]
            upright = abs(along[1]) > abs(along[0])
            for ring in range(rings):
                low = min(ring // 4, len(chain) - 1)
                share = ring / 4 - low
                a, b = points[low], (points + [tip])[low + 1]
                middle = [x + share * (y - x) for x, y in zip(a, b)]
                for side in range(6):
                    angle = math.pi * side / 3
                    u, v = 0.06 * math.cos(angle), 0.06 * math.sin(angle)
                    offset = (u, 0, v) if upright else (0, u, v)
                    positions.append([m + o for m, o in zip(middle, offset)])
                    bound.append([joints.index(chain[low]), joints.index(chain[min(low + 1, len(chain) - 1)]), 0, 0])
                    weights.append([1 - 0.5 * share, 0.5 * share, 0.0, 0.0])
            for ring in range(rings - 1):
                for side in range(6):
                    a, b = first + 6 * ring + side, first + 6 * ring + (side + 1) % 6
                    triangles += [a, a + 6, b, b, a + 6, b + 6]
        flat = [c for p in positions for c in p]
        inverse = [v for j in joints for v in
                   (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *(-c for c in nodes[j]["at"]), 1)]
        attributes = {
            "POSITION": add(struct.pack(f"<{len(flat)}f", *flat), 5126, "VEC3", len(positions),
                            min=[min(p[k] for p in positions) for k in range(3)],
                            max=[max(p[k] for p in positions) for k in range(3)]),
            "JOINTS_0": add(bytes(j for four in bound for j in four), 5121, "VEC4", len(bound)),
            "WEIGHTS_0": add(struct.pack(f"<{4 * len(weights)}f", *(w for four in weights for w in four)), 5126,
                             "VEC4", len(weights))}
        index = add(struct.pack(f"<{len(triangles)}H", *triangles), 5123, "SCALAR", len(triangles))
        binds = add(struct.pack(f"<{len(inverse)}f", *inverse), 5126, "MAT4", len(joints))
        skins.append({"joints": joints, "inverseBindMatrices": binds})
        meshes.append({"name": name, "primitives": [{"attributes": attributes, "indices": index}]})

    spine, parent = [], None
    for name, height in (("Hips", 0.9), ("Spine1", 1.05), ("Spine2", 1.2), ("Chest", 1.35), ("Neck", 1.5), ("Head", 1.6)):
        parent = node(name, parent, (0, height, 0))
        spine.append(parent)
    arms_root, legs_root, limbs = node("rigArms", None, (0, 0, 0)), node("rigLegs", None, (0, 0, 0)), {}
    roots = [spine[0], arms_root, legs_root]
    for side, x in (("Right", -1), ("Left", 1)):
        upper = node(side + "UpperArm", arms_root, (0.1 * x, 1.4, 0))
        fore = node(side + "ForeArm", upper, (0.35 * x, 1.4, 0))
        limbs["arm" + side] = [upper, fore, node(side + "Hand", fore, (0.6 * x, 1.4, 0))]
        thigh = node(side + "Leg", legs_root, (0.1 * x, 0.88, 0))
        shin = node(side + "Shin", thigh, (0.1 * x, 0.45, 0))
        limbs["leg" + side] = [thigh, shin, node(side + "Foot", shin, (0.1 * x, 0.08, 0))]
    mesh("body", [spine])
    mesh("arms", [limbs["armLeft"], limbs["armRight"]])
    mesh("legs", [limbs["legLeft"], limbs["legRight"]])
    for each in nodes:
        each.pop("at")
    for k in range(3):
        nodes.append({"name": f"mesh_{k}", "mesh": k, "skin": k})
        roots.append(len(nodes) - 1)
    return encode({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}], "nodes": nodes,
                   "skins": skins, "meshes": meshes, "buffers": [{"byteLength": len(binary)}],
                   "bufferViews": views, "accessors": accessors}, bytes(binary))


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
