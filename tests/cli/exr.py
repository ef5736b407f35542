"""A reader of OpenEXR files that shares nothing with the program's own: scanlines, uncompressed or
ZIP, written from the format's published description. Plain Python."""

import array
import itertools
import json
import struct
import zlib

ROWS_OF_BLOCK = {0: 1, 2: 1, 3: 16}  # by compression: none, ZIPS, ZIP


class Exr:
    """attributes: name -> raw bytes; channels: name -> row after row of floats."""

    def __init__(self, path):
        data = path.read_bytes()
        if data[:4] != b"\x76\x2f\x31\x01" or data[5] & 0x1A:
            raise ValueError(f"{path} is no plain scanline EXR")
        self.attributes, at = {}, 8
        while data[at]:
            name, at = _word(data, at)
            _, at = _word(data, at)
            (size,) = struct.unpack_from("<i", data, at)
            self.attributes[name] = data[at + 4:at + 4 + size]
            at += 4 + size
        at += 1
        left, top, right, bottom = struct.unpack("<4i", self.attributes["dataWindow"])
        self.width, self.height = right - left + 1, bottom - top + 1
        kinds = _channel_list(self.attributes["channels"])
        self.channels = {name: array.array("f") for name, _ in kinds}
        rows = ROWS_OF_BLOCK[self.attributes["compression"][0]]
        row_bytes = self.width * sum(2 if half else 4 for _, half in kinds)
        for offset in struct.unpack_from(f"<{-(-self.height // rows)}Q", data, at):
            y, size = struct.unpack_from("<ii", data, offset)
            count = min(rows, bottom - y + 1)
            block = data[offset + 8:offset + 8 + size]
            if size < row_bytes * count:
                block = _unpacked(block)
            self._take(block, kinds)

    def _take(self, block, kinds):
        at = 0
        while at < len(block):
            for name, half in kinds:
                size = self.width * (2 if half else 4)
                row = block[at:at + size]
                self.channels[name].extend(struct.unpack(f"<{self.width}e", row) if half else array.array("f", row))
                at += size

    def text(self, attribute):
        return self.attributes[attribute].decode()

    def matrix(self, attribute):
        """Four rows; multiplies row vectors from the right, as the format has it."""
        values = struct.unpack("<16f", self.attributes[attribute])
        return [list(values[i:i + 4]) for i in range(0, 16, 4)]

    def manifest(self, layer):
        """Names of a Cryptomatte layer -> the value that stands for them."""
        (prefix,) = [name[:-len("name")] for name in self.attributes
                     if name.startswith("cryptomatte/") and name.endswith("/name") and self.text(name) == layer]
        return {name: struct.unpack("<f", struct.pack("<I", int(digits, 16)))[0]
                for name, digits in json.loads(self.text(prefix + "manifest")).items()}

    def matte(self, layer, name):
        """How much of each pixel shows `name`."""
        wanted, total = self.manifest(layer)[name], array.array("f", bytes(4 * self.width * self.height))
        for rank in range(6):
            prefix = f"{layer}{rank // 2:02}."
            ids, coverage = (self.channels[prefix + c] for c in ("rg" if rank % 2 == 0 else "ba"))
            for pixel, found in enumerate(ids):
                if found == wanted:
                    total[pixel] += coverage[pixel]
        return total


def _word(data, at):
    end = data.index(0, at)
    return data[at:end].decode(), end + 1


def _channel_list(data):
    kinds, at = [], 0
    while data[at]:
        name, at = _word(data, at)
        (kind,) = struct.unpack_from("<i", data, at)
        if kind not in (1, 2):
            raise ValueError(f"channel {name} holds neither half nor float")
        kinds.append((name, kind == 1))
        at += 16
    return kinds


def _unpacked(block):
    """Undoes deflate, then the differences, then the split into even and odd bytes."""
    data = zlib.decompress(block)
    data = bytes(itertools.accumulate(data, lambda before, step: (before + step - 128) & 255))
    whole, half = bytearray(len(data)), (len(data) + 1) // 2
    whole[0::2], whole[1::2] = data[:half], data[half:]
    return bytes(whole)
