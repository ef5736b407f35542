"""Finds out whether a character's spine rig can be trusted: the backbend program as a module.

    import backbend
    report = backbend.judge(backbend.load("hero.glb"), "even")
    print(report.headline)

Angles in degrees, lengths in the file's unit, world space right-handed with +Y up. Arrays are
NumPy's. docs/python.md has the whole of it; __init__.pyi the shapes and types.
"""

from . import _core
from ._core import Character, Error, InputError, Rig, WriteError, __version__, load, set_threads

__all__ = [
    "Chain", "Character", "Error", "InputError", "Picture", "Poses", "PythonRig", "Record", "Report", "Rig",
    "Series", "SkinnedPoses", "WriteError", "compare", "judge", "load", "set_threads", "__version__",
]


class Record(dict):
    """Named values: `record.code` is `record["code"]`."""

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no '{name}' here; there are {', '.join(self) or 'none'}") from None

    def __dir__(self):
        return [*super().__dir__(), *self]


class Report(Record):
    """report.json as an object, with the names of its schema. `text` is report.json itself."""

    @staticmethod
    def _of(text):
        report = Report(_record_of(text))
        report.text = text
        return report


class Poses(Record):
    """Solved poses of a chain; N poses of J joints."""


class SkinnedPoses(Record):
    """Bodies in N poses."""


class Series(Record):
    """Metrics, a value per pose."""


class Picture(Record):
    """A picture's layers."""


class Chain:
    """What a rig is drawn on, where joints alone do not say it. See docs/rigs/ for what each takes."""

    def __init__(self, joints, *, left=(1.0, 0.0, 0.0), curve=None, path=None, up=(0.0, 1.0, 0.0),
                 frames=None, frame_names=()):
        self.joints, self.left, self.curve = joints, left, curve
        self.path, self.up = path, up
        self.frames, self.frame_names = frames, list(frame_names)


class PythonRig(_core._PythonRig):
    """A rig written in Python, judged like one that runs in its own program.

    Derive from it, call super().__init__() with the rig at rest, and define

        def pose(self, values): ...

    values: N x channels (degrees for rotations, the rig's unit for translations). Returns the
    joints' matrices to rig space, N x joints x 4 x 4 for column vectors; of a rig with points a
    pair of those and the points, N x points x 3. It must not remember earlier poses (BB044).

    channels: names, or (name, kind, rest) with kind rotation, translation or scalar. Those called
    extension, flexion, side and twist stand for these; map names a mapping file for others.
    joints, parents, rest (joints x 4 x 4): every joint of the character's spine by its name,
    parents before their children, -1 for none.
    """

    def __init__(self, channels, joints, parents, rest, *, points=None, triangles=None, up="Y",
                 metres_per_unit=1.0, name="", map=""):
        super().__init__()
        import json
        import weakref

        hello = {"schema": "backbend.rig/1", "program": "python", "up": up,
                 "metres_per_unit": metres_per_unit, "channels": [_channel(each) for each in channels],
                 "joints": _joints(list(joints), list(parents), rest)}
        count = 0
        if points is not None:
            flat = _numbers(points, "points", (None, 3))
            count = len(flat)
            hello["points"] = flat.ravel().tolist()
        if triangles is not None:
            hello["triangles"] = _numbers(triangles, "triangles", (None, 3)).astype(int).ravel().tolist()
        self._start(name or type(self).__name__, json.dumps(hello), str(map),
                    _answer_of(weakref.ref(self), len(hello["joints"]), count))

    def pose(self, values):
        """The joints' matrices for N x channels values; a class of yours defines it."""
        raise NotImplementedError(f"{type(self).__name__} must define pose(values)")


def judge(character, rig="even", *, mapping="chest", envelope="auto", sweeps="standard", folder=None,
          pictures=None):
    """Judges one character under one rig, as `backbend check` does, and returns the report.

    character: a Character, or a file. rig: as Rig() takes it, or a PythonRig. envelope: auto for
    that of the kind of body. sweeps: standard or stress. folder: where the report and its pictures
    are written; None: nowhere. pictures: whether poses are looked at in small pictures, too;
    None: where there is a folder.
    """
    pictures = folder is not None if pictures is None else bool(pictures)
    return Report._of(_core._judge(character, rig, mapping, envelope, sweeps, folder or "", pictures))


def compare(a, b, *, character=None, rig="even", mapping="chest", sweeps="stress", folder=None,
            pictures=None):
    """Compares two rigs, or two characters, pose by pose, as `backbend compare` does.

    a, b: the proposed rig and the one to compare it with, each as Rig() takes it (character: what
    they drive; None: the bundled human); or the earlier and the later Character (rig: what drives
    both). Otherwise as judge().
    """
    pictures = folder is not None if pictures is None else bool(pictures)
    last = (mapping, sweeps, folder or "", pictures)
    of_characters = [isinstance(side, Character) for side in (a, b)]
    if all(of_characters):
        return Report._of(_core._compare_characters(a, b, rig, *last))
    if any(of_characters):
        raise TypeError("one side is a character and the other a rig: two of one kind can be compared")
    return Report._of(_core._compare_rigs(a, b, character, *last))


def _record_of(text):
    import json
    return json.loads(text, object_hook=Record)


def _channel(channel):
    if isinstance(channel, str):
        return {"name": channel}
    return dict(zip(("name", "kind", "rest"), channel))


def _numbers(values, what, shape):
    import numpy
    array = numpy.asarray(values)
    if array.dtype.kind not in "fiub":
        raise TypeError(f"{what}: expected an array of real numbers, found one of {array.dtype}")
    expected = " x ".join("N" if length is None else str(length) for length in shape)
    if array.ndim != len(shape) or any(want not in (None, have) for want, have in zip(shape, array.shape)):
        found = " x ".join(map(str, array.shape)) or "a single number"
        raise ValueError(f"{what}: expected {expected}, found {found}")
    array = array.astype(float)
    if not numpy.isfinite(array).all():
        raise ValueError(f"{what}: holds a number that is not finite")
    return array


def _joints(names, parents, rest):
    # Column by column, as the protocol has them.
    matrices = _numbers(rest, "rest", (len(names), 4, 4)).transpose(0, 2, 1).reshape(len(names), 16)
    if len(parents) != len(names):
        raise ValueError(f"parents: expected one for each of {len(names)} joints, found {len(parents)}")
    return [{"name": name, "parent": int(parent), "rest": matrix.tolist()}
            for name, parent, matrix in zip(names, parents, matrices)]


def _answer_of(weak, joints, points):
    def answer(values, wants_points):
        rig = weak()
        if rig is None:
            raise ReferenceError("the PythonRig is gone; keep it as long as it is asked")
        said = rig.pose(values)
        matrices, moved = said if isinstance(said, tuple) else (said, None)
        matrices = _numbers(matrices, "what pose() returned", (len(values), joints, 4, 4))
        packed = matrices.transpose(0, 1, 3, 2).astype("<f8").tobytes()
        if not wants_points:
            return packed, b""
        if moved is None:
            raise ValueError("what pose() returned: expected a pair of matrices and points")
        moved = _numbers(moved, "the points that pose() returned", (len(values), points, 3))
        return packed, moved.astype("<f4").tobytes()
    return answer
