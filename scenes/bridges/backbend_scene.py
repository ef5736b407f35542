"""What the servers for Maya and Houdini share: a scene of another program, served over `backbend.rig/1`.

Everything that thinks is here, in plain Python; backbend_maya.py and backbend_houdini.py only ask their program. A
`host` is what such a file brings:

    program, scene           for people
    up, metres_per_unit      of its space
    joints()                 [(name, index of the parent or -1, rest matrix), ...], parents first; sixteen numbers
    channels(wanted)         [(name, kind, is_control), ...]: those of its controls, and those that are wanted
    get(channel)             its value: degrees for rotations
    set(channel, value)
    matrices(names)          of those joints as they stand, sixteen numbers each, column by column
    mesh()                   (points, triangles), flat lists; None where it has none
    points()                 of the mesh as it stands
"""

import json
import math
import os

import backbend_rig


def targets_of(mapping):
    """(control, channel) of every target of a mapping, each once, in its order. ValueError names a wrong place."""
    channels = mapping.get("channels", {})
    if not isinstance(channels, dict):
        raise ValueError("channels: not an object")
    found = []
    for name, targets in channels.items():
        if not isinstance(targets, list):
            raise ValueError(f"channels/{name}: not a list of controls")
        for k, target in enumerate(targets):
            if not isinstance(target, dict) or not isinstance(target.get("channel"), str):
                raise ValueError(f"channels/{name}/{k}/channel: missing")
            if not isinstance(target.get("control", ""), str):
                raise ValueError(f"channels/{name}/{k}/control: not text")
            pair = (target.get("control", ""), target["channel"])
            if pair not in found:
                found.append(pair)
    return found


def channel_name(control, channel):
    return f"{control}.{channel}" if control else channel


def unique_names(paths, separator="|"):
    """A name for each path: its last part where no other has it, else the whole path."""
    last = [path.rpartition(separator)[2] for path in paths]
    return [name if last.count(name) == 1 else path for name, path in zip(last, paths)]


def nearest_above(path, place, separator="|"):
    """The index of the nearest path above `path` in `place`, {path: index}; -1 for none."""
    above = path.rpartition(separator)[0]
    while above and above not in place:
        above = above.rpartition(separator)[0]
    return place.get(above, -1)


def inverse(m):
    """Of an affine matrix, sixteen numbers column by column (or row by row: the form is kept)."""
    a, b, c = m[0:3], m[4:7], m[8:11]
    cross = lambda u, v: [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]  # noqa: E731
    rows = [cross(b, c), cross(c, a), cross(a, b)]
    volume = sum(x * y for x, y in zip(a, rows[0]))
    if not math.isfinite(volume) or volume == 0.0:
        raise ValueError("a matrix that cannot be inverted")
    rows = [[x / volume for x in row] for row in rows]
    move = [-sum(x * t for x, t in zip(row, m[12:15])) for row in rows]
    return [rows[0][0], rows[1][0], rows[2][0], 0.0, rows[0][1], rows[1][1], rows[2][1], 0.0,
            rows[0][2], rows[1][2], rows[2][2], 0.0, *move, 1.0]


def fans(faces):
    """Triangles of faces, each a list of vertices: a flat list."""
    return [vertex for face in faces for k in range(1, len(face) - 1) for vertex in (face[0], face[k], face[k + 1])]


class SceneServer:
    """A host as backbend_rig.serve() asks for it."""

    def __init__(self, host, mapping):
        self.host = host
        wanted = [channel_name(*pair) for pair in targets_of(mapping)]
        self.known = host.channels(wanted)
        names = [name for name, _, _ in self.known]
        for name in wanted:
            if name not in names:
                raise ValueError(f"no channel '{name}' that can be set")
        self.rest = {name: host.get(name) for name in names}
        self.declared = host.joints()
        if not self.declared:
            raise ValueError("the scene has no joints")
        self.channels, self.joints = names, [name for name, _, _ in self.declared]
        self.mesh = host.mesh()
        self.now = dict(self.rest)

    def declared_channels(self):
        return [(name, kind, self.rest[name], is_control) for name, kind, is_control in self.known]

    def select(self, channels, joints):
        self.channels, self.joints = channels, joints

    def pose(self, values):
        for name, value in zip(self.channels, values):
            if value != self.now[name]:  # a value that is set again makes the scene evaluate all below it again
                self.host.set(name, value)
                self.now[name] = value
        return self.host.matrices(self.joints)

    def pose_with_points(self, values):
        matrices, points = self.pose(values), self.host.points()
        if len(points) != len(self.mesh[0]):
            raise ValueError(f"the mesh has {len(points) // 3} points in this pose and {len(self.mesh[0]) // 3} at rest")
        return matrices, points


def serve(open_host, files, streams):
    """Speaks the protocol until backbend closes the stream. `files`: the scene and, where there is one, its mapping.
    `open_host(scene, mapping)` opens the scene and gives its host. What is wrong is said over the protocol: these
    programs' exit codes say nothing about their scripts."""
    try:
        mapping = {}
        if len(files) > 1:
            with open(files[1], encoding="utf-8") as file:
                mapping = json.load(file)
        host = open_host(files[0], mapping)
        server = SceneServer(host, mapping)
    except Exception as error:  # of any kind: a program raises its own
        backbend_rig.refuse(f"{os.path.basename(files[0])}: {error}".splitlines()[0], streams)
    backbend_rig.serve(server.declared_channels(), server.declared, server.pose, program=host.program, scene=host.scene,
                       up=host.up, metres_per_unit=host.metres_per_unit, select=server.select, mesh=server.mesh,
                       pose_with_points=server.pose_with_points, streams=streams)
