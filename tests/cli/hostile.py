"""Characters that nobody means well with, and characters that are odd but legal: what
bad_input_test.py holds the program's manners and memory against, and tests/bench/hostile_files.py
its time."""

import json
import os
import struct

import glb


def changed(change, **more):
    return glb.tube(change=change, **more)


def _set(path, value):
    """A change of a glTF document: `nodes/4/children` -> value."""
    def change(document):
        *way, last = path.split("/")
        at = document
        for step in way:
            at = at[int(step)] if isinstance(at, list) else at[step]
        at[int(last) if isinstance(at, list) else last] = value
    return change


def _vertex(number, position=None, joints=None, weights=None):
    def vertex(i, p, j, w):
        return (position or p, joints or j, weights or w) if i == number else None
    return vertex


def _add_skinless_joints(document):
    document["skins"][0]["joints"] = []


def _no_binds(document):
    del document["skins"][0]["inverseBindMatrices"]


def _in_joint_space(i, position, joints, weights):
    """Without inverse binds, the joints of the column carry a vertex from here to where it was."""
    spacing = 1.6 / len(glb.HUMAN)
    x, y, z = position
    return [x, y - sum(w * spacing * j for j, w in zip(joints, weights)), z], joints, weights


def _unstored(document):
    document["accessors"][0].pop("bufferView")
    document["accessors"][0]["count"] = 1 << 29


def _sparse(document):
    document["accessors"][0]["sparse"] = {
        "count": 1 << 30, "indices": {"bufferView": 3, "componentType": 5125}, "values": {"bufferView": 0}}


def _buffer_claims(document):
    document["buffers"][0]["byteLength"] = 1 << 40


def _nodes(count):
    def change(document):
        document["nodes"] += [{"name": f"n{k}"} for k in range(count)]
        document["scenes"][0]["nodes"] += list(range(6, 6 + count))
    return change


def _deep_chain(document):
    first = len(document["nodes"])
    document["nodes"] += [{"children": [first + k + 1]} for k in range(200_000)] + [{}]
    document["scenes"][0]["nodes"].append(first)


def _shared_primitives(document):
    document["meshes"][0]["primitives"] *= 200_000


