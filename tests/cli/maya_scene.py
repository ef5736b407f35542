"""A scene that answers as maya.cmds: it keeps nodes and connections, and evaluates the four matrix nodes, transforms
and joints as Maya's node documentation describes them. Angles in degrees (Maya converts between angles and plain
numbers by unitConversion nodes). Maya was not at hand: this is what its pages say, and no more."""

import math
import types

IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
ORDERS = ("xyz", "yzx", "zxy", "xzy", "yxz", "zyx")
DEFAULTS = {
    "multiplyDivide": {"input1": (0.0,) * 3, "input2": (1.0,) * 3, "operation": 1},
    "composeMatrix": {"inputTranslate": (0.0,) * 3, "inputRotate": (0.0,) * 3, "inputRotateOrder": 0},
    "multMatrix": {},
    "decomposeMatrix": {"inputMatrix": IDENTITY, "inputRotateOrder": 0},
    "network": {},
    "transform": {"translate": (0.0,) * 3, "rotate": (0.0,) * 3, "rotateOrder": 0, "rotateAxis": (0.0,) * 3,
                  "offsetParentMatrix": IDENTITY, "overrideEnabled": False, "overrideColor": 0},
}
DEFAULTS["joint"] = {**DEFAULTS["transform"], "jointOrient": (0.0,) * 3}
COMPUTED = {"output", "outputMatrix", "matrixSum", "outputTranslate", "outputRotate", "matrix", "worldMatrix[0]",
            "parentInverseMatrix[0]"}


def product(a, b):
    return tuple(a[i] * b[j] + a[i + 1] * b[4 + j] + a[i + 2] * b[8 + j] + a[i + 3] * b[12 + j]
                 for i in (0, 4, 8, 12) for j in range(4))


def inverse(m):
    """Of a rigid motion."""
    back = [-(m[12] * m[4 * j] + m[13] * m[4 * j + 1] + m[14] * m[4 * j + 2]) for j in range(3)]
    return (m[0], m[4], m[8], 0.0, m[1], m[5], m[9], 0.0, m[2], m[6], m[10], 0.0, *back, 1.0)


def about(axis, degrees):
    """Row vectors: v' = v M."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    m = list(IDENTITY)
    a, b = [(1, 2), (2, 0), (0, 1)][axis]
    m[4 * a + a], m[4 * a + b], m[4 * b + a], m[4 * b + b] = c, s, -s, c
    return tuple(m)


def rotation(angles, order=0):
    out = IDENTITY
    for axis in ORDERS[order]:
        out = product(out, about("xyz".index(axis), angles["xyz".index(axis)]))
    return out


def angles_of(m, order=0):
    """The Euler angles whose rotation() is m's turn."""
    first, second, third = ("xyz".index(axis) for axis in ORDERS[order])
    sign = 1.0 if (second - first) % 3 == 1 else -1.0
    # rotation() is first, then second, then third: m[first][third] = -sign sin(second).
    at = lambda i, j: m[4 * i + j]  # noqa: E731
    out = [0.0, 0.0, 0.0]
    level = math.hypot(at(first, first), at(first, second))
    out[second] = math.degrees(math.atan2(-sign * at(first, third), level))
    if level > 1e-9:
        out[first] = math.degrees(math.atan2(sign * at(second, third), at(third, third)))
        out[third] = math.degrees(math.atan2(sign * at(first, second), at(first, first)))
    else:  # a gimbal lock: all of it on the first
        out[first] = math.degrees(math.atan2(-sign * at(third, second), at(second, second)))
    return tuple(out)


def moved_to(m, place):
    return m[:12] + tuple(place) + (1.0,)


