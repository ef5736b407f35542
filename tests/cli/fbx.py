"""Binary FBX as a tree of records that can be changed and written again."""

import dataclasses
import struct
import zlib

NUMBERS = {"Y": "<h", "C": "<b", "I": "<i", "F": "<f", "D": "<d", "L": "<q"}
ARRAYS = {"f": "f", "d": "d", "l": "q", "i": "i", "b": "b"}


@dataclasses.dataclass
class Record:
    name: bytes
    values: list  # (letter, value)
    children: list
    is_list: bool  # an empty record ends its children

    def all(self, name):
        return [child for child in self.children if child.name == name]


class Fbx:
    """The tree of a file of version 7.0 and later."""

    def __init__(self, data):
        self.head, self.records, at = data[:27], [], 27
        self.sizes = "<QQQ" if struct.unpack_from("<I", data, 23)[0] >= 7500 else "<III"
        self.empty = bytes(struct.calcsize(self.sizes) + 1)
        while True:
            record, at = self._record(data, at)
            if record is None:
                break
            self.records.append(record)
        self.tail = data[at:]

    def _record(self, data, at):
        end, count, _ = struct.unpack_from(self.sizes, data, at)
        at += len(self.empty)
        name = data[at:at + data[at - 1]]
        at += len(name)
        if end == 0:
            return None, at
        values = []
        for _ in range(count):
            letter = chr(data[at])
            at += 1
            if letter in NUMBERS:
                values.append((letter, struct.unpack_from(NUMBERS[letter], data, at)[0]))
                at += struct.calcsize(NUMBERS[letter])
            elif letter in ARRAYS:
                length, packed, bytes_ = struct.unpack_from("<III", data, at)
                raw = data[at + 12:at + 12 + bytes_]
                values.append((letter, list(struct.unpack(f"<{length}{ARRAYS[letter]}", zlib.decompress(raw) if packed else raw))))
                at += 12 + bytes_
            else:
                length = struct.unpack_from("<I", data, at)[0]
                values.append((letter, data[at + 4:at + 4 + length]))
                at += 4 + length
        children, is_list = [], False
        while at < end:
            child, at = self._record(data, at)
            if child is None:
                is_list = True
                break
            children.append(child)
        return Record(name, values, children, is_list), end

    def write(self):
        out = bytearray(self.head)
        for record in self.records:
            self._write(record, out)
        return bytes(out + self.empty + self.tail)

    def _write(self, record, out):
        start = len(out)
        out += self.empty[1:] + bytes([len(record.name)]) + record.name
        begin = len(out)
        for letter, value in record.values:
            out += letter.encode()
            if letter in NUMBERS:
                out += struct.pack(NUMBERS[letter], value)
            elif letter in ARRAYS:
                raw = struct.pack(f"<{len(value)}{ARRAYS[letter]}", *value)
                out += struct.pack("<III", len(value), 0, len(raw)) + raw
            else:
                out += struct.pack("<I", len(value)) + value
        size = len(out) - begin
        for child in record.children:
            self._write(child, out)
        if record.is_list:
            out += self.empty
        struct.pack_into(self.sizes, out, start, len(out), len(record.values), size)

    def objects(self, kind):
        return next(record for record in self.records if record.name == b"Objects").all(kind)


def with_geometric_transform(data, move, degrees_about_z, scale, redrawn=True):
    """The same body, drawn elsewhere and brought to its place by its nodes' geometric transforms; not redrawn, it is moved by them.
    Quarter turns alone."""
    fbx = Fbx(data)
    for model in fbx.objects(b"Model"):
        if model.values[2][1] != b"Mesh":
            continue
        properties = model.all(b"Properties70")[0].children
        for name, value in ((b"GeometricTranslation", move), (b"GeometricRotation", (0.0, 0.0, degrees_about_z)), (b"GeometricScaling", (scale,) * 3)):
            properties[:] = [one for one in properties if one.values[0][1] != name]
            properties.append(Record(b"P", [("S", name), ("S", b"Vector3D"), ("S", b"Vector"), ("S", b""), *(("D", float(v)) for v in value)],
                                     [], False))
    if not redrawn:
        return fbx.write()
    cosine, sine = {0: (1, 0), 90: (0, 1), 180: (-1, 0), 270: (0, -1)}[degrees_about_z % 360]
    for geometry in fbx.objects(b"Geometry"):
        for vertices in geometry.all(b"Vertices"):
            flat = vertices.values[0][1]
            for i in range(0, len(flat), 3):
                x, y, z = ((flat[i + axis] - move[axis]) / scale for axis in range(3))
                flat[i:i + 3] = cosine * x + sine * y, cosine * y - sine * x, z
    return fbx.write()