def _morph_crowd(document):
    document["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}] * 100_000


def _script(document):
    for node in document["nodes"][:5]:
        node["name"] = "<script>alert(1)</script>" + node["name"]


def _data_uri(document):
    document["buffers"].append({"byteLength": 1 << 31, "uri": "data:application/octet-stream;base64,AAAA"})


def header_claims(length):
    return struct.pack("<4sII", b"glTF", 2, length) + struct.pack("<I4s", length - 20, b"JSON")


def nested(depth):
    return glb.encode('{"asset":{"version":"2.0"},"extras":' + "[" * depth + "]" * depth + "}")


def long_name(size):
    return changed(_set("nodes/0/name", "x" * size))


BVH = """HIERARCHY
ROOT hips
{
 OFFSET 0 1 0
 CHANNELS %s
 JOINT head
 {
  OFFSET 0 1 0
  CHANNELS 3 Zrotation Xrotation Yrotation
  End Site
  {
   OFFSET 0 0.2 0
  }
 }
}
MOTION
Frames: %s
Frame Time: 0.04
%s
"""
LAUGHS = ('<?xml version="1.0"?><!DOCTYPE l [<!ENTITY a0 "ha">' +
          "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 12)) +
          ']><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>&a11;</asset></COLLADA>')

WHOLE = glb.tube()

# File name and content of what must be refused: exit 3, one line that names the file.
REFUSED = {
    "nothing": ("hero.glb", b""),
    "noise": ("hero.glb", bytes(range(256)) * 64),
    "truncated in the header": ("hero.glb", WHOLE[:9]),
    "truncated in the document": ("hero.glb", WHOLE[:200]),
    "truncated in the buffer": ("hero.glb", WHOLE[:-40]),
    "a chunk that claims 4 GB": ("hero.glb", header_claims(0xFFFFFFF0)),
    "a position that is no number": ("hero.glb", glb.tube(vertex=_vertex(20, position=[0, float("nan"), 0]))),
    "a weight without end": ("hero.glb", glb.tube(vertex=_vertex(20, weights=[float("inf"), 0, 0, 0]))),
    "a joint out of range": ("hero.glb", glb.tube(vertex=_vertex(20, joints=[200, 0, 0, 0]))),
    "a skin without joints": ("hero.glb", changed(_add_skinless_joints)),
    "a node that is its own ancestor": ("hero.glb", changed(_set("nodes/4/children", [0]))),
    "a scale of nothing but infinity": ("hero.glb", changed(_set("nodes/2/scale", [1e308, 1e308, 1e308]))),
    "a count of two thousand million": ("hero.glb", changed(_set("accessors/0/count", (1 << 31) - 1))),
    "zeros without end": ("hero.glb", changed(_unstored)),
    "sparse values without end": ("hero.glb", changed(_sparse)),
    "a buffer that claims a terabyte": ("hero.glb", changed(_buffer_claims)),
    "data that claims 2 GB": ("hero.glb", changed(_data_uri)),
    "a way out of the folder": ("hero.glb", changed(_set("buffers/0/uri", "../../../../etc/passwd"))),
    "an encoded way out of the folder": ("hero.glb", changed(_set("buffers/0/uri", "%2e%2e/%2e%2e/etc/passwd"))),
    "an absolute path": ("hero.glb", changed(_set("buffers/0/uri", "/dev/zero"))),
    "a chain 200 000 deep": ("hero.glb", changed(_deep_chain)),
    "nesting 1 000 000 deep": ("hero.glb", nested(1_000_000)),
    "a document that is no UTF-8": ("hero.gltf", b'{"asset":{"version":"2.0"},"nodes":[{"name":"\xff\xfe\xfa"}'),
    "200 000 uses of one primitive": ("hero.glb", changed(_shared_primitives)),
    "300 000 nodes": ("hero.glb", changed(_nodes(300_000))),
    "an FBX of noise": ("hero.fbx", b"Kaydara FBX Binary  \x00\x1a\x00" + bytes(range(256)) * 32),
    "an FBX that nests": ("hero.fbx", b"; FBX 7.4.0 project file\n" + b"a: {" * 100_000),
    "a BVH of 2 000 000 000 frames": ("hero.bvh", (BVH % ("3 Zrotation Xrotation Yrotation", "2000000000", "0 0 0 0 0 0")).encode()),
    "a BVH of 4 000 000 000 channels": ("hero.bvh", (BVH % ("4000000000 Zrotation", "1", "0")).encode()),
    "a Collada that laughs": ("hero.dae", LAUGHS.encode()),
    "a Collada that nests": ("hero.dae", b"<a>" * 200_000),
}

# What is odd and legal: read, with these words among the warnings ("" for nothing to say).
ACCEPTED = {
    "no inverse binds": (changed(_no_binds, vertex=_in_joint_space), ""),
    "a vertex without weight": (glb.tube(vertex=_vertex(20, weights=[0.0, 0.0, 0.0, 0.0])), "weight"),
    "weights that sum to 1.2": (glb.tube(vertex=_vertex(20, weights=[0.6, 0.6, 0.0, 0.0], joints=[0, 1, 0, 0])),
                                "sum to 1"),
    "script in names": (changed(_script), ""),
    "a name of a million letters": (long_name(1_000_000), ""),
    "20 000 idle nodes": (changed(_nodes(20_000)), ""),
    "an extension in use that nobody knows": (changed(_set("extensionsUsed", ["ACME_secret"])), ""),
}


def write(folder, name, content):
    path = os.path.join(folder, name)
    with open(path, "wb") as file:
        file.write(content)
    return path


def measured(command, environment, folder):
    """Runs a command; its exit code, what it said on stdout and stderr, the most memory that it or a
    process of its own held (bytes), and the processor time of all of them (seconds)."""
    with open(os.path.join(folder, "out"), "w+b") as out, open(os.path.join(folder, "err"), "w+b") as err:
        pid = os.posix_spawn(command[0], command, environment, file_actions=[
            (os.POSIX_SPAWN_OPEN, 0, "/dev/null", os.O_RDONLY, 0),
            (os.POSIX_SPAWN_DUP2, out.fileno(), 1), (os.POSIX_SPAWN_DUP2, err.fileno(), 2)])
        _, status, usage = os.wait4(pid, 0)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode("utf-8", "surrogateescape"))
    return os.waitstatus_to_exitcode(status), *texts, usage.ru_maxrss * 1024, usage.ru_utime + usage.ru_stime
