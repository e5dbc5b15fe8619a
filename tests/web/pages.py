# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the pages that are exported, with the standard library and NumPy alone."""

import base64
import gzip
import json
import re
import struct

import numpy as np

PART = re.compile(r'<script type="([a-z/]+)" id="([\w-]+)">(.*?)</script>', re.DOTALL)


class ReadPage:
    """A page: its text, its description, and its files by their names."""

    def __init__(self, path):
        self.text = path.read_text(encoding="utf-8")
        parts = {name: (kind, text) for kind, name, text in PART.findall(self.text)}
        self.description = json.loads(parts.pop("prt-scene")[1])
        self.files = {name: gzip.decompress(base64.b64decode(text)) for name, (_, text) in parts.items()}
        self.packed_sizes = {name: len(base64.b64decode(text)) for name, (_, text) in parts.items()}
        model = self.files["prt-model"]
        length = struct.unpack_from("<I", model, 12)[0]
        self.document = json.loads(model[20 : 20 + length])
        self._binary = model[28 + length :]

    def view(self, index):
        """The bytes of a buffer view."""
        view = self.document["bufferViews"][index]
        return self._binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]

    def backs(self, primitive):
        """(N, 9, 4) transport of backs and its direct part, as it was packed; None if there is none."""
        packed = primitive["extras"]["prt_relight"]
        if "backs" not in packed:
            return None
        numbers = self._rows(packed["backs"]["view"], primitive, 12 if packed["direct"] else 11)
        red, green = numbers[:, 9] / 255, numbers[:, 10] / 255
        share = numbers[:, 11] / 255 if packed["direct"] else np.zeros(len(numbers))
        factors = np.stack([red, green, 3.0 - red - green, share], axis=1)
        return packed["backs"]["scale"] * numbers[:, :9, None] * factors[:, None]

    def transport(self, primitive):
        """(N, 9, 3) as it was packed: number after number, from vertex to vertex."""
        parts = self.parts(primitive)
        return parts[..., :3] + parts[..., 3:].sum(axis=-1, keepdims=True)

    def parts(self, primitive):
        """(N, 9, 3) transport, or, where the direct part is kept separately, (N, 9, 4) bounces and that."""
        packed = primitive["extras"]["prt_relight"]
        channels = 4 if packed["direct"] else 3
        rows = self._rows(packed["view"], primitive, 9 * channels)
        numbers = rows.reshape(len(rows), 9, channels)
        for channel, tint in zip((0, 2), packed["tints"], strict=True):
            numbers[:, :, channel] += (numbers[:, :, 1] * tint + 128) // 256
        return numbers * packed["scale"]

    def _rows(self, view, primitive, columns):
        """(N, columns) whole numbers, which are packed as differences from vertex to vertex."""
        vertices = self.document["accessors"][primitive["attributes"]["POSITION"]]["count"]
        planes = np.frombuffer(self.view(view), dtype=np.uint8).reshape(2, columns, vertices).astype(int)
        codes = planes[0] + 256 * planes[1]
        return np.cumsum(np.where(codes % 2, -(codes + 1) // 2, codes // 2), axis=1).T
