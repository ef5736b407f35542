"""A Blender file asked for its poses as backbend asks it (docs/rig_protocol.md), with scripts disabled."""

import array
import json
import subprocess

from even_native import inverse, moved, times, transposed
from harness import SOURCE

SERVER = SOURCE / "scenes/bridges/backbend_blender.py"
# rx, ry, rz of a control (along, forward, left) are these channels of its bone.
BONE_CHANNELS = [f"even_{control}.{axis}" for control in ("lower", "middle", "top") for axis in ("ry", "rz", "rx")]
Y_UP = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]  # from Blender's axes


class BlenderRig:
    """`joints`: names of bones. poses() gives [(turn from rest, place)] of them, Y up, for values of
    BONE_CHANNELS in degrees."""

    def __init__(self, blender, file, joints, mapping):
        self.told = open(mapping.with_suffix(".told"), "wb+")
        mapping.write_text('{"mesh": false}')
        self.process = subprocess.Popen(
            [blender, file, "--background", "--factory-startup", "--disable-autoexec", "--python", SERVER, "--",
             "--serve", mapping], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.told)
        hello = self.read()
        while "schema" not in hello and "error" not in hello:
            hello = self.read()
        if "error" in hello:
            raise AssertionError(hello["error"])
        rest = {joint["name"]: joint["rest"] for joint in hello["joints"]}
        self.hello, self.joints, self.rest = hello, joints, [self.in_y_up(rest[name]) for name in joints]
        self.say({"select": {"channels": BONE_CHANNELS, "joints": joints}})
        self.read()

    def say(self, words, numbers=b""):
        self.process.stdin.write(json.dumps(words).encode() + b"\n" + numbers)
        self.process.stdin.flush()

    def read(self):
        """The next line of JSON; others are what Blender prints at its start."""
        while True:
            line = self.process.stdout.readline()
            if not line:
                self.told.seek(0)
                raise AssertionError("Blender ended: " + self.told.read().decode(errors="replace"))
            if line.startswith(b"{"):
                return json.loads(line)

    @staticmethod
    def in_y_up(columns):
        """(turn, place) of sixteen numbers, column by column."""
        turn = transposed([columns[k:k + 3] for k in (0, 4, 8)])
        return times(Y_UP, turn), moved(Y_UP, columns[12:15])

    def poses(self, poses):
        out = []
        for first in range(0, len(poses), 256):
            some = poses[first:first + 256]
            self.say({"ask": len(some)}, array.array("d", [v for pose in some for v in pose]).tobytes())
            answer = self.read()
            if "error" in answer:
                raise AssertionError(answer["error"])
            numbers = array.array("d")
            numbers.frombytes(self.process.stdout.read(8 * 16 * len(self.joints) * len(some)))
            for at in range(0, len(numbers), 16 * len(self.joints)):
                spine = []
                for k, (rest, _) in enumerate(self.rest):
                    turn, place = self.in_y_up(numbers[at + 16 * k:at + 16 * k + 16])
                    spine.append((times(turn, inverse(rest)), place))
                out.append(spine)
        return out

    def close(self):
        self.process.stdin.close()
        self.process.wait(60)
        self.process.stdout.close()
        self.told.close()
