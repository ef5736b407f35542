"""Serves a rig to backbend while it is judged: `backbend.rig/1`, described in docs/rig_protocol.md.

    backbend check hero.glb --rig command:"python3 my_rig.py"

my_rig.py calls serve() with what its rig is and a function that poses it. Needs nothing but Python 3:
Blender, Maya and Houdini all bring it. example_rig.py, beside this file, is an example.
"""

import array
import json
import os
import sys


def own_streams():
    """(input, output) for the protocol alone: what else the program prints goes to standard error."""
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return sys.stdin.buffer, output


def declared(name, kind, rest, is_control=True, ends=None):
    """A channel as a hello has it."""
    out = {"name": name, "kind": kind, "rest": rest}
    if not is_control:
        out["control"] = False
    if ends is not None:
        out["min"], out["max"] = ends
    return out


def serve(channels, joints, pose, program="", scene="", up="Y", metres_per_unit=1.0, pure=True, select=None,
          mesh=None, pose_with_points=None, streams=None):
    """Answers until backbend closes the stream.

    `channels`: [(name, kind, value at rest), ...]; kind is "rotation" (degrees), "translation" or "scalar".
    A fourth value False: no animator sets it. A fifth, (smallest, largest): what an animator can set.
    `joints`: [(name, index of the parent or -1, rest matrix), ...]; sixteen numbers, column by column.
    `pose(values)`: a value for every channel in, a matrix for every joint out.
    `mesh`, where the rig has a deformed one: (its points at rest, its triangles), flat lists of three numbers each.
    `pose_with_points(values)`, then: (a matrix for every joint, the points as a flat list).
    `select(channel_names, joint_names)`, where given: from then on pose() gets and gives only those.
    """
    source, sink = streams or own_streams()

    def say(words, *arrays):
        sink.write(json.dumps(words).encode() + b"\n")
        for numbers in arrays:
            if sys.byteorder == "big":
                numbers.byteswap()
            sink.write(numbers.tobytes())
        sink.flush()

    hello = {"schema": "backbend.rig/1", "program": program, "file": os.path.basename(scene), "up": up,
             "metres_per_unit": metres_per_unit, "pure": pure, "select": select is not None,
             "channels": [declared(*channel) for channel in channels],
             "joints": [{"name": name, "parent": parent, "rest": [float(v) for v in rest]}
                        for name, parent, rest in joints]}
    if mesh is not None:
        hello["points"], hello["triangles"] = [float(v) for v in mesh[0]], [int(v) for v in mesh[1]]
    say(hello)
    width = len(channels)
    for line in iter(source.readline, b""):
        request = json.loads(line)
        if "select" in request:
            wanted = request["select"]
            select(wanted["channels"], wanted["joints"])
            width = len(wanted["channels"])
            say({"selected": [width, len(wanted["joints"])]})
            continue
        count = request["ask"]
        values = array.array("d")
        values.frombytes(source.read(8 * width * count))
        if sys.byteorder == "big":
            values.byteswap()
        answer, points = array.array("d"), array.array("f")
        for k in range(count):
            here = values[k * width:(k + 1) * width]
            if request.get("points"):
                matrices, placed = pose_with_points(here)
                points.extend(placed)
            else:
                matrices = pose(here)
            for matrix in matrices:
                answer.extend(matrix)
        say({"answer": count}, answer, points)


def refuse(what, streams=None):
    """Ends with one line that backbend shows; exit code 3, as for every file that cannot be used."""
    _, sink = streams or own_streams()
    sink.write(json.dumps({"error": str(what)}).encode() + b"\n")
    sink.flush()
    sys.exit(3)