class MayaScene:
    def __init__(self, up="y"):
        self.up, self.kind, self.parent_of, self.value, self.source, self.locked = up, {}, {}, {}, {}, set()
        self.limits, self.known = {}, {}

    def as_module(self):
        """{'maya': ..., 'maya.cmds': ...} for sys.modules."""
        cmds, maya = types.ModuleType("maya.cmds"), types.ModuleType("maya")
        for name in dir(self):
            if not name.startswith("_"):
                setattr(cmds, name, getattr(self, name))
        maya.cmds = cmds
        return {"maya": maya, "maya.cmds": cmds}

    # --- What tests build and read ---

    def add_joint(self, name, parent, rest_world, rotate_order=0, rotate_axis=(0.0, 0.0, 0.0)):
        """A joint at rest with its turn in jointOrient. Returns its path."""
        path = self._new("joint", name, parent)
        local = product(rest_world, inverse(self.world(parent) if parent else IDENTITY))
        orient = product(inverse(rotation(rotate_axis)), local)
        self.value[path].update(translate=local[12:15], jointOrient=angles_of(orient), rotateOrder=rotate_order,
                                rotateAxis=tuple(rotate_axis))
        return path

    def pose(self, values):
        """Sets attributes, {plug: value}, for what is read from now on."""
        for plug, value in values.items():
            node, attribute = self._split(plug)
            self.value[node][attribute] = value
        self.known = {}

    def world(self, node):
        return self._get(self._path(node), "worldMatrix[0]")

    # --- Nodes ---

    def _new(self, kind, name, parent=None):
        path = f"{parent or ''}|{name}" if kind in ("transform", "joint") else name
        if path in self.kind:
            raise RuntimeError(f"'{name}' exists")
        self.kind[path], self.value[path] = kind, dict(DEFAULTS[kind])
        if parent:
            self.parent_of[path] = parent
        return path

    def _path(self, name):
        found = [path for path in self.kind if path == name or path.endswith("|" + name)]
        if len(found) != 1:
            raise RuntimeError(f"{len(found)} nodes are called '{name}'")
        return found[0]

    def _split(self, plug):
        node, attribute = plug.split(".", 1)
        return self._path(node), {"tx": "translateX"}.get(attribute, attribute)

    def _holds(self, node, attribute):
        kind = self.kind[node]
        return attribute in self.value[node] or attribute in DEFAULTS[kind] or attribute in COMPUTED or (
            kind == "multMatrix" and attribute.startswith("matrixIn["))

    def _get(self, node, attribute):
        key = (node, attribute)
        if key not in self.known:
            source = self.source.get(key)
            self.known[key] = self._get(*source) if source else (
                self._computed(node, attribute) if attribute in COMPUTED else self.value[node][attribute])
        return self.known[key]

    def _computed(self, node, attribute):
        get = lambda name: self._get(node, name)  # noqa: E731
        kind = self.kind[node]
        if (kind, attribute) == ("multiplyDivide", "output"):
            assert get("operation") == 1
            return tuple(a * b for a, b in zip(get("input1"), get("input2")))
        if (kind, attribute) == ("composeMatrix", "outputMatrix"):
            return moved_to(rotation(get("inputRotate"), get("inputRotateOrder")), get("inputTranslate"))
        if (kind, attribute) == ("multMatrix", "matrixSum"):
            slots = sorted({int(name[9:-1]) for name in self.value[node] if name.startswith("matrixIn[")} | {
                int(name[9:-1]) for at, name in self.source if at == node})
            out = IDENTITY
            for slot in slots:
                out = product(out, get(f"matrixIn[{slot}]"))
            return out
        if kind == "decomposeMatrix":
            matrix = get("inputMatrix")
            return matrix[12:15] if attribute == "outputTranslate" else angles_of(matrix, get("inputRotateOrder"))
        parent = self.parent_of.get(node)
        above = self._get(parent, "worldMatrix[0]") if parent else IDENTITY
        if attribute == "parentInverseMatrix[0]":
            return inverse(above)
        turn = product(rotation(get("rotateAxis")), rotation(get("rotate"), get("rotateOrder")))
        if kind == "joint":
            turn = product(turn, rotation(get("jointOrient")))
        local = moved_to(turn, get("translate"))
        return local if attribute == "matrix" else product(product(local, get("offsetParentMatrix")), above)

    # --- maya.cmds ---

    def createNode(self, kind, name, skipSelect):
        while any(path.rsplit("|", 1)[-1] == name for path in self.kind):
            name += "1"
        return self._new(kind, name)

    def setAttr(self, plug, *values, type=None, lock=None, keyable=None):
        node, attribute = self._split(plug)
        if lock is not None:
            self.locked.add((node, attribute))
            return
        if (node, attribute) in self.source or (node, attribute) in self.locked:
            raise RuntimeError(f"'{plug}' is connected or locked")
        if not self._holds(node, attribute) or attribute in COMPUTED:
            raise RuntimeError(f"no such attribute: {plug}")
        if type in ("matrix", "double3"):
            assert len(values) == (16 if type == "matrix" else 3)
            value = tuple(float(v) for v in values)
        else:
            (value,) = values
        self.value[node][attribute] = value
        self.known = {}

    def getAttr(self, plug, lock=False):
        node, attribute = self._split(plug)
        if lock:
            return (node, attribute) in self.locked
        value = self._get(node, attribute)
        return [value] if isinstance(value, tuple) and len(value) == 3 else list(value) if isinstance(value, tuple) else value

    def connectAttr(self, source, target):
        (a, out), (b, into) = self._split(source), self._split(target)
        if not self._holds(a, out) or not self._holds(b, into) or into in COMPUTED:
            raise RuntimeError(f"no such attributes: {source}, {target}")
        if (b, into) in self.source or (b, into) in self.locked:
            raise RuntimeError(f"'{target}' has an input")
        self.source[(b, into)] = (a, out)
        self.known = {}

    def listConnections(self, plug, source, destination):
        return [".".join(self.source[self._split(plug)])] if self._split(plug) in self.source else None

    def ls(self, *names, long, type):
        out = []
        for path, kind in self.kind.items():
            short = path.rsplit("|", 1)[-1]
            alike = [name for name in names if short == name or (
                name.startswith("*:") and ":" in short and short.rsplit(":", 1)[-1] == name[2:])]
            if alike and kind == type:
                out.append(path)
        return out

    def listRelatives(self, node, parent, fullPath):
        above = self.parent_of.get(self._path(node))
        return [above] if above else None

    def upAxis(self, query, axis):
        return self.up

    def pluginInfo(self, name, query, loaded):
        return False

    def loadPlugin(self, name, quiet):
        assert name == "matrixNodes"

    def objExists(self, name):
        return any(path == name or path.endswith("|" + name) for path in self.kind)

    def curve(self, name, degree, point):
        return self._new("transform", name)

    def parent(self, child, above, relative):
        old, new = self._path(child), self._path(above)
        path = f"{new}|{old.rsplit('|', 1)[-1]}"
        self.kind[path], self.value[path], self.parent_of[path] = self.kind.pop(old), self.value.pop(old), new
        return [path]

    def transformLimits(self, node, **limits):
        self.limits.setdefault(self._path(node), {}).update(limits)

    def rename(self, old, new):
        self.kind[new], self.value[new] = self.kind.pop(old), self.value.pop(old)
        return new

    def addAttr(self, node, longName, dataType):
        self.value[self._path(node)][longName] = ""

    def delete(self, node):
        gone = self._path(node)
        for path in [path for path in self.kind if path == gone or path.startswith(gone + "|")]:
            del self.kind[path], self.value[path]
            self.parent_of.pop(path, None)
            # What it drove keeps the value that it had last.
            for (at, attribute), (by, out) in list(self.source.items()):
                if at == path or by == path:
                    del self.source[(at, attribute)]
        self.known = {}

    def undoInfo(self, **chunk):
        pass
